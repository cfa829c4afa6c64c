"""Textbook plants: each designed by the command with its defaults, run, and beside LQR.

Run it by ``python benchmarks/gallery.py``: some minutes.  It designs every plant file in
tests/gallery/plants by ``takagi design FILE``, simulates what was found with the plants read anew
(tests/gallery/textbook_loop.py), and writes docs/gallery-table.md.  Names of files as arguments
print the rows of these plants alone and leave the page; with ``--rows`` before them their rows are
written too, and the other rows stay as they are on the page.  ``--turbines`` alone designs and
simulates the wind turbines of tests/gallery/turbines, and writes their rows.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import control
import numpy as np

from takagi.certificates import Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.claims.certification import certify
from takagi.certificates.design.turbine.effort_sharing_gains import wind_observer_design
from takagi.certificates.design.turbine.result import speed_filter
from takagi.certificates.requests import InputLimits
from takagi.models import Plant, load_model, sector_model
from takagi.reports.page.text import at_least, at_most
from takagi.reports.simulation.laws import ChosenLaws
from takagi.reports.simulation.runs import run_simulation
from takagi.reports.simulation.tables import table_rows
from takagi.reports.simulation.winds import requested_winds

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.gallery.textbook_loop import Floats, TextbookLoop, textbook_loop  # noqa: E402
from tests.gallery.turbine_claims import turbine_claims  # noqa: E402

PLANTS = ROOT / "tests" / "gallery" / "plants"
PAGE = ROOT / "docs" / "gallery-table.md"
# The time of plants that are not in SI; the others are in seconds.
TIMES = {"glucose": "min", "predator_prey": "years", "chua": "", "jet_engine": ""}
LATE = 1.2  # times LQR's settling time
EQUAL = 1.02  # what counts as the same size or time as LQR's
HEAD = """# Gallery: all plants in a table

For those who look for a plant like theirs: a file of some thirty lines each, with its source.
Equations and numbers are recalled from the source; ranges are chosen. Each design is

    takagi design tests/gallery/plants/NAME.toml --out build/NAME

"""
COLUMNS = """
- **time**: wall clock and processor, with proof and report, on {cores} cores {shared}.
- **set**: how far from rest a state may start, one state at a time, and the share of its range to
  the nearer side. From anywhere in the set, an ellipsoid, it is proved that the motion stays in it,
  that no input passes its range, and that it comes to rest.
- **set / LQR's**: the volume of the set over that of the set proved for LQR's gain, as a length
  (n-th root), and the largest multiple of the ranges inside over LQR's; "only" where none is proved
  for LQR. LQR is that of python-control at rest, with the weights 1/range².
- **gains**: the largest command, over all rules, to a state with every variable at the end of its
  range, in multiples of the input's limit.
- **settles**: the slowest of the runs from both ends of every axis of the set, until all states
  stay within 2 % of the set's reach; simulated by scipy without takagi, inputs cut at their ranges.

