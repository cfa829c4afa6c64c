"""Chooses the settings of the effort-sharing law together, by what the machine does in turbulence.

    pip install cma
    python benchmarks/law_tuning.py [--evaluations N] [--journal FILE] [--workers N]

pycma (covariance matrix adaptation, Hansen) moves eight settings at once: the share of the pitch
effectiveness, the wind filter, the low-pass on the measured speed, the overlap, both bandwidths,
the integral share and the observer's bandwidth.  One evaluation designs the gains wind by wind and
runs the law on the validation plant with observer, flap, tower, torsion, wake, ripple and sampling,
in turbulence of class B.  The cost is what is lost, in per cent against the settings before:

    J = sum over winds of  20 (energy lost) + tower DEL + travel + overspeed beyond 6 %, squared

so that one per cent of energy is worth 20 % of the tower's fatigue or of the travel.  A law that
moves at steady wind is refused.  Every evaluation is kept in a journal, so that a run that was
stopped goes on; the trade-off curve in docs/laws.md is the front of all that were evaluated.
"""

from __future__ import annotations

import argparse
import json
import os
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from takagi.lmi.turbine.effort import EffortSettings, effort_gains  # noqa: E402
from takagi.models.errors import ModelError  # noqa: E402
from takagi.models.laws.effort_sharing.law import EffortSharingLaw  # noqa: E402
from takagi.models.laws.effort_sharing.schedule import effort_schedule  # noqa: E402
from takagi.models.laws.sampled import SampledLaw  # noqa: E402
from takagi.models.simulation.closed_loop import simulate  # noqa: E402
from takagi.models.simulation.metrics import measure  # noqa: E402
from takagi.models.simulation.turbine_plant import validation_plant  # noqa: E402
from takagi.models.simulation.turbulence import turbulent_wind  # noqa: E402
from takagi.models.simulation.wind import WindSeries  # noqa: E402
from takagi.models.turbine.loader import nrel5mw  # noqa: E402
from takagi.models.turbine.wind_observer import WindObserver  # noqa: E402

if TYPE_CHECKING:
    from takagi.models.turbine.data import Turbine

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
# name: least, greatest, before
SETTINGS = {
    "share": (0.5, 2.0, 0.6),
    "wind_filter": (2.0, 20.0, 5.0),
    "speed_filter": (1.5, 12.0, 12.0),
    "overlap": (0.003, 0.02, 0.01),
    "bandwidth": (0.3, 1.0, 0.6),
    "partial_bandwidth": (0.15, 0.6, 0.3),
    "integral_share": (0.03, 0.4, 0.3),
    "observer": (0.3, 1.5, 1.0),
}
WINDS = (9.0, 11.0, 13.0, 18.0)
SEED, DURATION, SAMPLE = 11, 460.0, 0.0125
RIPPLE = 0.005  # three swings a turn, over the wind: what OpenFAST's records of the rotor have
OBSERVER = (1.7942, 48.8767)  # (l_1, l_2) of the design, about 1 rad/s
STEADY, LONGEST, MOST_STEADY = (12.0, 13.0), 150.0, 0.05  # m/s, s, deg


@cache
def turbine() -> Turbine:
    return nrel5mw()


@cache
def wind(mean: float) -> WindSeries:
    """Return ten minutes of class B turbulence, IEC 61400-1: I = 0.14 (0.75 + 5.6 / V)."""
    return turbulent_wind(mean, 0.14 * (0.75 + 5.6 / mean), DURATION, SEED)


def law(at: dict[str, float]) -> EffortSharingLaw:
    """Return the law with gains found wind by wind."""
    schedule = effort_schedule(turbine(), overlap=at["overlap"], effectiveness_share=at["share"])
    asked = EffortSettings(
        bandwidth=at["bandwidth"],
        partial_bandwidth=min(at["partial_bandwidth"], at["bandwidth"]),
        integral_share=at["integral_share"],
    )
    gains = effort_gains(turbine(), schedule, asked).gains
    return EffortSharingLaw.of(turbine(), schedule, gains, wind_filter=at["wind_filter"])


