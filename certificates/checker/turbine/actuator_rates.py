r"""``actuator-rates``: how fast pitch and torque move on the set of a coherent loop's claim.

For V <= 1 and the wind class of the claim that ``loop`` names, in the symbols of
docs/coherent-loop.md, in each wind cell:

    |beta'|  <= min(rate limit, p_zeta / (b tau) + theta rho |N / b|)              (pitch_rate)
    |U'|     <= gamma (B + w) + rho (|q*'| + |gamma'| p_s)
    |T_g'|   <= E (F(-U_low) |U'| + |f| a)                                         (torque_rate)
                 while |v_s''| <= a                                                (schedule_bend)

A claim that names one of kind ``wind-rate`` (``wind_rate``), proved for the same loop, also says
that every wind of that claim keeps |v_s''| <= a: with phi and r of each of its ranges

    (max phi + max r) / tau_f <= a       in every cell whose torque is fed v_s'.

with (e - x)' = h xi + w_e, h = (a - Gamma + nu, S, Gamma), w the claim's bound of w_e, and B
(``signal_rate``) such that B^2 P > h'h at every corner.  Where v_s passes a node, torque may step
by

    E max_s |held(f_1 s, g_1) - held(f_2 s, g_2)|,  |s| <= min(rho_1, rho_2)       (torque_step)

as the feed-forward's f and g are constant between nodes.  Limits of torque only slow it down.

Not promised: the rate of the pitch *asked for*, which moves with v_s''; anything outside the set.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from takagi.certificates.checker.arithmetic.effort_ramp import share
from takagi.certificates.checker.kernel.definite import is_positive_definite
from takagi.certificates.checker.kernel.reader import matrix, member, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Found, Outcome, Verdict
from takagi.certificates.checker.turbine.coherent_inputs import Box, Law, Plant, Uncertainty
from takagi.certificates.checker.turbine.coherent_loop import Loop
from takagi.certificates.checker.turbine.coherent_residual import slope
from takagi.certificates.checker.turbine.earlier import earlier_claim, earlier_loop
from takagi.certificates.checker.turbine.wind_rate import Range

__all__ = ["CellRates", "cell_rates", "check_actuator_rates", "largest_bends", "torque_step"]


@dataclass(frozen=True)
class CellRates:
    """What one cell's numbers bound, but for B.

    Attributes
    ----------
    pitch : of |beta'| [rad/s].   corners : the rows h.
    gain : gamma, at most;  drift : rho (|q*'| + |gamma'| p_s) + gamma w, the rest of |U'|.
    torque_share : E F(-U_low);  fed : E |f|, 0 where the limit g is.
    """

    pitch: Fraction
    corners: list[tuple[Fraction, Fraction, Fraction]]
    gain: Fraction
    drift: Fraction
    torque_share: Fraction
    fed: Fraction

    def torque_rate(self, signal_rate: Fraction, bend: Fraction) -> Fraction:
        """Return the bound of |T_g'| for B and |v_s''| <= a."""
        return self.torque_share * (self.gain * signal_rate + self.drift) + self.fed * bend


def cell_rates(data: Any, loop: Any, where: str) -> list[CellRates]:
    """Return what the decimals of model, gains and the loop's claim bound, cell by cell."""
    plant, law = Plant.read(data["model"]), Law.read(data.get("gains"))
    box, uncertainty = Box.read(loop, where), Uncertainty.read(loop, where)
    peaks = member(loop, "peaks", where)
    lag, signal = (number(peaks, name, where) for name in ("effort_lag", "speed_signal"))
    found = []
    for k, cell in enumerate(member(loop, "cells", where)):
        rho, error = number(cell, "wind_rate", where), number(cell, "wind_error", where)
        at = Loop(plant, law, box, uncertainty, k, rho)
        led = at.moving.lead * rho * at.moving.turn
        w = number(cell, "residual", where) + number(cell, "wind_gain", where) * error
        w = number(cell, "inertia_gain", where) * w + number(cell, "reference_slope", where) * rho
        gain, fed = max(law.gamma[k : k + 2]), law.inertia_limit[k] > 0
        moved = abs(slope(law.effort, law.wind, k)) + abs(slope(law.gamma, law.wind, k)) * signal
        found.append(
            CellRates(
                min(plant.rate_limit, lag / (at.moving.least_b * plant.lag) + led),
                _rows(cell, law.nu[k], where),
                gain,
                rho * moved + gain * w,
                law.effort_torque * share(-at.low, law.overlap),
                law.effort_torque * abs(law.inertia[k]) * fed,
            )
        )
    return found


def _rows(cell: Any, nu: Fraction, where: str) -> list[tuple[Fraction, Fraction, Fraction]]:
    ends = [numbers(cell, name, where, 2) for name in ("stiffness", "loop_gain", "lag_gain")]
    return [(a - G + nu, S, G) for a, G, S in product(*ends)]


