"""Measures many runs on the validation plant, and writes a table into docs/benchmarks.md.

    python benchmarks/validation_plant.py [--rosco PYTHON]

A hundred cases of 600 s: three laws in normal turbulence of class B, means from 5 to 23 m/s and
several seeds, with all metrics, in as many threads as there are cores.  Beside it one case on one
thread, with the laws as programs and as Python objects.

With ``--rosco`` an interpreter that has the package ``rosco`` runs that package's own simulator (a
rotor and nothing else, 40 steps a second) with its controller in the wind of the one case.  Nothing
is asserted.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from measure import PAGE, placed, reduced, table

from takagi.models import Turbine, nrel5mw
from takagi.models.laws.protocol import SampledLaw, law_words
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.wind import WindSeries
from takagi.reports.simulation.compiled_law import SampledLoop
from takagi.reports.simulation.laws import ChosenLaws, chosen_laws
from takagi.reports.simulation.runs import PlantParts, run_simulation, simulation_plant
from takagi.reports.simulation.winds import requested_winds

DURATION, CASES = 600.0, 100
LAWS = ("coherent", "paper", "baseline")
MEANS = (5.0, 7.0, 9.0, 11.0, 12.0, 13.0, 15.0, 17.0, 19.0, 21.0, 23.0)
SEEDS = 4
REPEATS = 3
ROSCO = Path(__file__).with_name("rosco_simulation.py")


class Times(NamedTuple):
    """Time by the clock on the wall, and of cores [s]."""

    wall: float
    core: float


def main() -> None:
    """Measure, and write the table into the page; print it too."""
    reader = argparse.ArgumentParser()
    reader.add_argument("--rosco", metavar="PYTHON", help="an interpreter with the package rosco")
    asked = reader.parse_args()
    turbine = nrel5mw()
    laws = chosen_laws(turbine, LAWS)
    winds = requested_winds(
        turbine, [f"turbulent:{mean:g}:B:1-{SEEDS}" for mean in MEANS], duration=DURATION
    )
    # Compiling, or reading what was compiled, is no part of it.
    run_simulation(turbine, laws, winds[:1], series=False)
    many, count = batch(turbine, laws, winds)
    ours = {name: single(turbine, laws, name, winds[12]) for name in LAWS}
    unit = ours["coherent"][0]
    title = f"{count} cases of {DURATION:g} s with their metrics, {os.cpu_count()} threads"
    rows = [(title, *figures(many, count * DURATION, unit))]
    for name, (compiled, python) in ours.items():
        rows.append((f"one case, {law_words(name)}", *figures(compiled, DURATION, unit)))
        rows.append(("the same, the law as a Python object", *figures(python, DURATION, unit)))
    if asked.rosco:
        other = rosco(asked.rosco, winds[12])
        rows.append(("one case, ROSCO's Python simulator", *figures(other, DURATION, unit)))
    heads = (
        "runs on the validation plant",
        "time",
        "of a core",
        "simulated s a core s",
        "times one case",
    )
    text = table(heads, rows)
    print(text)
    short = reduced(text, (0, 1, 3), ("cases", "one case"))
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "plant", short), encoding="utf-8")


def batch(turbine: Turbine, laws: ChosenLaws, winds: tuple[WindSeries, ...]) -> tuple[Times, int]:
    """Return the times of the hundred cases, and how many they are."""
    count = CASES // len(laws.laws)
    began = now()
    found = run_simulation(turbine, laws, winds[:count], series=False)
    return since(began), len(found.runs)


def single(turbine: Turbine, laws: ChosenLaws, name: str, wind: WindSeries) -> tuple[Times, Times]:
    """Return the times of one case on one thread: compiled, and in Python."""
    plant, law = simulation_plant(turbine, PlantParts()), laws.laws[name]
    observer = None if name == "baseline" else laws.observer
    loop = SampledLoop(plant, law, observer)
    return (
        shortest(lambda: loop.run(wind)),
        shortest(lambda: simulate(plant, SampledLaw(law, 0.02), wind, observer=observer)),
    )


def now() -> Times:
    """Return the clock of the wall and that of the process's cores [s]."""
    return Times(time.perf_counter(), time.process_time())


def since(began: Times) -> Times:
    """Return what has passed."""
    return Times(time.perf_counter() - began.wall, time.process_time() - began.core)


def shortest(work: Callable[[], object]) -> Times:
    """Return the least times of some repetitions."""
    spent = []
    for _ in range(REPEATS):
        began = now()
        work()
        spent.append(since(began))
    return min(spent, key=lambda times: times.core)


def figures(spent: Times, simulated: float, unit: Times) -> tuple[str, ...]:
    """Return the times, simulated seconds a core second, and core time of 600 s over one case's."""
    share = spent.core / simulated * DURATION / unit.core
    return (
        f"{spent.wall:.2f} s",
        f"{spent.core:.2f} s",
        f"{simulated / spent.core:.0f}",
        f"{share:.2g}",
    )


def rosco(python: str, wind: WindSeries) -> Times:
    """Return the times of ROSCO's simulator in the wind."""
    with tempfile.TemporaryDirectory() as place:
        times = np.arange(0.0, DURATION, 0.025)
        series = Path(place) / "wind.json"
        series.write_text(json.dumps([times.tolist(), wind.at(times).tolist()]), encoding="utf-8")
        done = subprocess.run(
            [python, str(ROSCO), str(series), place], check=True, capture_output=True, text=True
        )
    wall, core = done.stdout.split()[-2:]
    return Times(float(wall), float(core))


if __name__ == "__main__":
    main()