How the law is chosen: [plants](plants.md#the-law-where-nothing-is-asked). `--settle` and
`--decay-rate` ask for more.
"""
TURBINES = ROOT / "tests" / "gallery" / "turbines"
TURBINE_HEAD = """
## Turbines

Wind turbines of public files. The commands are `takagi design tests/gallery/turbines/NAME.toml
--out build/NAME` and `takagi simulate tests/gallery/turbines/NAME.toml --law-from
build/NAME/gains.json --wind ramp`.

| turbine | verdict | winds [m/s] | wind error [m/s] | rotor speed | decay [1/s] | ramp |
|---|---|---|---|---|---|---|
"""
TURBINE_COLUMNS = """
- **verdict**: on the claims about the loop, the wind's rate and the actuators' rates.
- **wind error**: how far the wind may be from the schedule wind, at the weakest and the best wind.
- **rotor speed**: over rated, at most, from any start in the certified set; **decay**: in constant
  wind, at least.
- **ramp**: simulated on the [validation plant](validation-plant.md), 8 to 14 to 8 m/s in 180 s:
  largest overspeed, pitch travel.
"""


class Measured(NamedTuple):
    """What the command did with a file; sizes of states and inputs that LQR's weights are of."""

    name: str
    text: dict[str, Any]
    status: int
    wall: float
    processor: float
    told: str
    loop: TextbookLoop | None
    sizes: Floats | None = None


class Beside(NamedTuple):
    """The law's set over LQR's, by volume and by corners; infinite where LQR has none proved."""

    volume: float
    corners: float


class Settling(NamedTuple):
    """The slowest run, and how many of the starts do not settle."""

    slowest: float
    lost: int
    starts: int


def measured(file: Path, folder: Path) -> Measured:
    """Return what ``takagi design`` says of the file, and the loop where it is proved."""
    command = [
        str(Path(sys.executable).parent / "takagi"),
        "design",
        str(file),
        "--out",
        str(folder),
    ]
    start = time.perf_counter()
    with tempfile.TemporaryFile("w+") as told:
        running = subprocess.Popen(command, stdout=told, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - start
        told.seek(0)
        words = told.read()
    loop = None
    if running.returncode == 0:
        loop = textbook_loop(file, json.loads((folder / "certificate.json").read_text("utf-8")))
    sizes = None
    if loop is not None:
        record = json.loads((folder / "design.json").read_text("utf-8"))
        stated = record["design"]["members"]["regulator_sizes"]
        sizes = half_widths(loop)
        if stated is not None:
            first = np.concatenate([part["array"] for part in stated["tuple"]])
            sizes = np.where(np.isfinite(range_widths(loop)), sizes, first)
    text = tomllib.loads(file.read_text(encoding="utf-8"))
    processor = usage.ru_utime + usage.ru_stime
    return Measured(file.stem, text, running.returncode, wall, processor, words, loop, sizes)


def range_widths(loop: TextbookLoop) -> Floats:
    """Return the distance from rest to the nearer end of each range."""
    return np.minimum(loop.ranges[:, 1] - loop.rest, loop.rest - loop.ranges[:, 0])


def half_widths(loop: TextbookLoop) -> Floats:
    """Return the distance from rest to the nearer end of each range; of the reach without one."""
    width = range_widths(loop)
    reach = np.concatenate((loop.reach, np.full(len(loop.inputs), np.inf)))
    return np.where(np.isfinite(width), width, reach)


def lqr(loop: TextbookLoop, size: Floats | None) -> Floats:
    """Return the gain of the linear regulator at rest with Bryson's weights."""
    assert size is not None
    n = len(loop.states)
    K, _, _ = control.lqr(*loop.slopes, np.diag(1 / size[:n] ** 2), np.diag(1 / size[n:] ** 2))
    return np.asarray(K, dtype=np.float64)


def effort(loop: TextbookLoop, gains: Floats) -> float:
    """Return the largest command from the corners of the box, in multiples of its limit."""
    size = half_widths(loop)
    n = len(loop.states)
    return float((np.abs(gains) @ size[:n] / size[n:]).max())


def settling(loop: TextbookLoop, law: Callable[[Floats], Floats] | None = None) -> Settling:
    """Return how the runs from the boundary of the set settle."""
    found = []
    for start in loop.boundary():
        motion = loop.run(start, law)
        found.append(loop.settled(motion) if motion.time.size == 2001 else None)
    times = [t for t in found if t is not None]
    return Settling(max(times, default=float("nan")), len(found) - len(times), len(found))


def beside_regulator(loop: TextbookLoop, file: Path, K: Floats) -> Beside:
    """Return the law's set over the set that is proved for LQR's gain, as lengths."""
    plant = load_model(file)
    assert isinstance(plant, Plant)
    n = len(loop.states)
    limits = half_widths(loop)[n:]
    certified = certify(sector_model(plant), K, claims=[InputLimits(limits)])
    if certified.verdict is not Verdict.PROVED:
        return Beside(np.inf, np.inf)
    claim = certified.document["claims"][-1]
    other = np.array(claim["P"], dtype=np.float64) / float(claim["level"])
    half = half_widths(loop)[:n]
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * n)).reshape(n, -1).T * half
    law, regulator = (np.einsum("ki,ij,kj->k", signs, P, signs).max() for P in (loop.P, other))
    volumes = np.linalg.det(other) / np.linalg.det(loop.P)
    return Beside(float(volumes ** (0.5 / n)), float((regulator / law) ** 0.5))


def linear(loop: TextbookLoop, K: Floats) -> Callable[[Floats], Floats]:
    """Return the law u* - K (x - x*)."""
    n = len(loop.states)
    return lambda x: np.asarray(loop.rest[n:] - K @ (x - loop.rest[:n]))


def time_scale(span: float, unit: str) -> tuple[float, str]:
    """Return a factor and the unit for times of this size."""
    if unit != "s":
        return 1.0, unit
    for least, factor, name in ((7200, 3600, "h"), (300, 60, "min"), (0.1, 1, "s")):
        if span >= least:
            return 1 / factor, name
    return 1000.0, "ms"


