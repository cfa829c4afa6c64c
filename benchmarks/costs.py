"""Measures what designs, checks and simulations cost, in units of an import of numpy.

    python benchmarks/costs.py                 writes a table into docs/benchmarks.md
    python benchmarks/costs.py --built-in      leaves out the plants of the gallery: minutes less
    python benchmarks/costs.py --only check    measures the rows with this word, and prints them

Each command is a process of its own, with compiled bytecode and one thread for linear algebra.  Its
processor time, of user and system, is divided by that of ``python -c 'import numpy'``, measured
before it.  The larger rows are the median of three runs; plants and turbine are designed once.
Nothing is asserted.
"""

from __future__ import annotations

import argparse
import compileall
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from measure import PAGE, placed, reduced, table, verb

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ("models", "lmi", "certificates", "reports", "cli")
REPEATS, UNIT_REPEATS = 3, 3
FEW_RULES = 16
# Words of the rows that the page shows.
ON_PAGE = (
    "`pdc`",
    "cart_pole |",
    "cart_pole` |",
    "simulate",
    "median",
    "the largest: furuta",
    "nrel5mw",
)
# A problem of two rules, from the page on LMIs.
PDC = """
from takagi.lmi import pdc
from takagi.models import TSModel
A = [[[0, 1], [17.3, 0]], [[0, 1], [9.4, 0]]]
B = [[[0], [-0.18]], [[0], [-0.15]]]
assert pdc(TSModel(A, B), decay_rate=0.5, relaxation="tanaka-wang").gains is not None
"""


class Cost(NamedTuple):
    """Processor time in units, and in seconds."""

    units: float
    seconds: float


class Plant(NamedTuple):
    """What one plant costs: law and proof alone, and with the report."""

    name: str
    rules: int
    states: int
    law: Cost
    whole: Cost


def main() -> None:
    """Measure, and write the table into the page; print it too."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="measure the rows that have this word")
    parser.add_argument("--built-in", action="store_true", help="leave out the gallery's plants")
    options = parser.parse_args()
    only: str = options.only
    for floor in FLOORS:
        compileall.compile_dir(ROOT / floor, quiet=1)
    with tempfile.TemporaryDirectory() as place:
        rows = measured(Path(place), only, gallery=not options.built_in)
    heads = ("command", "units", "processor time", "aim [units]")
    found = table(heads, [(name, f"{c.units:.1f}", f"{c.seconds:.2f} s", a) for name, c, a in rows])
    print(found)
    if not only:
        text = placed(PAGE.read_text(encoding="utf-8"), "costs", reduced(found, (0, 1, 2), ON_PAGE))
        PAGE.write_text(text, encoding="utf-8")


Row = tuple[str, Cost, str]


def measured(place: Path, only: str, *, gallery: bool) -> list[Row]:
    """Return the rows whose names have the word; all of them for an empty one."""
    pole, turbine = place / "cart_pole", place / "nrel5mw"
    design, no_report = verb("design", "cart_pole", "--out", str(pole)), ("--no-report", "--force")
    cost(*design, "--force")
    rows: list[Row] = []

    def add(name: str, aim: str, *arguments: str, repeats: int = REPEATS) -> None:
        if only in name:
            runs = [cost(*arguments) for _ in range(repeats)]
            rows.append((name, statistics.median_low(runs), aim))

    add("`import takagi.lmi` and one `pdc`", "5", "-c", PDC)
    add("`takagi check`, cart_pole", "2.5", *verb("check", str(pole)))
    simulated = verb("simulate", str(pole), "--out", str(place / "runs"))
    add("`takagi simulate`, cart_pole", "8", *simulated)
    add("`takagi design cart_pole --no-report`", "15", *design, *no_report)
    add("`takagi design cart_pole`", "35", *design, "--force")
    if only in "plants":
        rows += of_plants([plant(path, place) for path in plant_files(gallery=gallery)])
    name = "`takagi design nrel5mw`"
    add(name, "300", *verb("design", "nrel5mw", "--out", str(turbine), "--force"), repeats=1)
    if turbine.is_dir():
        add("`takagi check`, nrel5mw", "8", *verb("check", str(turbine)))
    return rows


def of_plants(plants: Sequence[Plant]) -> list[Row]:
    """Return the largest cost of small plants, the median of all, and the largest of large ones."""
    built_in = [p for p in plants if not Path(p.name).is_absolute()]
    small = [p for p in built_in if p.rules <= FEW_RULES and p.states < 12]
    law, whole = max(small, key=lambda p: p.law), max(small, key=lambda p: p.whole)
    middle = sorted(plants, key=lambda p: p.whole)[len(plants) // 2]
    largest = max(plants, key=lambda p: p.whole)
    few = f"{len(small)} built-in plants of at most {FEW_RULES} rules, the largest"
    every = f"{len(plants)} plants"
    return [
        (f"`takagi design --no-report`, {few}: {label(law)}", law.law, "15"),
        (f"`takagi design`, {few}: {label(whole)}", whole.whole, "35"),
        (f"`takagi design`, {every}, the median: {label(middle)}", middle.whole, "45"),
        (f"`takagi design`, {every}, the largest: {label(largest)}", largest.whole, "300"),
    ]


def label(plant: Plant) -> str:
    rules = f"{plant.rules} rule{'' if plant.rules == 1 else 's'}"
    return f"{Path(plant.name).stem}, {rules}, {plant.states} states"


def plant_files(*, gallery: bool) -> list[str]:
    """Return the names of built-in plants, and the files of the gallery."""
    listed = subprocess.run(
        [sys.executable, *verb("models", "--json")], check=True, capture_output=True, text=True
    )
    names = [entry["name"] for entry in json.loads(listed.stdout) if entry["kind"] == "plant"]
    files = sorted((ROOT / "tests/gallery/plants").glob("*.toml"))
    return [*names, *(map(str, files) if gallery else ())]


def plant(name: str, place: Path) -> Plant:
    """Return what a plant costs; it is designed twice."""
    out = place / Path(name).stem
    words = verb("design", name, "--out", str(out), "--force")
    law, whole = cost(*words, "--no-report"), cost(*words)
    document = json.loads((out / "certificate.json").read_text(encoding="utf-8"))
    gains = document.get("gains") or {}
    return Plant(name, len(gains.get("rules", [()])), len(document["model"]["states"]), law, whole)


def cost(*arguments: str) -> Cost:
    """Return the processor time of a Python process of its own, in units and seconds."""
    unit = statistics.median(spent("-c", "import numpy") for _ in range(UNIT_REPEATS))
    seconds = spent(*arguments)
    return Cost(seconds / unit, seconds)


def spent(*arguments: str) -> float:
    """Return the processor time [s] of a Python process and all that it started."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        env=environment, check=False,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    main()
