"""What OpenFAST and the validation plant answer to a step of pitch or wind at constant speed.

The records have a ripple with every blade that passes the tower, and blade 1 one with every turn.
It is taken off before anything is compared:

    torque, thrust   first: mean from 0.65 to 1.25 s, less the same moments one passage before
                     final: mean over whole turns from 20 s, less the last passage before 0
    tower, tip       harmonics of the turn up to 6, fitted from 20 s, are taken off;
                     first: the largest within 4 s, final: from 20 s, both less the mean before 0

The first answer is looked at after 0.65 s, when the flow round the blades has settled, which the
plant leaves out.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import pi, radians
from pathlib import Path
from typing import NamedTuple

import numpy as np

from takagi.models import Floats
from takagi.models.simulation.turbine_plant import SimulatedTurbine, advance, loads
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import trim

__all__ = ["KINDS", "QUANTITIES", "WINDS", "Answer", "measured", "simulated"]

HERE = Path(__file__).parent
KINDS, WINDS = ("pitch", "wind"), (8, 12, 15, 18)
QUANTITIES = ("torque", "thrust", "tower", "flap")
BEGIN, END, SETTLED, LONG = 0.65, 1.25, 20.0, 4.0
HARMONICS = 6
STEP = 0.0125


class Answer(NamedTuple):
    first: float
    final: float


@lru_cache(maxsize=64)
def measured(kind: str, flexible: bool, wind: int, quantity: str) -> Answer:
    name = f"{kind}_{'flexible' if flexible else 'rigid'}_{wind}.csv"
    record = np.loadtxt(HERE / name, delimiter=",", skiprows=1)
    time, series = record[:, 0], record[:, 1 + QUANTITIES.index(quantity)]
    turn = 2 * pi / trim(nrel5mw(), float(wind)).rotor_speed
    late = time > time[-1] - int((time[-1] - SETTLED) / turn) * turn
    if quantity in QUANTITIES[:2]:
        before = series[(time >= -turn / 3 - 1e-9) & (time < -1e-9)].mean()
        early = (time >= BEGIN - 1e-9) & (time < END)
        passage_before = np.interp(time[early] - turn / 3, time, series)
        first = float(np.mean(series[early] - passage_before))
        return Answer(first, float(series[late].mean() - before))
    angle = 2 * pi * time / turn
    waves = [wave(k * angle) for k in range(1, HARMONICS + 1) for wave in (np.cos, np.sin)]
    basis = np.column_stack([np.ones_like(time), *waves])
    fit = np.linalg.lstsq(basis[late], series[late])[0]
    smooth = series - basis[:, 1:] @ fit[1:]
    before = smooth[time < -1e-9].mean()
    early = (smooth - before)[(time > 0) & (time <= LONG)]
    return Answer(float(early[np.abs(early).argmax()]), float(fit[0] - before))


@lru_cache(maxsize=64)
def simulated(kind: str, flexible: bool, wind: int, quantity: str) -> Answer:
    time, changes = _run(kind, flexible, wind)
    series = changes[:, QUANTITIES.index(quantity)]
    late = float(series[time >= SETTLED].mean())
    if quantity in QUANTITIES[:2]:
        return Answer(float(series[(time >= BEGIN) & (time < END)].mean()), late)
    early = series[time <= LONG]
    return Answer(float(early[np.abs(early).argmax()]), late)


@lru_cache(maxsize=16)
def _run(kind: str, flexible: bool, wind: int) -> tuple[Floats, Floats]:
    """Return time and the changes of torque, thrust, tower top and blade tip."""
    heavy = replace(nrel5mw(), rotor_inertia=1e15)
    plant = SimulatedTurbine(heavy, "first-order", tower=flexible, flap=flexible, wake=True)
    state, point = plant.initial_state(float(wind))
    count = round(40 / STEP)
    halves = np.arange(2 * count + 1) * STEP / 2
    winds, pitch = np.full(len(halves), float(wind)), point.pitch
    rest = state.copy()
    if kind == "pitch":
        pitch += radians(1.0)
        state[1] = pitch
    else:
        winds += 0.5 * np.clip(halves / 0.1, 0.0, 1.0)
    states, sent = [state], np.array([point.torque, pitch] * 2)
    for k in range(count):
        ahead = winds[2 * k : 2 * k + 3]
        states.append(advance(plant, states[-1], sent, 0, ahead, STEP))
    rows = np.array([rest, *states])
    speeds = np.array([float(wind), *winds[::2]])
    turning, thrust, _ = loads(plant, rows, np.full(len(rows), pitch), speeds)
    places = [plant.index("tower-top displacement"), plant.index("blade-tip displacement")]
    moved = [np.zeros(len(rows)) if place is None else rows[:, place] for place in places]
    found = np.column_stack([turning, thrust, *moved])
    changes: Floats = found[1:] - found[0]
    return np.arange(count + 1, dtype=np.float64) * STEP, changes


def main() -> None:
    units = {"torque": ("kN m", 1e3), "thrust": ("kN", 1e3), "tower": ("mm", 1e-3)}
    for flexible, shown in ((False, QUANTITIES[:2]), (True, QUANTITIES)):
        print(f"\n{'flexible' if flexible else 'rigid'}\n")
        heads = [f"{name} [{units.get(name, ('mm', 1e-3))[0]}]" for name in shown]
        titles = [f"{head}, {when}" for head in heads for when in ("first", "final")]
        print("| step | wind [m/s] | " + " | ".join(titles) + " |")
        print("|---|---|" + "---|" * len(titles))
        for kind in KINDS:
            for wind in WINDS:
                cells = []
                for name in shown:
                    scale = units.get(name, ("mm", 1e-3))[1]
                    pairs = zip(
                        measured(kind, flexible, wind, name),
                        simulated(kind, flexible, wind, name),
                        strict=True,
                    )
                    cells += [
                        f"{a / scale:.0f}, {b / scale:.0f} ({b / a - 1:+.0%})" for a, b in pairs
                    ]
                step = {"pitch": "pitch +1°", "wind": "wind +0.5 m/s"}[kind]
                print(f"| {step} | {wind} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
