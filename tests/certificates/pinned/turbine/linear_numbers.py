"""The linear loop in turbulence: trims, matrices, ranges and pieces, and what is answered."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial
from itertools import islice
from math import isqrt
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.spline_point import ExactSurface
from takagi.certificates.checker.kernel.matrices import Matrix, read_stack
from takagi.certificates.checker.kinds.crossing_probability import crossing_bound
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.linear_loop.crossing_claim import (
    LinearLoop,
    _square,
    check_turbine_crossing,
    piece_failure,
)
from takagi.certificates.checker.turbine.linear_loop.jacobian import (
    loop_matrix,
    noise_square,
    order,
    signal_row,
)
from takagi.certificates.checker.turbine.linear_loop.pieces import (
    PARAMETERS,
    Turbulence,
    corners,
    cut_boxes,
    halves,
    parameter_box,
)
from takagi.certificates.checker.turbine.linear_loop.trim import trim_at
from takagi.certificates.checker.turbine.running_loop.inputs import Machine
from tests.certificates.pinned.turbine.running_numbers import tilted
from tests.certificates.pinned.turbine.values import Named, said
from tests.certificates.recorded.answers import recorded

F = Fraction
# Below the ramp of the effort, on it, and above it.
WINDS = (F("4.1"), F(8), F("10.6"), F("11.4"), F("11.65"), F(12), F("22.2"))
DRAWN = dict(zip(PARAMETERS, map(F, ("0.9", "1.1", "0.8", "1.2", "0.3", "51")), strict=True))


def document(number: int) -> Any:
    return json.loads(next(islice(recorded("turbine-crossing"), number, None))[1])


@cache
def parts() -> tuple[Plant, Law, Machine, ExactSurface, Turbulence]:
    """Return plant, law, observer and filters, surface and wind of the first document."""
    data = read_text(json.dumps(document(0)), "certificate")
    claim, model = data["claims"][0], data["model"]
    machine = Machine.read(claim, model, data["gains"], "claim")
    law, surface = Law.read(data["gains"]), ExactSurface.read(model)
    return Plant.read(model), law, machine, surface, Turbulence.read(claim, "claim")


def fed() -> Law:
    """Return a law that differs from node to node, with both feed-forwards and a wide overlap.

    Of the effectiveness the differences are small: with others the torques differ at the trim.
    """
    law = parts()[1]
    effectiveness = [b * (1 + F(j % 7, 9000)) for j, b in enumerate(law.effectiveness)]
    law = replace(tilted(law), effectiveness=effectiveness, overlap=F(1, 25), lead=F(3, 10))
    ahead = [F(1 + j % 3, 9) if q < law.overlap else F(0) for j, q in enumerate(law.effort[1:])]
    return replace(law, inertia=ahead, inertia_limit=[F(1)] * len(ahead))


def whole(matrix: Matrix) -> Any:
    return [[F(x, matrix.below) for x in row] for row in matrix.rows]


def of_loop(wind: Fraction, words: str) -> Named:
    """Yield trim and matrix at a wind."""
    plant, law, machine, surface, turbulence = parts()
    law = {"as stated": law, "fed forward": fed()}[words]
    trim = said(trim_at, plant, law, machine, surface, wind)
    yield "trim", trim
    if isinstance(trim, str):
        return
    for stop in (True, False):
        one = machine if stop else replace(machine, stop=None)
        yield f"matrix {stop}", whole(loop_matrix(trim, plant, one, turbulence, DRAWN))
        yield f"row {stop}", (order(one), whole(signal_row(trim, one)))
        yield f"noise {stop}", whole(noise_square(turbulence, one))


def of_refusals() -> Named:
    """Yield the words for a wind, and at each limit where the loop has no derivative."""
    plant, law, machine, surface, _ = parts()
    nodes, count = law.wind, len(law.wind) - 1

    def answer(wind: Fraction, machine: Machine = machine, **changes: Any) -> str:
        found = said(trim_at, plant, replace(law, **changes), machine, surface, wind)
        return found if isinstance(found, str) else "has a matrix"

    little, at = F(1, 10**9), F(8)
    for wind in (nodes[0] - 1, nodes[0], nodes[1], nodes[-2], nodes[-1], nodes[-1] + 1):
        yield f"wind {wind}", answer(wind)
    for wind in (nodes[0] + little, nodes[-1] - little):
        yield f"wind {float(wind):.12g}", answer(wind)
    for low, high in ((8, 25), (8 - little, 25), (3, 8), (3, 8 + little)):
        limited = replace(machine, wind_limits=(F(low), F(high)))
        yield f"estimates {low} to {high}", answer(at, machine=limited)
    still, ahead = [F(0)] * count, [F(1, 9)] * count
    moving: dict[str, Any] = {"inertia": ahead, "inertia_limit": [F(1)] * count}
    yield "feed-forward", answer(at, **moving)
    yield "feed-forward with a limit of 0", answer(at, inertia=ahead, inertia_limit=still)
    yield "none, with a limit of 0", answer(at, inertia=still, inertia_limit=still)
    for wind in (F(12), F("22.2")):
        yield f"feed-forward at {wind}", answer(wind, **moving)
    # At 8 m/s psi is 0 and pitch at its lower limit, which is that of the table.
    for limit in (law.pitch_min, law.pitch_min + little):
        yield f"pitch below {float(limit):.10g}", answer(at, pitch_max=limit)
    own = trim_at(plant, law, machine, surface, at)
    braked = law.rated_torque / law.effort_torque
    # Torque of E times a number: at zero, and just above it.
    asked = -sum(law.effort[k] * w for k, w in _near(law, at))
    for name, torque in (("zero", F(0)), ("above zero", little), ("below zero", -little)):
        yield f"torque {name}", answer(at, rated_torque=law.effort_torque * asked + torque)
    yield "where they are", (braked, asked, own.residual)
    for residual in (F(1, 10), F(1, 10) + little, F(-1, 10), F(-1, 10) - little):
        # n_g / J times torque is what the residual lacks.
        more = (own.residual - residual * law.overlap) / plant.gear_per_inertia
        yield f"residual {float(residual):.10g}", answer(at, rated_torque=law.rated_torque + more)


def _near(law: Law, wind: Fraction) -> list[tuple[int, Fraction]]:
    k = max(j for j, node in enumerate(law.wind) if node <= wind)
    share = (wind - law.wind[k]) / (law.wind[k + 1] - law.wind[k])
    return [(k, 1 - share), (k + 1, share)]


def of_ranges() -> Named:
    """Yield the wind's numbers, the box, and its trees of halves."""
    wind = Turbulence(F(3, 2), F(1, 5), F(7))
    yield "wind", (wind.stiffness, wind.damping, wind.intensity)
    claim = document(0)["claims"][0]

    def box_of(name: str, low: float, high: float) -> Any:
        changed = deepcopy(claim)
        changed["uncertainty"][name] = [low, high]
        return said(parameter_box, read_text(json.dumps(changed), "claim"), "claim")

    for name in PARAMETERS:
        for low, high in ((0.0, 2.0), (0.0, 0.0), (1.0, 1.0), (-1e-9, 1.0), (1.0, 0.999)):
            yield f"{name} {low:g} {high:g}", box_of(name, low, high)
    box = parameter_box(read_text(json.dumps(claim), "claim"), "claim")
    yield "corners", [list(one.values()) for one in corners(box)]
    yield "halves", halves(box, "speed_damping")
    first, other = "inertia", "wake_of_wind"
    trees: tuple[list[Any], ...] = (
        [],
        [""],
        ["", ""],
        [first, "", ""],
        [first, ""],
        [first, "", "", ""],
        [first, other, "", "", ""],
        [first, "", other, "", ""],
        [first, first, "", other, "", "", ""],
        ["mass", "", ""],
        [0, "", ""],
        ["wake_length", "", ""],
        [first, "wake_length", "", "", ""],
        *([first, ""] * count + [""] for count in (255, 256)),
    )
    for cuts in trees:
        words = f"{len(cuts)} {cuts[:5]}"
        read = read_text(json.dumps({"cuts": cuts}), "claim")
        yield words, said(cut_boxes, read, box, "claim")
    yield "no cuts", cut_boxes({}, box, "claim")


