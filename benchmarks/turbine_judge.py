"""Whether what a turbine's certificate says is false, by a search for a counterexample in floats.

The loop is ``turbine_loop``, which shares nothing with the checker.  Tried are

- coefficients: every one that a cell states, at points of cell, box, winds and uncertainty;
- invariance: V' + alpha (V - 1) < 0 in the box, so V' < 0 on V = 1, by a climb from random points;
- decay to the equilibrium at constant wind, by cell and in the common function;
- the set: peaks, limits of torque, pitch and integrator, the overspeed that is shown;
- the claims that rest on it: those on the wind's rate and the actuators', see below;
- the loop with its observer: ``turbine_running``.

"No" is a counterexample beyond ``MARGIN``, far wider than the rounding of floats.  An empty answer
says only that none was found: floats at points prove nothing.

Whether a claim of kind ``wind-rate`` is false: the law's wind filter against the worst winds.

v_s' = (w - v_s) / tau_f is run from every edge of what is claimed, w - v_s = +- tau_f phi(v_s), and
from v_s = w where the law starts, with an estimate w that moves away as fast as it may,
w' = +- r(w), and with the wind v as far from w as it may be.  Counterexamples are

    |v_s'| > phi(v_s),   |v_s'| > wind_rate,   |v - v_s| > wind_error        in the cell of v_s.

The tables are looked up by ``numpy.interp``, the filter is stepped by Runge and Kutta's rule.

Whether a claim of kind ``bumpless`` is false: the nonlinear loop's own rates on the set.

States of the set, winds of the class, inertias and wakes are climbed, cell by cell, towards

    |beta'|                                       over pitch_rate
    |(e - x)' - its value at xi = 0|, v = v_s     over signal_rate, with v_s' = 0
    |T_g'| = E |F(-U) U' - f v_s''|               over torque_rate; the torque asked for

and torque at both sides of every node is compared for the schedule rates that both cells allow.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from turbine_loop import At, Data, Floats, Loop, column, psi, share
from turbine_running import why_running_false, why_running_misshown

# A counterexample counts beyond this, far wider than the rounding of floats.
MARGIN = 1e-7
ROUNDS = 20


def drawn(draw: np.random.Generator, rows: int, columns: int) -> Floats:
    """Return numbers in [0, 1], a third of them at either end."""
    z = draw.random((rows, columns))
    return np.asarray(np.clip(z * 1.5 - 0.25, 0, 1))


def first_wrong(wrong: NDArray[np.bool_], at: At, what: str) -> str:
    """Return what is wrong at the first point where it is."""
    if not wrong.any():
        return ""
    i = int(np.argmax(wrong))
    return f"{what} at v_s = {at.wind[i]:.5f} m/s, kappa {at.kappa[i]:.4f}, wake {at.wake[i]:.3f}"


def states(P: Floats, z: Floats, most: float = 1) -> Floats:
    """Return states up to V = ``most``, half of them on V = 1; z (n, 4) in [0, 1]."""
    way = 2 * z[:, :3] - 1 + 1e-9
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    root = np.linalg.inv(np.linalg.cholesky(P)).T
    beyond = np.interp(z[:, 3], [0.75, 1], [1, np.sqrt(most)])
    radius = np.where(z[:, 3] < 0.25, 4 * z[:, 3], beyond)
    return np.asarray(radius[:, None] * way @ root.T)


def climb(value: Any, draw: np.random.Generator, rows: int, columns: int) -> tuple[Floats, Floats]:
    """Return the greatest values that a search by chance finds from each of its starts."""
    z = drawn(draw, rows, columns)
    best = value(z)
    for turn in range(ROUNDS):
        size = 0.5 * 0.75**turn
        moved = np.clip(z + size * draw.standard_normal(z.shape), 0, 1)
        found = value(moved)
        better = found > best
        z[better], best[better] = moved[better], found[better]
    return z, best


def overspeed_shown(loop: Loop, statement: str) -> str:
    """Return that more overspeed is reached than is shown, if so."""
    shown = re.search(r"overspeed at most (\S+) %", statement)
    if shown and loop.overspeed() > float(shown[1]) + MARGIN:
        return f"overspeed reaches {loop.overspeed():.6g} %"
    return ""


STARTS, STEPS, PER_FILTER = 12, 120, 60  # starts on a piece; steps in all, and in one tau_f
# The rule's own error where a table bends, of the rate that is compared.
STEPPED = 1e-5


@dataclass
class Tube:
    """One range of a claim: winds, both rates at them, and how well the wind is known."""

    wind: Floats
    estimate: Floats
    schedule: Floats
    error: float
    filter: float

    def moved(self, x: Floats, away: Floats) -> Floats:
        """Return (w', v_s') at (w, v_s); w stops at the range's ends."""
        w, v_s = x
        free = np.where(away > 0, w < self.wind[-1], w > self.wind[0])
        rate = away * np.interp(w, self.wind, self.estimate) * free
        return np.stack([rate, (w - v_s) / self.filter])

    def step(self, x: Floats, away: Floats, size: float) -> Floats:
        """Return (w, v_s) a moment later, w within the range."""
        one = self.moved(x, away)
        two = self.moved(x + size / 2 * one, away)
        three = self.moved(x + size / 2 * two, away)
        four = self.moved(x + size * three, away)
        after = x + size / 6 * (one + 2 * two + 2 * three + four)
        after[0] = np.clip(after[0], self.wind[0], self.wind[-1])
        return np.asarray(after)


