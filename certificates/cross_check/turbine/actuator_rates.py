r"""``actuator-rates``: bounds of the rates of pitch and torque while xi'P xi <= 1.

b beta' = T zeta + theta mu v_s' N     so  |beta'| <= zeta_max / (b tau) + theta rho |N / b|
U' = q*' v_s' + gamma' v_s' s + gamma s',   s = e - x,   s' = h xi + w_e,
     h = (a - G + nu, S, G),   |h xi| <= B  where  B^2 P - h'h > 0
T_g = T_rated - E (psi(-U) + held(f v_s', g))

|T_g'| <= E (F(-U) |U'| + |f| |v_s''|) inside a cell.  At a node of the law's winds f and g step,
and T_g steps with them.  If the claim names a claim on the wind's rate, that claim's rates bound
|v_s''| = |w' - v_s'| / tau_f.
"""

from __future__ import annotations

from itertools import pairwise, product
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import scaled, transposed
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
    table,
)
from takagi.certificates.cross_check.turbine.effort_ramp import ramp_slope
from takagi.certificates.cross_check.turbine.moving_schedule import asked_slope
from takagi.certificates.cross_check.turbine.numbers import TurbineNumbers, WindCell
from takagi.certificates.cross_check.turbine.wind_rate import loop_rested_on, rested_on, turns

ZERO = fmpq(0)


def actuator_rates(claim: Any, document: Any) -> Obligations:
    """Yield the inequalities of the module's text, cell by cell."""
    loop, _ = loop_rested_on(claim, document)
    turbine = TurbineNumbers(loop, entry(document, "model"), entry(document, "gains"))
    P, peaks = table(loop, "P", (3, 3)), entry(loop, "peaks")
    stated, cells = entry(claim, "cells"), entry(loop, "cells")
    if not isinstance(stated, list) or not len(stated) == len(cells) == len(turbine.wind) - 1:
        raise Refusal("cells: one for each cell of the loop is needed")
    for k, (rates, cell) in enumerate(zip(stated, cells, strict=True)):
        yield from _cell(rates, cell, turbine.cell(k), P, peaks, f"cell {k + 1}")
    if "wind_rate" in claim:
        rate, _ = rested_on(claim, document, "wind_rate", "wind-rate")
        yield Fact("one loop for both", entry(rate, "loop") == entry(claim, "loop"))
        lag = rational(entry(document, "gains"), "wind_filter")
        for k, rates in enumerate(stated):
            if turbine.ahead_limit[k] > 0:
                most = turns(rate, lag, *turbine.wind[k : k + 2])
                kept = most <= rational(rates, "schedule_bend")
                yield Fact(f"cell {k + 1}: rate of the wind's rate", kept)
    yield Fact("step of torque", turbine.per_effort * _step(turbine, cells) <= rational(
        claim, "torque_step"
    ))  # fmt: skip


def _cell(rates: Any, cell: Any, at: WindCell, P: fmpq_mat, peaks: Any, label: str) -> Obligations:
    turbine, rho = at.turbine, rational(cell, "wind_rate")
    owed, signal = rational(peaks, "effort_lag"), rational(peaks, "speed_signal")
    B, bend = rational(rates, "signal_rate"), rational(rates, "schedule_bend")
    yield Fact(f"{label}: signs", min(B, bend) >= 0)

    led = turbine.lead / turbine.drive * rho * (asked_slope(at) / at.b).size
    fastest = min(turbine.rate_limit, owed / at.b.low / turbine.drive + led)
    yield Fact(f"{label}: pitch", fastest <= rational(rates, "pitch_rate"))

    nu = rational(cell, "integral_rate")
    ends = (rationals(cell, name, 2) for name in ("stiffness", "loop_gain", "lag_gain"))
    for a, G, S in product(*ends):
        h = fmpq_mat([[a - G + nu, S, G]])
        yield Definite(f"{label}: signal", scaled(B**2, P) - transposed(h) * h)

    pushed = rational(cell, "residual") + rational(cell, "wind_gain") * rational(cell, "wind_error")
    pushed = rational(cell, "inertia_gain") * pushed + rational(cell, "reference_slope") * rho
    moved = abs(at.slope(turbine.effort)) + abs(at.slope(turbine.proportional)) * signal
    effort = at.gamma.high * (B + pushed) + rho * moved
    torque = ramp_slope(-at.efforts.low, turbine.overlap) * effort
    if turbine.ahead_limit[at.k] > 0:
        torque += abs(turbine.ahead[at.k]) * bend
    yield Fact(f"{label}: torque", turbine.per_effort * torque <= rational(rates, "torque_rate"))


def _step(turbine: TurbineNumbers, cells: Any) -> fmpq:
    """Return the largest step of the feed-forward at a node, over both cells' rates [rad/s^2]."""
    sides = [
        (f, g, rational(cell, "wind_rate"))
        for f, g, cell in zip(turbine.ahead, turbine.ahead_limit, cells, strict=True)
    ]
    found = [ZERO]
    # The difference of two limited lines is piecewise linear and odd in the rate: it is largest at
    # an end of the rates or where one of both reaches its limit.
    for one, two in pairwise(sides):
        reach = min(one[2], two[2])
        corners = [reach] + [g / abs(f) for f, g, _ in (one, two) if f != 0 and g < abs(f) * reach]
        found += [abs(_fed(one, s) - _fed(two, s)) for s in corners]
    return max(found)


def _fed(side: tuple[fmpq, fmpq, fmpq], rate: fmpq) -> fmpq:
    """Return f v_s' limited to [-g, g]."""
    f, g, _ = side
    return max(-g, min(g, f * rate))
