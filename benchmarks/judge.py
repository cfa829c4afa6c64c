"""Whether the sentence of a claim is false, by an exact counterexample, claim kind by claim kind.

Each function tries the claim at one drawn blend of the loop, see ``second_reading``, and returns
why it is false there, or an empty text.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import problem_judge
from second_reading import (
    Data,
    Loop,
    Mat,
    blend,
    blocks,
    identity,
    is_definite,
    is_semidefinite,
    is_symmetric,
    matrix,
    rational,
    why_not_the_plant,
    zeros,
)

DRAWS = 40


def why_false(document: Data, rng: random.Random) -> str:
    """Return which claim of a document is false, and why; empty when none was seen to be."""
    if document["model"]["kind"] == "conic-problem":
        return problem_judge.why_false(document)
    loop = Loop(document)
    law, model = document.get("gains"), document["model"]
    if law is not None:
        for names, variables in (("state_names", "states"), ("input_names", "inputs")):
            ours = model.get(names)
            if model["kind"] == "plant":
                ours = [f"{v.get('symbol', v['name'])} [{v['unit']}]" for v in model[variables]]
            if ours and law.get(names, ours) != ours:
                return f"the {variables} of the law are others"
    for claim in document["claims"]:
        kind = claim["kind"]
        if kind == "sector-embedding":
            why = why_not_the_plant(document, rng)
        else:
            why = next(filter(None, (TRIED[kind](loop, claim, rng) for _ in range(DRAWS))), "")
        if why:
            return f"{kind}: {why}"
    return ""


def exponential(x: Any) -> Any:
    """Return e^-x to sixty digits."""
    with localcontext() as context:
        context.prec = 60
        exact = Fraction(int(x.p), int(x.q))
        return rational(Fraction((-(Decimal(exact.numerator) / exact.denominator)).exp()))


def decreases(loop: Loop, P: Mat, G: Mat, rate: Any) -> bool:
    """Return whether V = x'Px falls as e^(-2 rate t) along G, but for the last of sixty digits."""
    if loop.step is None:
        left = -(P * G + G.transpose() * P + P * (2 * rate))
        return is_definite(left) if rate == 0 else is_semidefinite(left)
    if rate == 0:
        return is_definite(P - G.transpose() * P * G)
    kept = exponential(2 * rate * loop.step) * (1 + rational(Fraction(1, 10**50)))
    return is_semidefinite(P * kept - G.transpose() * P * G)


def function(claim: Data, order: int) -> tuple[Mat, str]:
    """Return P, and what is wrong with it."""
    P = matrix(claim["P"])
    wrong = P.nrows() != order or not is_symmetric(P) or not is_definite(P)
    return P, "P is not positive definite" if wrong else ""


