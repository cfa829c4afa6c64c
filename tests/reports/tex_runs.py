"""A LaTeX document compiled, and what its log must not say."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from takagi.reports.output import write_folder

# Where the body stands: in its own document, or in papers with the packages that it names.
PAPERS = {
    "alone": "",
    "article": r"\documentclass{article}\usepackage[margin=25mm]{geometry}",
    "article, two columns": r"\documentclass[twocolumn]{article}\usepackage[margin=20mm]{geometry}",
    "IEEEtran": r"\documentclass[journal,onecolumn]{IEEEtran}",
    "IEEEtran, two columns": r"\documentclass[journal]{IEEEtran}",
}


def compiled(folder: Path, files: dict[str, bytes | str], paper: str = "alone") -> str:
    if PAPERS[paper]:
        start = r"\appendices" if "IEEE" in paper else r"\appendix"
        files = files | {
            "appendix.tex": PAPERS[paper]
            + r"\usepackage{amsmath,amssymb,booktabs,array,graphicx}"
            + rf"\begin{{document}}{start}\input{{appendix-body}}"
            r"\bibliographystyle{plain}\bibliography{appendix}\end{document}"
        }
    write_folder(folder, files)
    latex = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "appendix.tex"]
    for command in (latex, ["bibtex", "appendix"], latex, latex):
        run = subprocess.run(command, cwd=folder, capture_output=True, check=False, timeout=120)
        log = (folder / "appendix.log").read_text(encoding="latin-1")
        assert run.returncode == 0, log[-3000:] + run.stdout.decode("latin-1")[-500:]
    return log


def sound(log: str) -> None:
    """No undefined or doubled reference, nothing that leaves line or page, no stale reference."""
    assert not re.findall(r"LaTeX Warning: (?:Reference|Citation|Label|There were).*", log)
    assert not re.findall(r"Warning:.*[Rr]erun.*", log)
    # Bitmap fonts are made on the spot where they are missing, and look poor on a screen.
    assert not re.findall(r"\S+pk>", log)
    assert not re.findall(r"Overfull \\[hv]box.*", log)
