"""Measures what docs/benchmarks.md says about speed, and writes its tables.

Run it by ``make bench``, or ``python benchmarks/measure.py``.  Nothing is asserted: times depend on
the machine, so beside each stands its ratio to another one of the same run.
"""

from __future__ import annotations

import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

PAGE = Path(__file__).resolve().parents[1] / "docs" / "benchmarks.md"
REPEATS = 9
LIBRARIES = ("numpy", "scipy", "sympy", "clarabel", "matplotlib")


class Times(NamedTuple):
    """Best and median of repeated runs [s]."""

    best: float
    median: float


def main() -> None:
    """Measure, and write the tables into the page; print them too."""
    before = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "nrel5mw"
        start = cold("-c", "pass")
        help_, models = cold(*verb("--help")), cold(*verb("models"))
        wall, answer = designed(out)
        check = cold(*verb("check", str(out / "certificate.json")))
        sizes = {name: (out / name).stat().st_size for name in SIZED}
    tables = {
        "machine": machine(before),
        "commands": commands(start, help_, models, check, wall),
        "steps": steps(wall, answer["seconds"]),
        "sizes": sizes_table(sizes),
    }
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables.items():
        text = placed(text, name, table)
        print(f"{table}\n")
    PAGE.write_text(text, encoding="utf-8")


SIZED = ("certificate.json", "gains.json", "report.html")


# ------------------------------------------------------------------ processes


def verb(*arguments: str) -> tuple[str, ...]:
    """Return the arguments of Python that run a verb as the installed command does."""
    return "-c", "import sys; from takagi.cli.main import main; sys.exit(main())", *arguments


def cold(*arguments: str) -> Times:
    """Return the times of a Python process of its own, from start to end."""
    spent = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
        spent.append(time.perf_counter() - began)
    return Times(min(spent), statistics.median(spent))


def designed(out: Path) -> tuple[float, Mapping[str, Any]]:
    """Return the time of `takagi design nrel5mw --out` as a process, and its answer."""
    began = time.perf_counter()
    command = [sys.executable, *verb("design", "nrel5mw", "--out", str(out), "--json")]
    ran = subprocess.run(command, check=True, capture_output=True, text=True)
    return time.perf_counter() - began, json.loads(ran.stdout)


# ------------------------------------------------------------------ tables


def commands(start: Times, help_: Times, models: Times, check: Times, wall: float) -> str:
    """Return the table of processes, each beside the start of a bare interpreter."""
    rows = [
        (f"`{name}`", seconds(spent.best), seconds(spent.median), ratio(spent, start))
        for name, spent in (
            ("python -c pass", start),
            ("takagi --help", help_),
            ("takagi models", models),
            ("takagi check certificate.json", check),
            ("takagi design nrel5mw --out DIR", Times(wall, wall)),
        )
    ]
    return table(("process, cold", "best", "median", "times interpreter start"), rows)


def ratio(spent: Times, unit: Times) -> str:
    return f"{spent.best / unit.best:.1f}"


def steps(wall: float, spent: Mapping[str, float]) -> str:
    """Return the table of the design's steps; what is left is imports, report and writing."""
    rest = wall - sum(spent.values())
    analysis = next(value for name, value in spent.items() if name.startswith("joint analysis"))
    rows = [
        (name, seconds(value), f"{100 * value / wall:.0f} %", f"{value / analysis:.2f}")
        for name, value in {**spent, "start, simulations, report, figures, writing": rest}.items()
    ]
    rows.append(("all", seconds(wall), "100 %", f"{wall / analysis:.2f}"))
    return table(("step of `takagi design nrel5mw`", "time", "share", "times joint analysis"), rows)


def sizes_table(sizes: Mapping[str, int]) -> str:
    return table(("file", "size"), [(f"`{n}`", f"{s / 1e3:.0f} kB") for n, s in sizes.items()])


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


def placed(text: str, name: str, content: str) -> str:
    """Return the page with the part between its two marks replaced."""
    begin, end = f"<!-- {name} -->", f"<!-- end {name} -->"
    head, rest = text.split(begin, 1)
    return f"{head}{begin}\n{content}\n{end}{rest.split(end, 1)[1]}"


if __name__ == "__main__":
    main()
