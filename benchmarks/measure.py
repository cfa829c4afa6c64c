"""Measures what docs/benchmarks.md says about speed, and writes its tables.

Run it by ``make bench``, or ``python benchmarks/measure.py``.  Nothing is asserted: times depend on
the machine, so beside each stands its ratio to another one of the same run.
"""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "docs" / "benchmarks.md"
REPEATS = 9
LIBRARIES = ("numpy", "scipy", "sympy", "clarabel", "matplotlib")


def main() -> None:
    """Measure, and write the tables into the page; print them too."""
    before = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "nrel5mw"
        start = cold("-c", "pass")
        help_, models = cold(*verb("--help")), cold(*verb("models"))
        wall = designed(out)
        check = cold(*verb("check", str(out / "certificate.json")))
    tables = {
        "machine": machine(before),
        "commands": commands(start, help_, models, check, wall),
    }
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables.items():
        text = placed(text, name, table)
        print(f"{table}\n")
    PAGE.write_text(text, encoding="utf-8")


# ------------------------------------------------------------------ processes


def verb(*arguments: str) -> tuple[str, ...]:
    """Return the arguments of Python that run a verb as the installed command does."""
    return "-c", "import sys; from takagi.cli.main import main; sys.exit(main())", *arguments


def cold(*arguments: str) -> float:
    """Return the least time of a Python process of its own, from start to end [s]."""
    spent = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
        spent.append(time.perf_counter() - began)
    return min(spent)


def designed(out: Path) -> float:
    """Return the time of `takagi design nrel5mw --out` as a process."""
    began = time.perf_counter()
    command = [sys.executable, *verb("design", "nrel5mw", "--out", str(out))]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - began


# ------------------------------------------------------------------ tables


def commands(start: float, help_: float, models: float, check: float, wall: float) -> str:
    """Return the table of processes, each beside the start of a bare interpreter."""
    rows = [
        (f"`{name}`", seconds(spent), f"{spent / start:.1f}")
        for name, spent in (
            ("python -c pass", start),
            ("takagi --help", help_),
            ("takagi models", models),
            ("takagi check certificate.json", check),
            ("takagi design nrel5mw --out DIR", wall),
        )
    ]
    return table(("process, cold", "best", "times interpreter start"), rows)


def machine(load: float) -> str:
    """Return what the numbers were measured on; no name of a machine or a person."""
    parts = [
        f"{os.cpu_count()} cores ({_processor()})",
        platform.system(),
        f"Python {platform.python_version()}",
        *(f"{name} {version(name)}" for name in LIBRARIES),
        f"load {load:.1f} before the run",
    ]
    return ", ".join(parts) + "."


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    if listing.is_file():
        found = re.search(r"model name\s*:\s*(.+)", listing.read_text(encoding="utf-8"))
        if found:
            return found.group(1).strip()
    return platform.machine()


def seconds(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1 else f"{value:.3g} s"


def table(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [heads, tuple("---" for _ in heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def summary(content: str) -> str:
    """Return the head of a table and its last row, the sums."""
    lines = content.splitlines()
    return "\n".join([*lines[:2], lines[-1]])


def reduced(content: str, columns: Sequence[int], words: Sequence[str] = ("",)) -> str:
    """Return these columns of a table, and of its rows those with one of the words."""
    head, rule, *rows = content.splitlines()
    chosen = [head, rule, *(row for row in rows if any(word in row for word in words))]
    cells = [line.strip("| ").split(" | ") for line in chosen]
    return "\n".join(f"| {' | '.join(line[n] for n in columns)} |" for line in cells)


def placed(text: str, name: str, content: str) -> str:
    """Return the page with the part between its two marks replaced."""
    begin, end = f"<!-- {name} -->", f"<!-- end {name} -->"
    head, rest = text.split(begin, 1)
    return f"{head}{begin}\n{content}\n{end}{rest.split(end, 1)[1]}"


if __name__ == "__main__":
    main()
