"""Estimators of the wind on OpenFAST's records: rms error, bias and lag by wind; table and figure.

    python benchmarks/wind_estimators.py RUNS WINDS [FIGURE.svg]

RUNS holds a folder for each run, NAME_MEAN_SEED, with series.csv.gz (OpenFAST's channels GenSpeed,
BldPitch1, GenTq, Wind1VelX); WINDS holds the TurbSim fields ntm_B_MEAN_sSEEDMEAN_660s.bts.  The
wind that is compared with is the field's average over the rotor disc, low-passed at 0.5 Hz without
lag.  The field's place in time is where its hub point fits Wind1VelX best, plus the way from the
rotor to the tower.  Every estimator is tuned by one number for the least rms error in TUNED.
"""

from __future__ import annotations

import csv
import gzip
import re
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.signal import butter, correlate, correlation_lags, sosfiltfilt

from takagi.models import WindObserver, nrel5mw
from takagi.models.simulation.closed_loop import Observer
from takagi.models.turbine.wind_estimators import ImmersionInvarianceEstimator, KalmanWindFilter

TUNED, START, OVERHANG, CORNER, LARGEST_LAG = "15_1", 60.0, 5.0, 0.5, 10.0  # s, m, Hz, s
SLOPE = 0.02  # dT_r/dv / J that a bandwidth of the observer is stated at [1/s/m]
BANDWIDTHS = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
TURBINE = nrel5mw()


def observer(bandwidth: float) -> WindObserver:
    """Return the observer with error poles of this size [rad/s] at SLOPE and damping 0.7."""
    return WindObserver(TURBINE, 1.4 * bandwidth, bandwidth**2 / SLOPE)


def kalman(bandwidth: float) -> KalmanWindFilter:
    """Return the filter that has this bandwidth [rad/s] at SLOPE: q / r = (wo^2 / d)^2."""
    return KalmanWindFilter(TURBINE, 1e-4 * (bandwidth**2 / SLOPE) ** 2)


def immersion(bandwidth: float) -> ImmersionInvarianceEstimator:
    """Return the estimator with this bandwidth [rad/s] at SLOPE: gamma = wo / d."""
    return ImmersionInvarianceEstimator(TURBINE, bandwidth / SLOPE)


KINDS: dict[str, Callable[[float], Observer]] = {
    "observer": observer,
    "Kalman filter": kalman,
    "immersion and invariance": immersion,
}


def field(path: Path) -> tuple[float, float, np.ndarray, np.ndarray]:
    """Return (step [s], mean wind, hub wind, disc mean) of a TurbSim file."""
    data = path.read_bytes()
    _, nz, ny, tower, steps = struct.unpack_from("<h4i", data)
    dz, dy, step, mean, hub, bottom = struct.unpack_from("<6f", data, 18)
    scale, offset = struct.unpack_from("<2f", data, 42)
    start = 70 + struct.unpack_from("<i", data, 66)[0]
    raw = np.frombuffer(data, "<i2", steps * 3 * (nz * ny + tower), start).reshape(steps, -1)
    winds = (raw[:, : 3 * nz * ny : 3].astype(float) - offset) / scale
    z, y = np.meshgrid(bottom + dz * np.arange(nz) - hub, dy * (np.arange(ny) - (ny - 1) / 2))
    away = np.hypot(z, y).T.ravel()
    return step, mean, winds[:, away.argmin()], winds[:, away <= TURBINE.rotor_radius].mean(axis=1)


def record(run: Path, winds: Path) -> dict[str, np.ndarray]:
    """Return time, speed, pitch, torque in SI units, and the wind over the disc."""
    with gzip.open(run / "series.csv.gz", "rt") as stream:
        head = next(csv.reader([stream.readline()]))
        wanted = [head.index(n) for n in ("Time", "GenSpeed", "BldPitch1", "GenTq", "Wind1VelX")]
        table = np.loadtxt(stream, delimiter=",", usecols=wanted).T
    time, speed, pitch, torque, hub = table
    mean, seed = run.name.split("_")[-2:]
    step, wind, at_hub, disc = field(
        winds / f"ntm_B_{mean}_s{int(seed) * 100 + int(mean)}_660s.bts"
    )
    times = step * np.arange(len(disc))
    shifts = np.arange(0, 30, step / 2)
    misfit = [np.std(np.interp(time + s, times, at_hub)[::8] - hub[::8]) for s in shifts]
    low_passed = sosfiltfilt(butter(2, CORNER, fs=1 / step, output="sos"), disc)
    found = float(shifts[int(np.argmin(misfit))])
    print(f"{run.name}: shift {found:.2f} s, misfit {min(misfit):.3f} m/s", file=sys.stderr)
    return {
        "time": time,
        "speed": speed * np.pi / 30 / TURBINE.gear_ratio,
        "pitch": np.deg2rad(pitch),
        "torque": torque * 1e3,
        "wind": np.interp(time + found + OVERHANG / wind, times, low_passed),
    }