def decay(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    h, g = loop.pair(rng)
    rate = rational(claim["decay_rate"])
    if rate < 0:
        return "negative rate"
    return why or ("" if decreases(loop, P, loop.closed(h, g), rate) else f"V rises at {h}")


def transient(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, _ = function(claim, loop.order)
    scales = [rational(s) for s in claim["scales"]]
    keys = ("lower", "overshoot", "settled_share", "settling_time", "decay_rate")
    lower, kappa, share, time, rate = (rational(claim[key]) for key in keys)
    weight = identity(loop.order)
    for k, s in enumerate(scales):
        weight[k, k] = lower / s**2
    if min(lower, kappa, share, time, rate, *scales) <= 0:
        return "a number that has to be positive is not"
    if not (is_semidefinite(P - weight) and is_semidefinite(weight * kappa**2 - P)):
        return "P is not between its bounds"
    if kappa * exponential(rate * time) > share * (1 + rational(Fraction(1, 10**50))):
        return "not settled"
    return decay(loop, claim, rng)


def region(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    G = loop.closed(*loop.pair(rng))
    for part in claim["parts"]:
        L, M = matrix(part["L"]), matrix(part["M"])
        size = range(L.nrows())
        PG, GP = P * G, G.transpose() * P
        whole = blocks([[P * L[a, b] + PG * M[a, b] + GP * M[b, a] for b in size] for a in size])
        if not is_definite(-whole):
            why = why or "a pole leaves the region"
    return why


def gain_rounding(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    h, g = loop.pair(rng)
    absolute, relative = matrix(claim["absolute"]), rational(claim["relative"])
    moved = []
    for _ in range(loop.count):
        for K in loop.gains:
            D = K * 0
            for k in range(K.nrows()):
                for j in range(K.ncols()):
                    D[k, j] = rng.choice((-1, 1)) * (absolute[k, j] + relative * abs(K[k, j]))
            moved.append(K + D)
    K = blend(moved[: len(loop.gains)], g)
    rate = rational(claim["decay_rate"])
    return why or ("" if decreases(loop, P, loop.closed(h, g, K), rate) else f"V rises at {h}")


def change(loop: Loop, P: Mat, G: Mat, B: Mat) -> tuple[Mat, Mat, Mat]:
    """Return (F, PG, H) of V' = -x'Fx + 2 x'PGw + w'Hw."""
    if loop.step is None:
        return -(P * G + G.transpose() * P), P * B, zeros(B.ncols(), B.ncols())
    return P - G.transpose() * P * G, G.transpose() * P * B, B.transpose() * P * B


def beyond(P: Mat, level: Any, row: Mat, side: Any) -> bool:
    """Return whether {x'Px <= level} reaches beyond a side along a row."""
    reach = (row * P.inv() * row.transpose())[0, 0] * level
    half = min(-side[0], side[1])
    return bool(half < 0 or reach > half**2)


def row_of(M: Mat, k: int) -> Mat:
    return matrix([[M[k, j] for j in range(M.ncols())]])


def out_of_box(loop: Loop, P: Mat, level: Any, K: Mat | None, added: Any = 0) -> str:
    states, inputs = loop.sides
    one = identity(loop.order)
    for k, side in enumerate(states):
        if side is not None and beyond(P, level, row_of(one, k), side):
            return f"the set leaves the range of state {k + 1}"
    for k, side in enumerate(inputs):
        if side is not None and K is not None:
            narrow = [side[0] + added, side[1] - added]
            if beyond(P, level, row_of(K, k), narrow):
                return f"the set leaves the range of input {k + 1}"
    return ""


def invariant_set(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    if why:
        return why
    level, s = rational(claim["level"]), rational(claim["multiplier"])
    if level <= 0 or s <= 0:
        return "level and multiplier are positive"
    h, g = loop.pair(rng)
    G = loop.closed(h, g)
    K = blend(loop.gains, g) if loop.gains else None
    if "disturbance" not in claim:
        F, _, _ = change(loop, P, G, zeros(loop.order, 1))
        if not is_semidefinite(F - P * s):
            return f"V rises at {h}"
        return out_of_box(loop, P, level, K)
    E = loop.entrance(claim, h)
    if "disturbance_norm" in claim:
        bounds = [rational(claim["disturbance_norm"])] * E.ncols()
        W = identity(E.ncols(), bounds[0])
    else:
        bounds = [rational(b) for b in claim["disturbance_bounds"]]
        W = matrix([[rng.choice((-1, 1)) * b] for b in bounds])
    F, PG, H = change(loop, P, G, E * W)
    whole = blocks([[F - P * s, -PG], [-PG.transpose(), identity(W.ncols(), s * level) - H]])
    if min(bounds) < 0 or not is_semidefinite(whole):
        return f"V leaves its level at {h}"
    disturbed = claim["disturbance"] == "disturbances" and loop.pushed
    sides = [loop.pushed[k] for k in loop.entering(claim)] if disturbed else []
    for b, side in zip(bounds, sides, strict=False):
        if side is not None and b > min(-side[0], side[1]):
            return "the disturbance leaves its range"
    added = max(bounds) if claim["disturbance"] == "inputs" else 0
    return out_of_box(loop, P, level, K, added)


def input_limits(loop: Loop, claim: Data, rng: random.Random) -> str:
    why = invariant_set(loop, claim, rng)
    if why:
        return why
    P, level = matrix(claim["P"]), rational(claim["level"])
    h, g = loop.pair(rng)
    K, G = blend(loop.gains, g), loop.closed(h, g)
    move = K * G if loop.step is None else K * G - K
    for k, limit in enumerate(map(rational, claim["input_limits"])):
        if limit < 0 or beyond(P, level, row_of(K, k), [-limit, limit]):
            return f"input {k + 1} exceeds its limit"
    for k, limit in enumerate(map(rational, claim.get("rate_limits", []))):
        if limit < 0 or beyond(P, level, row_of(move, k), [-limit, limit]):
            return f"the rate of input {k + 1} exceeds its limit"
    return ""


def path(loop: Loop, claim: Data, h: Any, g: Any) -> tuple[Mat, Mat, Mat, Mat]:
    """Return (A, B, C, D) from the disturbance to the output of model."""
    G, C = loop.closed(h, g), loop.closed(h, g, letters="CD")
    if claim["disturbance"] == "disturbances":
        E = loop.entrance(claim, h)
        return G, E, C, zeros(C.nrows(), E.ncols())
    return G, loop.blended("B", h), C, loop.blended("D", h)


def dissipated(F: Mat, PG: Mat, H: Mat, C: Mat, D: Mat, gain: Any) -> bool:
    """Return whether V' <= gain |w|^2 - |y|^2 / gain, for V' = -x'Fx + 2 x'PGw + w'Hw."""
    side = -(PG + C.transpose() * D * (1 / gain))
    corner = identity(D.ncols(), gain) - H - D.transpose() * D * (1 / gain)
    whole = blocks([[F - C.transpose() * C * (1 / gain), side], [side.transpose(), corner]])
    return is_semidefinite(whole)


def l2_gain(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    h, g = loop.pair(rng)
    A, B, C, D = path(loop, claim, h, g)
    gain = rational(claim["gain"])
    if gain <= 0:
        return "the gain is not positive"
    if not dissipated(*change(loop, P, A, B), C, D, gain):
        return f"more energy leaves at {h}"
    if "energy_bound" in claim and not why:
        level = gain * rational(claim["energy_bound"]) ** 2
        return out_of_box(loop, P, level, blend(loop.gains, g) if loop.gains else None)
    return why


def h2_norm(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    A, B, C, D = path(loop, claim, *loop.pair(rng))
    F, _, _ = change(loop, P, A, B)
    power = B.transpose() * P * B + D.transpose() * D
    variance = sum((power[k, k] for k in range(power.nrows())), rational(0))
    if not is_semidefinite(F - C.transpose() * C) or variance > rational(claim["norm"]) ** 2:
        return "the variance is larger"
    return why


def peak(loop: Loop, claim: Data, rng: random.Random) -> str:
    why = invariant_set(loop, claim, rng)
    if why:
        return why
    _, _, C, D = path(loop, claim, *loop.pair(rng))
    bound, gain = rational(claim["disturbance_norm"]), rational(claim["gain"])
    share = rational(claim.get("share", "0"))
    P = matrix(claim["P"]) * ((1 - share) / rational(claim["level"]))
    whole = blocks(
        [
            [P, zeros(loop.order, D.ncols())],
            [zeros(D.ncols(), loop.order), identity(D.ncols(), share / bound**2)],
        ]
    )
    CD = blocks([[C, D]])
    if gain <= 0 or not is_semidefinite(whole * (gain * bound) ** 2 - CD.transpose() * CD):
        return "the output is larger"
    return ""


def weighted(loop: Loop, claim: Data) -> list[Mat]:
    """Return the functions P_i of P(h) = sum_i h_i P_i."""
    listed = {tuple(int(Fraction(v)) for v in e["powers"][0]): e["matrix"] for e in claim["P"]}
    return [
        matrix(listed[tuple(int(k == i) for k in range(loop.count))]) for i in range(loop.count)
    ]


def fuzzy_l2_gain(loop: Loop, claim: Data, rng: random.Random) -> str:
    """As ``l2_gain`` by the function of ``fuzzy_decay``."""
    h, g = loop.pair(rng)
    A, B, C, D = path(loop, claim, h, g)
    functions, gain = weighted(loop, claim), rational(claim["gain"])
    P = blend(functions, h)
    if gain <= 0 or not is_symmetric(P) or not is_definite(P):
        return "the gain is not positive, or P(h) not positive definite"
    i, j = rng.sample(range(loop.count), 2)
    bounds = [rational(b) for b in claim["rates"][0]]
    F, PG, H = change(loop, P, A, B)
    if loop.step is None:
        F = F - (functions[i] - functions[j]) * min(bounds[i], bounds[j])
    else:
        after = blend(functions, loop.pair(rng)[0])
        F, PG = P - A.transpose() * after * A, A.transpose() * after * B
        H = B.transpose() * after * B
    holds = min(bounds) >= 0 and dissipated(F, PG, H, C, D, gain)
    return "" if holds else f"more energy leaves at {h}"


def fuzzy_decay(loop: Loop, claim: Data, rng: random.Random) -> str:
    """P linear in the weights of rules, and corners of their rates."""
    h, g = loop.pair(rng)
    rate, G = rational(claim["decay_rate"]), loop.closed(h, g)
    functions = weighted(loop, claim)
    P = blend(functions, h)
    if not is_symmetric(P) or not is_definite(P):
        return "P(h) is not positive definite"
    if loop.step is not None:
        after = blend(functions, loop.pair(rng)[0])
        kept = exponential(2 * rate * loop.step) * (1 + rational(Fraction(1, 10**50)))
        falls = is_semidefinite(P * kept - G.transpose() * after * G)
        return "" if falls else f"V rises at {h}"
    i, j = rng.sample(range(loop.count), 2)
    bounds = [rational(b) for b in claim["rates"][0]]
    v = min(bounds[i], bounds[j])
    moving = (functions[i] - functions[j]) * v
    left = -(P * G + G.transpose() * P + P * (2 * rate) + moving)
    return "" if min(bounds) >= 0 and is_semidefinite(left) else f"V rises at {h}"


def observer(loop: Loop, claim: Data, rng: random.Random) -> str:
    P, why = function(claim, loop.order)
    h, _ = loop.pair(rng)
    L = [matrix(one) for one in claim["L"]]
    G = loop.blended("A", h) - blend(L, h if len(L) > 1 else [1]) * loop.blended("C", h)
    rate = rational(claim["decay_rate"])
    return why or ("" if decreases(loop, P, G, rate) else f"the error rises at {h}")


TRIED: dict[str, Callable[[Loop, Data, random.Random], str]] = {
    "decay": decay,
    "transient": transient,
    "region": region,
    "gain-rounding": gain_rounding,
    "invariant-ellipsoid": invariant_set,
    "input-limits": input_limits,
    "l2-gain": l2_gain,
    "h2-norm": h2_norm,
    "peak": peak,
    "fuzzy-decay": fuzzy_decay,
    "fuzzy-l2-gain": fuzzy_l2_gain,
    "observer": observer,
}
