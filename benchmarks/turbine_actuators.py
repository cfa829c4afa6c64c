"""Whether a claim of kind ``actuator-rates`` is false: the nonlinear loop's own rates on the set.

States of the set, winds of the class, inertias and wakes are climbed, cell by cell, towards

    |beta'|                                       over pitch_rate
    |(e - x)' - its value at xi = 0|, v = v_s     over signal_rate, with v_s' = 0
    |T_g'| = E |F(-U) U' - f v_s''|               over torque_rate; the torque asked for

and torque at both sides of every node is compared for the schedule rates that both cells allow.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from turbine_loop import Data, Floats, Loop, share
from turbine_search import MARGIN, climb, first_wrong, states

CLIMBERS, SPEEDS = 16, 201
COLUMNS = 9  # The place in the cell, inertia, wake; state (4); wind error and rate.
Value = Callable[[Floats], Floats]


def why_actuators_false(loop: Loop, claim: Data, draw: np.random.Generator) -> str:
    """Return what is false in the claim, and where; empty when nothing was seen."""
    if len(claim["cells"]) != len(loop.cells):
        return "the cells are not the loop's"
    k = np.repeat(np.arange(len(loop.cells)), CLIMBERS)
    rates = {"pitch_rate": _pitch, "signal_rate": _signal, "torque_rate": _torque}
    for name, rate in rates.items():
        stated = _stated(claim, name)[k]

        def over(z: Floats, rate: Callable[..., Floats] = rate, stated: Floats = stated) -> Floats:
            return rate(loop, claim, k, z) - stated

        z, best = climb(over, draw, len(k), COLUMNS)
        wrong = best > MARGIN * (1 + stated)
        if wrong.any():
            return first_wrong(wrong, loop.at(k, z), f"{name} is {(best + stated)[wrong][0]:.7g}")
    step = torque_step(loop)
    if step > float(claim["torque_step"]) * (1 + MARGIN) + MARGIN:
        return f"torque steps by {step:.7g} N m at a node"
    return ""


def _stated(claim: Data, name: str) -> Floats:
    return np.array([float(cell[name]) for cell in claim["cells"]])


def _inside(loop: Loop, xi: Floats, pitch: Floats) -> NDArray[np.bool_]:
    """Return which states the claim is about: V <= 1, pitch at its lower limit or above."""
    V = np.einsum("ni,ij,nj->n", xi, loop.P, xi)
    return np.asarray((pitch >= loop.law["pitch_min"]) & (V <= 1 + 1e-12))


def _pitch(loop: Loop, _: Data, k: NDArray[np.int64], z: Floats) -> Floats:
    at, xi = loop.at(k, z), states(loop.P, z[:, 3:7])
    rate = (2 * z[:, 8] - 1) * loop.stated("wind_rate", k)
    moved = loop.motion(at, xi, at.wind, rate)
    return np.where(_inside(loop, xi, moved.pitch), abs(moved.drive), -np.inf)


def _signal(loop: Loop, _: Data, k: NDArray[np.int64], z: Floats) -> Floats:
    at, xi, still = loop.at(k, z), states(loop.P, z[:, 3:7]), np.zeros(len(k))
    moved, rest = (loop.motion(at, x, at.wind, still) for x in (xi, 0 * xi))
    off = moved.xi - rest.xi
    return np.where(_inside(loop, xi, moved.pitch), abs(off[:, 0] - off[:, 2]), -np.inf)


def _torque(loop: Loop, claim: Data, k: NDArray[np.int64], z: Floats) -> Floats:
    """Return |T_g'|, v_s'' as large as the claim allows and of the sign that adds."""
    at, xi = loop.at(k, z), states(loop.P, z[:, 3:7])
    wind = at.wind + (2 * z[:, 7] - 1) * loop.stated("wind_error", k)
    rate = (2 * z[:, 8] - 1) * loop.stated("wind_rate", k)
    moved, t, s = loop.motion(at, xi, wind, rate), at.table, at.slope
    signal = xi[:, 0] - xi[:, 2]
    U = t["trim_effort"] + t["proportional"] * signal
    dU = (s["trim_effort"] + s["proportional"] * signal) * rate
    dU += t["proportional"] * (moved.xi[:, 0] - moved.xi[:, 2])
    f, limit = (loop.steps[key][k] for key in ("inertia_feedforward", "feedforward_limit"))
    fed = abs(f) * (abs(f * rate) < limit) * _stated(claim, "schedule_bend")[k]
    found = loop.law["effort_torque"] * (share(-U, loop.law["overlap"]) * abs(dU) + fed)
    return np.where(_inside(loop, xi, moved.pitch), found, -np.inf)


def torque_step(loop: Loop) -> float:
    """Return the largest step of the torque asked for at a node, at rates that both cells allow."""
    f, limit = (loop.steps[key] for key in ("inertia_feedforward", "feedforward_limit"))
    reach = loop.stated("wind_rate", np.arange(len(loop.cells)))
    rates = np.minimum(reach[:-1], reach[1:])[:, None] * np.linspace(-1, 1, SPEEDS)
    before, after = (
        np.clip(f[part, None] * rates, -limit[part, None], limit[part, None])
        for part in (slice(None, -1), slice(1, None))
    )
    return float(loop.law["effort_torque"] * abs(before - after).max(initial=0))


def why_actuators_misshown(loop: Loop, claim: Data, statement: str) -> str:
    """Return what is shown better than it is stated."""
    pitch, torque, bend = (
        _stated(claim, name) for name in ("pitch_rate", "torque_rate", "schedule_bend")
    )
    most, own = loop.number["pitch_rate_limit"], loop.number["torque_rate_limit"]
    acts = (loop.steps["inertia_feedforward"] != 0) & (loop.steps["feedforward_limit"] > 0)
    fed = bend[acts] if acts.any() else np.array([np.inf])
    # What is said to stay below a limit does so as the limit is told, which is never too high.
    told = re.search(r"limit of (\S+) rad/s", statement)
    below = np.count_nonzero(pitch < (most if told is None else float(told[1])))
    # (words, the number that is stated, whether more than it is too much)
    compared = (
        (r"pitch moves at most at (\S+) rad/s", pitch.max(), False),
        (r"and in (\d+) stays below", below, True),
        (r"limit of (\S+) rad/s", most, True),
        (r"nodes, at most at (\S+) N m/s", torque.max(), False),
        (r"fed the schedule wind's rate, in (\d+) of them", np.count_nonzero(acts), False),
        (r"at most (\S+) m/s\^3", fed.min(), True),
        (r"and in (\d+) within", np.count_nonzero(torque <= own), True),
        (r"turbine's limit of (\S+) N m/s", own, False),
        (r"steps by at most (\S+) N m", float(claim["torque_step"]), False),
    )
    for words, number, more in compared:
        shown = re.search(words, statement)
        if shown is None:
            continue
        over = float(shown[1].rstrip(",;")) - number
        if (over if more else -over) > MARGIN * (1 + abs(number)):
            return f"shown better than stated: {shown[0]}"
    return ""