def why_wind_rate_false(loop: Loop, claim: Data, draw: np.random.Generator) -> str:
    """Return what is false in the claim, and at which wind; empty when nothing was seen."""
    for tube in _tubes(loop, claim):
        inside = loop.wind[0] <= tube.wind[0] < tube.wind[-1] <= loop.wind[-1]
        least = min(tube.error, *tube.estimate, *tube.schedule)
        if not inside or least < 0 or (np.diff(tube.wind) <= 0).any():
            return "the range is none of the law's winds, or a number is negative"
        if why := _left(loop, tube, draw):
            return why
    return ""


def _tubes(loop: Loop, claim: Data) -> list[Tube]:
    return [
        Tube(
            column(one["wind"]),
            column(one["estimate_rate"]),
            column(one["schedule_rate"]),
            float(one["estimate_error"]),
            loop.wind_filter,
        )
        for one in claim["ranges"]
    ]


def _left(loop: Loop, tube: Tube, draw: np.random.Generator) -> str:
    """Run the filter from the edges of the tube, and say where it is left."""
    pieces = np.repeat(np.arange(len(tube.wind) - 1), STARTS)
    place = drawn(draw, len(pieces), 1)[:, 0]
    s = tube.wind[pieces] + place * np.diff(tube.wind)[pieces]
    lag = tube.filter * np.interp(s, tube.wind, tube.schedule)
    w = np.concatenate([s + lag, s - lag, s, s])
    away, start = np.repeat([1.0, -1.0, 1.0, -1.0], len(s)), np.tile(s, 4)
    kept = (w >= tube.wind[0]) & (w <= tube.wind[-1])
    x, away = np.stack([w, start])[:, kept], away[kept]
    for _ in range(STEPS):
        if why := _exceeded(loop, tube, x):
            return why
        x = tube.step(x, away, tube.filter / PER_FILTER)
    return _exceeded(loop, tube, x)


def _exceeded(loop: Loop, tube: Tube, x: Floats) -> str:
    """Return the first limit that is passed at (w, v_s)."""
    w, v_s = x
    every = np.arange(len(loop.cells))
    k = np.clip(np.searchsorted(loop.wind, v_s, side="right") - 1, 0, every[-1])
    rate = abs(w - v_s) / tube.filter
    farthest = (np.clip(w + e, *tube.wind[[0, -1]]) for e in (tube.error, -tube.error))
    off = np.maximum(*(abs(v - v_s) for v in farthest))
    for found, limit, what in (
        (rate, np.interp(v_s, tube.wind, tube.schedule), "the schedule wind is faster than stated"),
        (rate, loop.stated("wind_rate", k), "the schedule wind is faster than the claim allows"),
        (
            off,
            loop.stated("wind_error", k),
            "the schedule wind is further off than the claim allows",
        ),
    ):
        # A point just beside a node may be a cell's neighbour by rounding.
        inner = np.minimum(v_s - loop.wind[k], loop.wind[k + 1] - v_s) > MARGIN
        wrong = (found > limit * (1 + STEPPED) + MARGIN) & inner
        if wrong.any():
            i = int(np.argmax(wrong))
            return f"{what} at v_s = {v_s[i]:.5f} m/s: {found[i]:.7g} for {limit[i]:.7g}"
    return ""