def estimate(watch: Observer, rows: dict[str, np.ndarray]) -> np.ndarray:
    """Return the estimate at every sample, one Euler step each, as a controller would."""
    step = float(rows["time"][1] - rows["time"][0])
    state = watch.initial_state(float(rows["speed"][0]), float(rows["wind"][0]))
    found = []
    for reading in zip(*(rows[n].tolist() for n in ("speed", "pitch", "torque")), strict=True):
        found.append(watch.wind_estimate(state))
        state = state + step * watch.state_rate(state, *reading)
    return np.array(found)


def judged(found: np.ndarray, rows: dict[str, np.ndarray]) -> tuple[float, float, float]:
    """Return rms error and bias [m/s], and the lag at the peak of the cross-correlation [s]."""
    late = rows["time"] >= START
    guess, wind, step = found[late], rows["wind"][late], float(np.diff(rows["time"][:2])[0])
    both = correlate(guess - guess.mean(), wind - wind.mean(), method="fft")
    lags = correlation_lags(len(guess), len(wind)) * step
    near = np.abs(lags) <= LARGEST_LAG
    error = guess - wind
    return (
        float(np.sqrt(np.mean(error**2))),
        float(error.mean()),
        float(lags[near][both[near].argmax()]),
    )


def main() -> None:
    """Print the tables in Markdown; draw the figure if a name is given."""
    runs, winds = Path(sys.argv[1]), Path(sys.argv[2])
    names = [p for p in runs.glob("q_base_*_*") if p.is_dir() and (p / "series.csv.gz").exists()]
    names.sort(key=lambda p: [int(n) for n in re.findall(r"\d+", p.name)])
    records = {p.name.removeprefix("q_base_"): record(p, winds) for p in names}
    chosen: dict[str, Observer] = {}
    print("| rms [m/s] at bandwidth [rad/s] | " + " | ".join(map(str, BANDWIDTHS)) + " |")
    print("|---" * (1 + len(BANDWIDTHS)) + "|")
    for kind, make in KINDS.items():
        errors = [judged(estimate(make(b), records[TUNED]), records[TUNED])[0] for b in BANDWIDTHS]
        best = BANDWIDTHS[int(np.argmin(errors))]
        chosen[f"{kind}, {best:g} rad/s"] = make(best)
        print(f"| {kind} | " + " | ".join(f"{e:.2f}" for e in errors) + " |")
    for bandwidth in (0.5, 1.0):
        chosen.setdefault(f"observer, {bandwidth:g} rad/s", observer(bandwidth))
    print("\n| mean wind, seed | " + " | ".join(chosen) + " |\n" + "|---" * (1 + len(chosen)) + "|")
    results: dict[str, list[tuple[float, float, float]]] = {name: [] for name in chosen}
    for where, rows in records.items():
        for name, watch in chosen.items():
            results[name].append(judged(estimate(watch, rows), rows))
        cells = ["{:.2f}, {:+.2f}, {:.2f}".format(*results[name][-1]) for name in chosen]
        mark = " (tuned)" if where == TUNED else ""
        print(f"| {where.replace('_', ', ')}{mark} | " + " | ".join(cells) + " |", flush=True)
    if len(sys.argv) > 3:
        draw([int(where.split("_")[0]) for where in records], results, Path(sys.argv[3]))


def draw(
    means: list[int], results: dict[str, list[tuple[float, float, float]]], path: Path
) -> None:
    """Draw rms error and lag over the mean wind."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "wind estimators"
    from matplotlib import pyplot as plt

    from takagi.reports.figures.style import COLOURS

    figure, panels = plt.subplots(2, 1, sharex=True, figsize=(6.4, 5.4), layout="constrained")
    for (name, rows), colour, marker in zip(results.items(), COLOURS, "osD^v", strict=False):
        for panel, entry in zip(panels, (0, 2), strict=True):
            label = name if entry == 0 else None
            panel.plot(means, [r[entry] for r in rows], marker, color=colour, ms=5, label=label)
            averages = [
                np.mean([r[entry] for m, r in zip(means, rows, strict=True) if m == at])
                for at in sorted(set(means))
            ]
            panel.plot(sorted(set(means)), averages, color=colour, lw=1)
    panels[0].set_ylabel("rms error [m/s]")
    panels[1].set_ylabel("lag [s]")
    panels[1].set_xlabel("mean wind [m/s]")
    panels[0].legend(fontsize=8)
    for panel in panels:
        panel.set_ylim(bottom=0)
        panel.grid(alpha=0.3)
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