def of_pieces() -> Named:
    """Yield which condition fails on one piece."""
    plant, law, machine, surface, turbulence = parts()
    data = read_text(json.dumps(document(0)), "certificate")
    claim = data["claims"][0]
    trim = trim_at(plant, law, machine, surface, F(8))
    # One vertex is enough: all parameters in the middle.
    box = {n: ((a + b) / 2,) * 2 for n, (a, b) in parameter_box(claim, "claim").items()}
    C = read_stack(claim, "C", "claim")[0]
    row = signal_row(trim, machine)
    variance, loop, T = _square(row, C), (plant, machine, turbulence, trim), F(600)
    # Rational numbers beside the deviation; a covariance whose deviation is the upper one.
    deviation = F(isqrt(int(variance * 10**24)), 10**12)
    above = deviation + F(1, 10**11)
    rate = max(_square(row @ A, C) for A in LinearLoop(*loop, F(1)).at(box))
    bound = crossing_bound(ratio=F("0.2534") ** 2 / (2 * variance), rate=rate / variance, horizon=T)
    for name, limit, matrix, probability in (
        ("as stated", F("0.2534"), C, F(1, 1000)),
        ("the probability of the bound", F("0.2534"), C, bound),
        ("a probability below the bound", F("0.2534"), C, bound - F(1, 10**40)),
        ("a small probability", F("0.2534"), C, F(1, 10**9)),
        ("a limit below a deviation", deviation - F(1, 10**11), C, F(100)),
        ("a limit of a deviation", above, above**2 / variance * C, F(100)),
        ("not symmetric", F("0.2534"), Matrix.of(_moved(C)), F(1, 1000)),
        ("negative", F("0.2534"), -C, F(1, 1000)),
        ("too small", F("0.2534"), F(9, 10) * C, F(1, 1000)),
    ):
        yield name, piece_failure(LinearLoop(*loop, limit), box, matrix, T, probability)