def why_wind_rate_misshown(loop: Loop, claim: Data, statement: str) -> str:
    """Return what is shown better than it is stated."""
    if not statement:
        return ""
    tubes = _tubes(loop, claim)
    if why := overspeed_shown(loop, statement):
        return why
    filter_ = re.search(r"wind filter of (\S+) s", statement)
    if filter_ and float(filter_[1]) < tubes[0].filter * (1 - MARGIN):
        return f"the filter is slower than shown: {filter_[0]}"
    words = re.findall(
        r"within (\S+) to (\S+) m/s, known (?:exactly|to (\S+) m/s): ([^;]*)", statement
    )
    for tube, (low, high, error, rates) in zip(tubes, words, strict=True):
        if why := _range_shown(tube, float(low), float(high), float(error or 0), rates):
            return why
    return ""


def _range_shown(tube: Tube, low: float, high: float, error: float, rates: str) -> str:
    if not tube.wind[0] - MARGIN <= low <= high <= tube.wind[-1] + MARGIN:
        return f"winds {low} to {high} m/s are shown, more than stated"
    if error > tube.error + MARGIN:
        return f"an error of {error} m/s is shown, more than stated"
    told: list[tuple[Any, Any]] = [
        *((rate, low) for rate in re.findall(r"(\S+) m/s\^2 everywhere", rates)),
        *re.findall(r"(\S+) m/s\^2 from (\S+) m/s on", rates),
    ]
    for rate, start in told:
        from_on = np.append(tube.wind[tube.wind > float(start)], float(start))
        slowest = np.interp(from_on, tube.wind, tube.estimate).min()
        if float(rate) > slowest + MARGIN:
            return f"{rate} m/s^2 is shown from {start} m/s on, where {slowest:.6g} is stated"
    return ""


RATE_CLIMBERS = 16
COLUMNS = 9  # The place in the cell, inertia, wake; state (4); wind error and rate.
Value = Callable[[Floats], Floats]


def why_actuators_false(loop: Loop, claim: Data, draw: np.random.Generator) -> str:
    """Return what is false in the claim, and where; empty when nothing was seen."""
    if len(claim["cells"]) != len(loop.cells):
        return "the cells are not the loop's"
    k = np.repeat(np.arange(len(loop.cells)), RATE_CLIMBERS)
    rates = {"pitch_rate": _pitch, "signal_rate": _signal, "torque_rate": _torque}
    for name, rate in rates.items():
        stated = _stated(claim, name)[k]

        def over(z: Floats, rate: Callable[..., Floats] = rate, stated: Floats = stated) -> Floats:
            return rate(loop, claim, k, z) - stated

        z, best = climb(over, draw, len(k), COLUMNS)
        wrong = best > MARGIN * (1 + stated)
        if wrong.any():
            return first_wrong(wrong, loop.at(k, z), f"{name} is {(best + stated)[wrong][0]:.7g}")
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


def _torque(loop: Loop, _: Data, k: NDArray[np.int64], z: Floats) -> Floats:
    """Return |T_g'|."""
    at, xi = loop.at(k, z), states(loop.P, z[:, 3:7])
    wind = at.wind + (2 * z[:, 7] - 1) * loop.stated("wind_error", k)
    rate = (2 * z[:, 8] - 1) * loop.stated("wind_rate", k)
    moved, t, s = loop.motion(at, xi, wind, rate), at.table, at.slope
    signal = xi[:, 0] - xi[:, 2]
    U = t["trim_effort"] + t["proportional"] * signal
    dU = (s["trim_effort"] + s["proportional"] * signal) * rate
    dU += t["proportional"] * (moved.xi[:, 0] - moved.xi[:, 2])
    found = loop.law["effort_torque"] * share(-U, loop.law["overlap"]) * abs(dU)
    return np.where(_inside(loop, xi, moved.pitch), found, -np.inf)


