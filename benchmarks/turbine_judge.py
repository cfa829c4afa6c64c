"""Whether what a turbine's certificate says is false, by a search for a counterexample in floats.

The loop is ``turbine_loop``, which shares nothing with the checker.  Tried are

- coefficients: every one that a cell states, at points of cell, box, winds and uncertainty;
- invariance: V' + alpha (V - 1) < 0 in the box, so V' < 0 on V = 1, by a climb from random points;
- decay to the equilibrium at constant wind, by cell and in the common function;
- the set: peaks, limits of torque, pitch and integrator, the overspeed that is shown;
- the claims that rest on it: ``turbine_filter`` (wind rate) and ``turbine_actuators``;
- the loop with its observer: ``turbine_running``.

"No" is a counterexample beyond ``MARGIN``, far wider than the rounding of floats.  An empty answer
says only that none was found: floats at points prove nothing.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from turbine_actuators import why_actuators_false, why_actuators_misshown
from turbine_filter import why_wind_rate_false, why_wind_rate_misshown
from turbine_loop import Data, Floats, Loop, column, psi, share
from turbine_running import why_running_false, why_running_misshown
from turbine_search import MARGIN, climb, drawn, first_wrong, overspeed_shown, states

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
        h = np.where(abs(own) > 1e-6, (moved.drive - moved.lead) / own, np.nan)
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
    given = np.clip(moved.torque, 0, law["rated_torque"])
    fed = (law["rated_torque"] - given) / law["effort_torque"] - psi(-U, law["overlap"])
    sizes = {
        "residual": residual,
        "wind_gain": loop.c * at.power * wind * (2 * value - ratio * steep),
        "inertia_gain": at.kappa,
        "effectiveness_slope": s["effectiveness"] / b,
        "lag_disturbance": moved.turn - b * moved.lead,
    }
    for name, values in sizes.items():
        wrong = ~(abs(values) <= loop.stated(name, k) + MARGIN)
        if wrong.any():
            return first_wrong(wrong, at, f"{name} is {values[np.argmax(wrong)]:.7g}")
    left = abs(s["rotor_speed"] * rate - at.kappa * loop.m * fed)
    wrong = left > loop.stated("reference_slope", k) * reach + MARGIN
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
    "actuator-rates": why_actuators_false,
}
SHOWN: dict[str, Callable[[Loop, Data, str], str]] = {
    "coherent-loop": _shown,
    "wind-rate": why_wind_rate_misshown,
    "actuator-rates": why_actuators_misshown,
}