def _moved(matrix: Matrix) -> Any:
    found = whole(matrix)
    found[0][1] += F(1, 10**6)
    return found


CLAIM = ("claims", 0)
CHANGES: dict[str, tuple[int, tuple[str | int, ...], Any]] = {
    "as stated": (0, (*CLAIM, "name"), "a loop"),
    "in pieces": (1, (*CLAIM, "name"), "a loop"),
    "a failing piece": (1, (*CLAIM, "probability"), 1e-9),
    "a probability of 1": (0, (*CLAIM, "probability"), 1.0),
    "a probability of 0": (0, (*CLAIM, "probability"), 0.0),
    "a horizon of 0": (0, (*CLAIM, "horizon"), 0.0),
    "no overspeed": (0, (*CLAIM, "overspeed"), 0.0),
    "a wind of 0": (0, (*CLAIM, "wind"), 0.0),
    "a wind at a node": (0, (*CLAIM, "wind"), 7.7755),
    "two pieces": (0, (*CLAIM, "cuts"), ["inertia", "", ""]),
    "a covariance of order 1": (0, (*CLAIM, "C"), [[[1.0]]]),
    "a covariance of 12 rows": (0, (*CLAIM, "C"), [[[1.0] * 13] * 12]),
    "two covariances": (0, (*CLAIM, "C"), [[[1.0] * 13] * 13] * 2),
}


def of_claim(name: str) -> Named:
    """Yield what is found of the claim, or why it is refused."""
    number, place, value = CHANGES[name]
    changed = document(number)
    holder = changed
    for step in place[:-1]:
        holder = holder[step]
    holder[place[-1]] = value
    if name == "two pieces":
        # Both fail.
        changed["claims"][0] |= {"C": changed["claims"][0]["C"] * 2, "probability": 1e-9}
    data = read_text(json.dumps(changed), "certificate")
    found = said(check_turbine_crossing, data["claims"][0], data, "claims[0]")
    if isinstance(found, str):
        yield name, found
        return
    yield "verdict", found.verdict.name
    yield "said", {key: value for key, value in found.given.items() if key != "stated"}


def groups() -> dict[str, Callable[[], Named]]:
    found: dict[str, Callable[[], Named]] = {
        f"linear loop, {words}, {wind}": partial(of_loop, wind, words)
        for words in ("as stated", "fed forward")
        for wind in WINDS
    }
    found |= {f"linear claim, {name}": partial(of_claim, name) for name in CHANGES}
    return found | {
        "linear refusals": of_refusals,
        "linear ranges": of_ranges,
        "linear pieces": of_pieces,
    }