def why_actuators_misshown(loop: Loop, claim: Data, statement: str) -> str:
    """Return what is shown better than it is stated."""
    pitch, torque = (_stated(claim, name) for name in ("pitch_rate", "torque_rate"))
    most, own = loop.number["pitch_rate_limit"], loop.number["torque_rate_limit"]
    # What is said to stay below a limit does so as the limit is told, which is never too high.
    told = re.search(r"limit of (\S+) rad/s", statement)
    below = np.count_nonzero(pitch < (most if told is None else float(told[1])))
    # (words, the number that is stated, whether more than it is too much)
    compared = (
        (r"pitch moves at most at (\S+) rad/s", pitch.max(), False),
        (r"and in (\d+) stays below", below, True),
        (r"limit of (\S+) rad/s", most, True),
        (r"asked for moves at most at (\S+) N m/s", torque.max(), False),
        (r"and in (\d+) within", np.count_nonzero(torque <= own), True),
        (r"turbine's limit of (\S+) N m/s", own, False),
        (r"nor the pitch asked for jumps \((\S+) N m", 0.0, False),
    )
    for words, number, more in compared:
        shown = re.search(words, statement)
        if shown is None:
            continue
        over = float(shown[1].rstrip(",;")) - number
        if (over if more else -over) > MARGIN * (1 + abs(number)):
            return f"shown better than stated: {shown[0]}"
    return ""


# The claim about the loop with its observer, which no ``Loop`` has.
RUNNING = "running-loop"
POINTS, CLIMBERS, SETTLERS = 150, 30, 12
BISECTIONS = 44
# Rows h of h xi.
WIDTHS = {
    "speed_error": (1.0, 0.0, 0.0),
    "effort_lag": (0.0, 1.0, 0.0),
    "speed_signal": (1.0, 0.0, -1.0),
    "integral": (0.0, 0.0, 1.0),
}


def why_false(document: Data, rng: random.Random, statements: Sequence[str] = ()) -> str:
    """Return what is false in a turbine's certificate, and where; empty when nothing was seen.

    statements : what the checker shows, claim by claim; its numbers are compared.
    """
    draw = np.random.default_rng(rng.getrandbits(32))
    for claim in document["claims"]:
        if claim["kind"] == RUNNING:
            if why := why_running_false(document, claim, draw):
                return why
        elif why := KINDS[claim["kind"]](_loop_of(document, claim), claim, draw):
            return why
    return why_shown_false(document, statements)


def why_shown_false(document: Data, statements: Sequence[str]) -> str:
    """Return what is shown better than the certificate states it; empty when nothing is."""
    for claim, statement in zip(document["claims"], statements, strict=False):
        if claim["kind"] == RUNNING:
            if why := why_running_misshown(claim, statement):
                return why
        elif why := SHOWN[claim["kind"]](_loop_of(document, claim), claim, statement):
            return why
    return ""


def _loop_of(document: Data, claim: Data) -> Loop:
    """Return the loop of the claim of kind ``coherent-loop`` that a claim is or rests on."""
    rested_on = document["claims"][int(float(claim["loop"]))] if "loop" in claim else claim
    return Loop(document, rested_on)


def _why_loop_false(loop: Loop, _: Data, draw: np.random.Generator) -> str:
    """Return what is false in a claim of kind ``coherent-loop``."""
    return _set(loop) or _coefficients(loop, draw) or _invariance(loop, draw) or _decay(loop, draw)


def _set(loop: Loop) -> str:
    """Peaks of {V <= 1}, and the cells."""
    if min(np.linalg.eigvalsh(M).min() for M in (loop.P, loop.R)) <= 0:
        return "a quadratic function is not positive definite"
    inverse, peaks = np.linalg.inv(loop.P), {}
    for name, h in WIDTHS.items():
        peaks[name] = float(np.sqrt(h @ inverse @ np.array(h)))
        limit = loop.law["integral_limit"] if name == "integral" else loop.box[name]
        if peaks[name] > min(float(loop.claim["peaks"][name]), limit) * (1 + MARGIN):
            return f"{name} reaches {peaks[name]:.7g}"
    if [column(cell["wind"]).tolist() for cell in loop.cells] != [
        [*pair] for pair in pairwise(loop.wind.tolist())
    ]:
        return "the cells are not the law's"
    return ""