def shown_time(value: float, unit: str) -> str:
    """Return a time with its unit."""
    factor, name = time_scale(value, unit)
    return f"{digits(value * factor)} {name}".strip()


def digits(value: float) -> str:
    """Return three digits, never a power of ten where a whole number is as short."""
    return f"{value:.0f}" if 1000 <= abs(value) < 1e5 else f"{value:.3g}"


def judgement(sets: Beside, law: Settling, other: Settling) -> str:
    """Return where the law is better, equal or worse than LQR: first the set, then the time."""
    larger = max(sets)
    words = "larger" if larger > EQUAL else "smaller" if larger < 1 / EQUAL else "equal"
    ratio = np.inf if other.lost else law.slowest / other.slowest
    if other.lost and not law.lost:
        return f"{words}, faster"
    quick = "faster" if ratio < 1 / EQUAL else "slower" if ratio > EQUAL else "equal"
    return f"{words}, {quick} ({ratio:.2f})"


def row(found: Measured) -> str:
    """Return the row of a proved plant."""
    loop = found.loop
    assert loop is not None
    n, unit = len(loop.states), TIMES.get(found.name, "s")
    width = np.minimum(loop.ranges[:, 1] - loop.rest, loop.rest - loop.ranges[:, 0])
    parts = []
    for k, name in enumerate(loop.states):
        label = "" if loop.units[k] == "-" else f" {loop.units[k]}"
        # What is proved is rounded down.
        part = min(np.floor(100 * loop.alone[k] / width[k]), 100)
        share = f" ({part:.0f}%)" if np.isfinite(width[k]) else ""
        parts.append(f"{name} {at_least(loop.alone[k] / loop.scale[k])}{label}{share}")
    K = lqr(loop, found.sizes)
    law, other = settling(loop), settling(loop, linear(loop, K))
    sets = beside_regulator(loop, PLANTS / f"{found.name}.toml", K)
    compared = "only" if np.isinf(sets.volume) else f"{sets.volume:.2f}, {sets.corners:.2f}"
    settled = " / ".join(
        shown_time(s.slowest, unit) + (f" ({s.lost} of {s.starts} do not)" if s.lost else "")
        for s in (law, other)
    )
    cells = (
        f"[{found.text['name']}](../tests/gallery/plants/{found.name}.toml)",
        f"{n}, {len(loop.inputs)}",
        str(len(loop.gains)),
        f"{found.wall:.1f} / {found.processor:.1f}",
        ", ".join(parts),
        compared,
        f"{effort(loop, loop.gains):.2g} / {effort(loop, K):.2g}",
        settled,
        judgement(sets, law, other),
    )
    return f"| {' | '.join(cells)} |"


def page(members: list[Measured], rows: dict[str, str]) -> str:
    """Return docs/gallery-table.md."""
    proved = [m for m in members if m.name in rows]
    walls = sorted(m.wall for m in proved)
    processors = sorted(m.processor for m in proved)
    cores = os.cpu_count() or 1
    shared = (
        "that other programs shared"
        if sum(walls) > 1.1 * sum(processors)
        else "with nothing else at work"
    )
    said = (
        f"{len(proved)} of {len(members)} are PROVED; the median takes {np.median(walls):.0f} s "
        f"({np.median(processors):.0f} s of processor time), the longest {walls[-1]:.0f} s "
        f"({processors[-1]:.0f} s).\n\n"
    )
    said += verdicts([rows[m.name] for m in proved])
    table = (
        "| plant | states, inputs | rules | time [s] | set | set / LQR's "
        "| gains: law / LQR | settles: law / LQR | set, settling |\n"
        "|---|---|---|---|---|---|---|---|---|\n"
    )
    table += "\n".join(rows[m.name] for m in proved) + "\n"
    lost = [
        f"| [{m.text['name']}](../tests/gallery/plants/{m.name}.toml) | {m.wall:.1f} / "
        f"{m.processor:.1f} | {m.told.splitlines()[0]} |\n"
        for m in members
        if m.name not in rows
    ]
    if lost:
        lost.insert(0, "\n## Not proved\n\n| plant | time [s] | what is said |\n|---|---|---|\n")
    columns = COLUMNS.format(cores=cores, shared=shared)
    turbines = TURBINE_HEAD + "\n".join(kept_turbines()) + "\n" + TURBINE_COLUMNS
    return HEAD + said + table + columns + "".join(lost) + turbines


