r"""``coherent-loop``: the matrix inequalities of the turbine's claim, cell by cell.

    A = [ a - G           S          G     ]      d = (w, f w + z, 0),  z of both signs
        [ f (a - G + nu)  f S - T    f G   ]      w = kappa (r + g dv) + o v'
        [ -nu             0          0     ]

over the corners of the stated ranges of a, G, S, f, T.  For the invariance, where the schedule wind
moves, T is replaced by T -+ (b'/b) v':

    [[-(A'P + PA + alpha P), -P d], [-d'P, alpha]] > 0       {x'Px <= 1} is invariant
    -(A'P + PA + 2 rho P) > 0,  -(A'R + RA + 2 r R) > 0      decay by cell, and for all winds

{x'Px <= 1} lies inside the stated peaks, the peaks lie inside the box, and the equilibrium lies
inside the set.

``ranges`` shows after the matrices that the stated ranges enclose the turbine.
"""

from __future__ import annotations

from itertools import product
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    negative,
    scaled,
    transposed,
)
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
    table,
)
from takagi.certificates.cross_check.turbine.numbers import TurbineNumbers
from takagi.certificates.cross_check.turbine.ranges import enclosed

RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
SIZES = ("residual", "wind_gain", "inertia_gain", "effectiveness_slope", "reference_slope")
DECIMALS = 10**7  # the format allows seven decimals for the numbers of a cell
WIDTHS = {
    "speed_error": (1, 0, 0),
    "effort_lag": (0, 1, 0),
    "speed_signal": (1, 0, -1),
    "integral": (0, 0, 1),
}


def effort_sharing_loop(claim: Any, model: Any, gains: Any) -> Obligations:
    """Yield the inequalities of the module's text, then the enclosures of the turbine."""
    turbine = TurbineNumbers(claim, model, gains)
    P = table(claim, "P", (3, 3))
    settling = entry(claim, "settling")
    R, common = table(settling, "P", (3, 3)), rational(settling, "decay_rate")
    yield Definite("P", P)
    yield Definite("the common P", R)
    yield Fact("the common rate is not negative", common >= 0)
    yield from _inside(claim, gains, P)
    winds, rates = rationals(gains, "wind"), rationals(gains, "integral_rate")
    cells = entry(claim, "cells")
    if not isinstance(cells, list) or not len(cells) == len(winds) - 1 == len(rates):
        raise Refusal("cells: one for each interval of the law's winds is needed")
    share = rational(entry(claim, "box"), "wind_share")
    for k, cell in enumerate(cells):
        same = rationals(cell, "wind", 2) == winds[k : k + 2]
        if not same or rational(cell, "integral_rate") != rates[k]:
            raise Refusal(f"cell {k + 1}: wind or integral rate is not the law's")
        if rationals(cell, "effectiveness_limit", 2) != sorted(turbine.limit[k : k + 2]):
            raise Refusal(f"cell {k + 1}: effectiveness_limit is not the gains'")
        error = rational(cell, "wind_error")
        yield Fact(f"cell {k + 1}: wind error", 0 <= error <= share * winds[k])
        yield from _cell(cell, P, R, common, f"cell {k + 1}")
    for k, cell in enumerate(cells):
        yield from enclosed(turbine, cell, k)


def _inside(claim: Any, gains: Any, P: fmpq_mat) -> Obligations:
    peaks, box = entry(claim, "peaks"), entry(claim, "box")
    for name, h in WIDTHS.items():
        peak = rational(peaks, name)
        owner, key = (gains, "integral_limit") if name == "integral" else (box, name)
        yield Fact(f"peak of {name}", 0 < peak <= rational(owner, key))
        row = fmpq_mat([h])
        yield Definite(f"width of {name}", scaled(peak**2, P) - transposed(row) * row)


def _cell(cell: Any, P: fmpq_mat, R: fmpq_mat, common: fmpq, label: str) -> Obligations:
    ends = [sorted(set(rationals(cell, name, 2))) for name in RANGES]
    if any(len(pair) == 2 and pair[0] > pair[1] for pair in ends):
        raise Refusal(f"{label}: a range that does not increase")
    residual, wind_gain, kappa, turning, reference = (rational(cell, name) for name in SIZES)
    z, nu = rational(cell, "lag_disturbance"), rational(cell, "integral_rate")
    alpha, rho = rational(cell, "multiplier"), rational(cell, "decay_rate")
    error, moving = rational(cell, "wind_error"), rational(cell, "wind_rate")
    sizes = (residual, wind_gain, kappa, turning, reference, z, rho, moving)
    stated = [number for pair in ends for number in pair] + [nu, alpha, rho, common]
    if any((number * DECIMALS).q != 1 for number in stated):
        raise Refusal(f"{label}: a number with more than seven decimals")
    yield Fact(f"{label}: signs", alpha > 0 and min(sizes) >= 0 and ends[1][0] > 0)
    w = kappa * (residual + wind_gain * error) + reference * moving
    offset = kappa * residual / ends[1][0]
    yield Fact(f"{label}: equilibrium", P[2, 2] * offset**2 < 1)
    for corner in product(*ends):
        A = _matrix(corner, nu)
        for which, matrix, rate in (("decay", P, rho), ("common decay", R, common)):
            left = _fallen(A, matrix, 2 * rate)
            yield Definite(f"{label}: {which}", left)
    slowest, fastest = ends[4][0] - turning * moving, ends[4][-1] + turning * moving
    for corner in product(*ends[:4], sorted({slowest, fastest})):
        base = _fallen(_matrix(corner, nu), P, alpha)
        for sign in (1, -1) if z else (1,):
            d = fmpq_mat([[w], [corner[3] * w + sign * z], [fmpq(0)]])
            edge = negative(P * d)
            whole = blocks([[base, edge], [transposed(edge), fmpq_mat([[alpha]])]])
            yield Definite(f"{label}: invariance", whole)


def _matrix(corner: tuple[fmpq, ...], nu: fmpq) -> fmpq_mat:
    a, G, S, f, T = corner
    return fmpq_mat([[a - G, S, G], [f * (a - G + nu), f * S - T, f * G], [-nu, 0, 0]])


def _fallen(A: fmpq_mat, P: fmpq_mat, rate: fmpq) -> fmpq_mat:
    PA = P * A
    return negative(PA + transposed(PA)) - scaled(rate, P)