def _shown(loop: Loop, _: Data, statement: str) -> str:
    """Return a range that is shown wider, or a class or rate shown larger, than it is stated."""
    if why := overspeed_shown(loop, statement):
        return why
    low, high = loop.kappa[1] ** -1, loop.kappa[0] ** -1
    inside = {
        r"winds (\S+) to (\S+) m/s in": (loop.wind[0], loop.wind[-1]),
        r"inertia (\S+) to (\S+) of nominal": (low, high),
    }
    for words, (first, last) in inside.items():
        shown = re.search(words, statement)
        if shown and not first - MARGIN <= float(shown[1]) <= float(shown[2]) <= last + MARGIN:
            return f"more is shown than is stated: {shown[0]}"
    every = np.arange(len(loop.cells))
    classes = {
        "wind_error": r"v_s\| up to (\S+) to (\S+) m/s",
        "wind_rate": r"v_s'\| up to (\S+) to (\S+) m",
    }
    for name, words in classes.items():
        shown, values = re.search(words, statement), loop.stated(name, every)
        if shown and (float(shown[1]) > values.min() or float(shown[2]) > values.max()):
            return f"more is shown than is stated: {shown[0]}"
    shown = re.search(r"no less than (\S+) 1/s .*, up to (\S+) 1/s by", statement)
    common, most = float(loop.claim["settling"]["decay_rate"]), loop.stated("decay_rate", every)
    if shown and (float(shown[1]) > common or float(shown[2]) > most.max()):
        return f"more is shown than is stated: {shown[0]}"
    return ""


def _coefficients(loop: Loop, draw: np.random.Generator) -> str:
    """Compare every coefficient that a cell states with the loop's at points of the box."""
    k = np.repeat(np.arange(len(loop.cells)), POINTS)
    z = drawn(draw, len(k), 8)
    at, box, law = loop.at(k, z), loop.box, loop.law
    t, s = at.table, at.slope
    e, zeta, y = (
        (2 * z[:, 3 + i] - 1) * box[name]
        for i, name in enumerate(("speed_error", "effort_lag", "speed_signal"))
    )
    U, b, gamma = t["trim_effort"] + t["proportional"] * y, t["effectiveness"], t["proportional"]
    F, shed = share(U, law["overlap"]), psi(U, law["overlap"])
    zeta = np.minimum(zeta, shed)
    reach = loop.stated("wind_rate", k)
    rate = (2 * z[:, 6] - 1) * reach
    moved = loop.motion(at, np.stack([e, zeta, e - y], 1), at.wind, rate)
    speed, R = t["rotor_speed"], loop.number["rotor_radius"]
    sigma = loop.steepness(at, law["pitch_min"] + shed / b) / b
    own = zeta / (b * loop.number["pitch_time_constant"])
    with np.errstate(divide="ignore", invalid="ignore"):
        h = np.where(abs(own) > 1e-6, moved.drive / own, np.nan)
    found = {
        "stiffness": at.kappa
        * loop.c
        * at.power
        * at.wind
        * R
        * loop.cq(speed + e, moved.pitch, at.wind, (1, 0)),
        "loop_gain": at.kappa * gamma * (loop.m - F * (loop.m - sigma)),
        "lag_gain": at.kappa * loop.steepness(at, moved.pitch) / b,
        "share_gain": F * gamma,
        "lag_rate": h / loop.number["pitch_time_constant"],
    }
    for name, values in found.items():
        ends = np.array([column(cell[name]) for cell in loop.cells])[k]
        # A lag rate is a quotient by a small number.
        free = MARGIN * (1 + abs(values)) * (100 if name == "lag_rate" else 1)
        wrong = (values < ends[:, 0] - free) | (values > ends[:, 1] + free)
        if name != "lag_rate":
            wrong |= np.isnan(values)
        if wrong.any():
            return first_wrong(wrong, at, f"{name} is {values[np.argmax(wrong)]:.7g}")
    off = box["wind_share"] * loop.wind[k] * (2 * z[:, 7] - 1)
    wind, ratio = at.wind + off, (speed + e) * R / (at.wind + off)
    value, steep = (loop.cq(speed + e, moved.pitch, wind, nu) for nu in ((0, 0), (1, 0)))
    trim = t["trim_effort"]
    rest = law["pitch_min"] + psi(trim, law["overlap"]) / b
    driving = loop.c * at.power * at.wind**2 * loop.cq(speed, rest, at.wind, (0, 0))
    residual = driving - loop.rated
    residual += loop.m * psi(-trim, law["overlap"])
    sizes = {
        "residual": residual,
        "wind_gain": loop.c * at.power * wind * (2 * value - ratio * steep),
        "inertia_gain": at.kappa,
        "effectiveness_slope": s["effectiveness"] / b,
        "lag_disturbance": moved.turn,
    }
    for name, values in sizes.items():
        wrong = ~(abs(values) <= loop.stated(name, k) + MARGIN)
        if wrong.any():
            return first_wrong(wrong, at, f"{name} is {values[np.argmax(wrong)]:.7g}")
    wrong = abs(s["rotor_speed"] * rate) > loop.stated("reference_slope", k) * reach + MARGIN
    return first_wrong(wrong, at, "reference_slope is exceeded")


