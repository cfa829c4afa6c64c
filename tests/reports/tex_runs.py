"""A LaTeX document compiled, and what its log must not say."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from takagi.reports.output import write_folder

WIDEST = 20.0  # pt that a line may stick out


def compiled(folder: Path, files: dict[str, bytes | str]) -> str:
    """The log of the last of three runs; the first error of any run fails the test."""
    write_folder(folder, files)
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "appendix.tex"]
    for _ in range(3):
        run = subprocess.run(command, cwd=folder, capture_output=True, check=False, timeout=120)
        log = (folder / "appendix.log").read_text(encoding="latin-1")
        assert run.returncode == 0, log[-3000:]
    return log


def sound(log: str, boxes: str = "h") -> None:
    """No undefined or doubled reference, nothing that leaves the page, no stale reference.

    Parameters
    ----------
    boxes : "h", lines may not be too wide; "hv", nor pages too high.
    """
    assert not re.findall(r"LaTeX Warning: (?:Reference|Citation|Label|There were).*", log)
    assert not re.findall(r"Warning:.*[Rr]erun.*", log)
    # Bitmap fonts are made on the spot where they are missing, and look poor on a screen.
    assert not re.findall(r"\S+pk>", log)
    over = re.findall(rf"Overfull \\[{boxes}]box \(([\d.]+)pt", log)
    assert max(map(float, over), default=0.0) <= WIDEST