def torque_step(law: Law, rates: list[Fraction]) -> Fraction:
    """Return the largest step of torque at a node, for the cells' wind rates."""
    largest = Fraction(0)
    ahead = list(zip(law.inertia, law.inertia_limit, rates, strict=True))
    for (f1, g1, rho1), (f2, g2, rho2) in pairwise(ahead):
        reach = min(rho1, rho2)
        # Lines between the rates at which one of them meets its limit; odd, so s >= 0 is enough.
        bends = [reach, *(g / abs(f) for f, g in ((f1, g1), (f2, g2)) if f)]
        for s in bends:
            at = min(s, reach)
            largest = max(largest, abs(_held(f1 * at, g1) - _held(f2 * at, g2)))
    return law.effort_torque * largest


def _held(value: Fraction, limit: Fraction) -> Fraction:
    return min(max(value, -limit), limit)


def largest_bends(wind_rate: Any, data: Any, where: str) -> list[Fraction]:
    """Return for each cell the largest |v_s''| [m/s^3] that a claim ``wind-rate`` leaves."""
    law = Law.read(data.get("gains"))
    filter_ = number(data["gains"], "wind_filter", "gains")
    ranges = [
        Range.read(one, f"{where}.ranges[{i}]")
        for i, one in enumerate(member(wind_rate, "ranges", where))
    ]
    return [max(one.bend(low, high, filter_) for one in ranges) for low, high in pairwise(law.wind)]


def check_actuator_rates(claim: Any, data: Any, found: list[Outcome], where: str) -> Found:
    """Return the verdict on one claim; ``found`` are the verdicts on the claims before it.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    loop, unproved = earlier_loop(claim, data, found, where)
    if unproved:
        return Found(Verdict.UNDECIDED, "actuator_rates", {"unproved": unproved})
    place = f"claims[{claim['loop']}]"
    bounds, law = cell_rates(data, loop, place), Law.read(data.get("gains"))
    cells = member(claim, "cells", where)
    if not isinstance(cells, list) or len(cells) != len(bounds):
        raise CertificateError(f"{where}.cells: one per wind cell of the loop is needed")
    P = matrix(loop, "P", place)
    step = number(claim, "torque_step", where)
    failures = []
    for k, (cell, bound) in enumerate(zip(cells, bounds, strict=True)):
        if reason := _failure(cell, bound, P, f"{where}.cells[{k}]"):
            failures.append((law.wind[k : k + 2], reason))
    rates = [number(cell, "wind_rate", place) for cell in loop["cells"]]
    if torque_step(law, rates) > step:
        why = "torque may step by more than is stated where v_s passes a node"
        failures.append(([], why))
    fed, kept = [bound.fed > 0 for bound in bounds], None
    if "wind_rate" in claim:
        rate, unproved = earlier_claim(
            claim, data, found, where, name="wind_rate", kind="wind-rate"
        )
        if unproved:
            return Found(Verdict.UNDECIDED, "actuator_rates", {"unproved": unproved})
        if rate["loop"] != claim["loop"]:
            raise CertificateError(f"{where}.wind_rate: it is about another loop")
        bends = largest_bends(rate, data, f"claims[{claim['wind_rate']}]")
        for k, (cell, bend) in enumerate(zip(cells, bends, strict=True)):
            if fed[k] and bend > number(cell, "schedule_bend", where):
                why = "the schedule wind's rate may change faster than is stated"
                failures.append((law.wind[k : k + 2], why))
        kept = max((bend for bend, is_fed in zip(bends, fed, strict=True) if is_fed), default=None)
    if failures:
        return Found(Verdict.UNDECIDED, "actuator_rates", {"failures": failures})
    proved = {"cells": cells, "fed": fed, "data": data, "law": law, "step": step, "where": where}
    proved["kept"] = kept
    return Found(Verdict.PROVED, "actuator_rates", proved)


def _failure(cell: Any, bound: CellRates, P: list[list[Fraction]], where: str) -> str:
    """Return what is not proved about one cell, or nothing."""
    names = ("pitch_rate", "signal_rate", "schedule_bend", "torque_rate")
    pitch, B, bend, torque = (number(cell, name, where) for name in names)
    if min(pitch, B, bend) < 0:
        return "a negative bound"
    if bound.pitch > pitch:
        return "pitch may move faster than is stated"
    for h in bound.corners:
        inside = [[B**2 * P[i][j] - h[i] * h[j] for j in range(3)] for i in range(3)]
        if not is_positive_definite(inside):
            return "the speed signal may move faster than is stated"
    if bound.torque_rate(B, bend) > torque:
        return "the torque asked for may move faster than is stated"
    return ""