def evaluated(at: dict[str, float]) -> dict[str, Any]:
    """Return the metrics by wind, and the pitch's movement at steady wind; or why there are none"""
    try:
        control = SampledLaw(law(at), SAMPLE)
    except ModelError as error:
        return {"at": at, "refused": str(error)}
    scale = at["observer"]
    observer = WindObserver(turbine(), OBSERVER[0] * scale, OBSERVER[1] * scale**2)
    plant = validation_plant(turbine(), speed_filter=at["speed_filter"], ripple=RIPPLE)
    calm = validation_plant(turbine(), speed_filter=at["speed_filter"])
    rows, moving = {}, 0.0
    try:
        for mean in WINDS:
            history = simulate(plant, control, wind(mean), observer=observer)
            rows[f"{mean:g}"] = measure(history, turbine()).row()
        for mean in STEADY:
            # A step up to the wind, so that what swings is set going.
            series = WindSeries(
                np.array([0.0, 10.0, 10.1, LONGEST]),
                np.array([mean - 1, mean - 1, mean, mean]),
                "steady",
            )
            history = simulate(calm, control, series, observer=observer)
            last = history.time > LONGEST - 30
            moving = max(moving, float(np.degrees(history.pitch[last].std())))
    except ModelError as error:
        return {"at": at, "refused": str(error)}
    return {"at": at, "winds": rows, "moving": moving}


def cost(found: dict[str, Any], before: dict[str, Any], overspeed: float) -> float:
    """Return J, see above; a refused point costs 1000 and a swinging one in proportion."""
    if "refused" in found:
        return 1000.0
    total = 300.0 * max(0.0, found["moving"] - MOST_STEADY)
    for mean, row in found["winds"].items():
        start = before["winds"][mean]

        def rise(name: str, row: Any = row, start: Any = start) -> float:
            return 100.0 * float(row[name] / max(start[name], 1e-9) - 1.0)

        total -= 20 * rise("mean electrical power [kW]")
        total += rise("tower fore-aft DEL [MN m]")
        if start["pitch travel [deg]"] > 20:
            total += rise("pitch travel [deg]")
        total += 3 * max(0.0, row["largest overspeed [%]"] - overspeed) ** 2
    return float(total / len(found["winds"]))


def main() -> None:
    """Move the settings, one generation after the other, and print the best."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--evaluations", type=int, default=300)
    parser.add_argument("--overspeed", type=float, default=8.0, help="beyond it costs [%%]")
    parser.add_argument("--journal", type=Path, default=Path("build") / "law-tuning.jsonl")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    given.journal.parent.mkdir(parents=True, exist_ok=True)
    known = _known(given.journal)
    with ProcessPoolExecutor(given.workers) as pool, given.journal.open("a") as journal:

        def all_of(points: list[dict[str, float]]) -> list[dict[str, Any]]:
            missing = [at for at in points if _key(at) not in known]
            for found in pool.map(evaluated, missing):
                known[_key(found["at"])] = found
                journal.write(json.dumps(found) + "\n")
                journal.flush()
            return [known[_key(at)] for at in points]

        before = all_of([{name: row[2] for name, row in SETTINGS.items()}])[0]
        best = _search(all_of, before, given.evaluations, given.overspeed)
    print(json.dumps(best, indent=1))


def _search(all_of: Any, before: dict[str, Any], evaluations: int, overspeed: float) -> Any:
    import cma

    start = np.array([0.45, 0.5, 0.4, 0.4, 0.45, 0.35, 0.5, 0.5])
    strategy = cma.CMAEvolutionStrategy(
        start, 0.2, {"bounds": [0, 1], "seed": 5, "popsize": 10, "verbose": -9}
    )
    best: tuple[float, Any] = (np.inf, None)
    while strategy.countevals < evaluations and not strategy.stop():
        points = strategy.ask()
        found = all_of([_settings(point) for point in points])
        costs = [cost(one, before, overspeed) for one in found]
        strategy.tell(points, costs)
        best = min([best, *zip(costs, found, strict=True)], key=lambda pair: pair[0])
        words = {name: round(value, 4) for name, value in best[1]["at"].items()}
        print(f"{strategy.countevals} evaluations, best {best[0]:.2f}: {words}", flush=True)
    return {"cost": best[0], **best[1]}


def _settings(point: Any) -> dict[str, float]:
    """Return the settings of a point of the unit cube; each is taken by its logarithm."""
    found = {}
    for share, (name, (low, high, _)) in zip(point, SETTINGS.items(), strict=True):
        found[name] = float(f"{low * (high / low) ** float(share):.4g}")
    return found


def _known(journal: Path) -> dict[str, dict[str, Any]]:
    if not journal.exists():
        return {}
    found = [json.loads(line) for line in journal.read_text().splitlines()]
    return {_key(one["at"]): one for one in found}


def _key(at: dict[str, float]) -> str:
    return json.dumps([at[name] for name in SETTINGS])


if __name__ == "__main__":
    main()