def _invariance(loop: Loop, draw: np.random.Generator) -> str:
    """Look for V' + alpha (V - 1) >= 0 in the set, and for limits that are met there."""
    k = np.repeat(np.arange(len(loop.cells)), CLIMBERS)
    error, reach, alpha = (loop.stated(x, k) for x in ("wind_error", "wind_rate", "multiplier"))
    met: list[str] = []

    def rise(z: Floats) -> Floats:
        at, xi = loop.at(k, z), states(loop.P, z[:, 3:7], 1.5)
        wind, rate = at.wind + (2 * z[:, 7] - 1) * error, (2 * z[:, 8] - 1) * reach
        moved = loop.motion(at, xi, wind, rate)
        V = np.einsum("ni,ij,nj->n", xi, loop.P, xi)
        falls = 2 * np.einsum("ni,ij,nj->n", xi, loop.P, moved.xi)
        known = moved.pitch >= loop.law["pitch_min"]
        for name in ("speed_error", "effort_lag", "speed_signal"):
            known &= abs(xi @ np.array(WIDTHS[name])) <= loop.box[name]
        for name, wrong in (
            ("torque below zero is asked for", moved.torque < -MARGIN * loop.law["rated_torque"]),
            ("pitch beyond its limit is asked for", moved.asked > loop.law["pitch_max"] + MARGIN),
            ("pitch passes its limit", moved.pitch > loop.number["pitch_max"] + MARGIN),
            ("the surface ends", ~np.isfinite(falls)),
        ):
            met.extend(filter(None, [first_wrong(wrong & known, at, name)]))
        return np.where(known, falls + alpha * (V - 1), -np.inf)

    z, best = climb(rise, draw, len(k), 9)
    wrong = best > MARGIN
    risen = f"V' + a (V - 1) is {best.max():.3g}"
    return met[0] if met else first_wrong(wrong, loop.at(k, z), risen)


def _decay(loop: Loop, draw: np.random.Generator) -> str:
    """Look for a state at constant wind that falls slower than is stated, by cell or in common."""
    k = np.repeat(np.arange(len(loop.cells)), SETTLERS)
    still, common = np.zeros(len(k)), float(loop.claim["settling"]["decay_rate"])
    slow = loop.stated("decay_rate", k)
    at = loop.at(k, drawn(draw, len(k), 3))
    low, high = still - loop.box["speed_signal"], still + loop.box["speed_signal"]
    for _ in range(BISECTIONS):
        x = (low + high) / 2
        rises = loop.motion(at, np.stack([still, still, x], 1), at.wind, still).xi[:, 0] > 0
        low, high = np.where(rises, low, x), np.where(rises, x, high)
    rest = np.stack([still, still, (low + high) / 2], 1)
    if (wrong := np.einsum("ni,ij,nj->n", rest, loop.P, rest) > 1 + MARGIN).any():
        return first_wrong(wrong, at, "the equilibrium is not in the set")
    for M, rate, name in ((loop.P, slow, "decay"), (loop.R, common, "common decay")):

        def rise(z: Floats, M: Floats = M, rate: Any = rate) -> Floats:
            xi = states(loop.P, z)
            moved, off = loop.motion(at, xi, at.wind, still), xi - rest
            W = np.einsum("ni,ij,nj->n", off, M, off)
            falls = 2 * np.einsum("ni,ij,nj->n", off, M, moved.xi)
            known = (moved.pitch >= loop.law["pitch_min"]) & (W > 1e-3)
            return np.where(known, falls / np.maximum(W, 1e-3) + 2 * rate, -np.inf)

        _, best = climb(rise, draw, len(k), 4)
        if (wrong := best > MARGIN).any():
            return first_wrong(wrong, at, f"{name} is slower")
    return ""


KINDS: dict[str, Callable[[Loop, Data, np.random.Generator], str]] = {
    "coherent-loop": _why_loop_false,
    "wind-rate": why_wind_rate_false,
    "bumpless": why_actuators_false,
}
SHOWN: dict[str, Callable[[Loop, Data, str], str]] = {
    "coherent-loop": _shown,
    "wind-rate": why_wind_rate_misshown,
    "bumpless": why_actuators_misshown,
}