def verdicts(rows: list[str]) -> str:
    """Return in how many rows the law's set is larger, and in how many it settles earlier."""
    cells = [line.rstrip(" |").rpartition(" | ")[2] for line in rows]
    larger, smaller, faster, slower = (
        sum(word in cell for cell in cells) for word in ("larger", "smaller", "faster", "slower")
    )
    ratios = [float(cell.partition("(")[2].rstrip(")")) for cell in cells if "(" in cell]
    late = sum(ratio > LATE for ratio in ratios)
    n = len(cells)
    return (
        f"Beside LQR the law's set is larger in {larger}, equal in {n - larger - smaller} and "
        f"smaller in {smaller}; it settles faster in {faster}, as fast in {n - faster - slower} "
        f"and slower in {slower}, by more than {LATE} times in {late}.\n\n"
    )


def kept_turbines() -> list[str]:
    """Return the turbines' rows of the page."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if "(../tests/gallery/turbines/" in line]


def turbine_row(file: Path) -> str:
    """Return the row of a turbine: what is proved, and a ramp through rated wind."""
    turbine, asked, law, document = turbine_claims(file)
    loop, rated = document["claims"][0], turbine.rated_rotor_speed
    errors = [cell["wind_error"] for cell in loop["cells"]]
    over = (max(document["gains"]["rotor_speed"]) + loop["peaks"]["speed_error"]) / rated - 1
    observer, filters = wind_observer_design(turbine, asked).observer, speed_filter(asked)
    chosen = ChosenLaws({law.name: law}, observer, {law.name: filters} if filters else {})
    winds = requested_winds(turbine, ["ramp"])
    run = table_rows(run_simulation(turbine, chosen, winds))[0]
    cells = (
        f"[{turbine.name}](../tests/gallery/turbines/{file.name})",
        check_document(document).verdict.name,
        f"{loop['cells'][0]['wind'][0]:g} to {loop['cells'][-1]['wind'][1]:g}",
        f"{at_least(min(errors))} to {at_least(max(errors))}",
        f"{at_most(100 * over)} %",
        at_least(loop["settling"]["decay_rate"]),
        f"{run['overspeed']:.1f} %, {run['pitch_travel']:.0f} deg",
    )
    return f"| {' | '.join(cells)} |"


def write_turbines() -> None:
    """Design and simulate the turbines, and write their rows into the page."""
    rows = [turbine_row(file) for file in sorted(TURBINES.glob("*.toml"))]
    text = PAGE.read_text(encoding="utf-8")
    section = TURBINE_HEAD + "\n".join(rows) + "\n" + TURBINE_COLUMNS
    PAGE.write_text(text.partition("\n## Turbines\n")[0] + section, encoding="utf-8")


def kept(asked: list[str]) -> tuple[list[Measured], dict[str, str]]:
    """Return the proved plants of the page that were not asked for, with their rows and times."""
    members, rows = [], {}
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        found = re.match(r"\| \[[^]]*\]\(\.\./tests/gallery/plants/(\w+)\.toml\) \|", line)
        if found is None or found[1] in asked or not (PLANTS / f"{found[1]}.toml").exists():
            continue
        wall, processor = map(float, line.split(" | ")[3].split(" / "))
        text = tomllib.loads((PLANTS / f"{found[1]}.toml").read_text(encoding="utf-8"))
        members.append(Measured(found[1], text, 0, wall, processor, "", None))
        rows[found[1]] = line
    return members, rows


def main() -> None:
    """Design and run; write the page where all plants, or rows, were asked for."""
    if sys.argv[1:] == ["--turbines"]:
        write_turbines()
        return
    asked = [name for name in sys.argv[1:] if name != "--rows"]
    adds = len(asked) < len(sys.argv) - 1
    members, rows = kept(asked) if adds else ([], {})
    with tempfile.TemporaryDirectory() as folder:
        for file in sorted(PLANTS.glob("*.toml")):
            if asked and file.stem not in asked:
                continue
            found = measured(file, Path(folder) / file.stem)
            members.append(found)
            if found.loop is not None:
                rows[found.name] = row(found)
            shown = rows.get(found.name) or f"{found.name}: status {found.status}"
            print(shown, f"({found.wall:.1f} s)", flush=True)
    if adds or not asked:
        members.sort(key=lambda found: found.name)
        PAGE.write_text(page(members, rows), encoding="utf-8")


if __name__ == "__main__":
    main()
