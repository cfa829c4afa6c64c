r"""``actuator-rates``: bounds of the pitch and torque rates on a ``coherent-loop`` claim's set.

For V <= 1 and the wind class of the claim that ``loop`` names, in the symbols of
docs/effort-sharing-loop.md, in each wind cell:

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

as the feed-forward's f and g are constant between nodes.  Torque limits can only reduce the rate.

Not promised: the rate of the pitch *asked for*, which moves with v_s''; anything outside the set.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from takagi.certificates.checker.arithmetic.effort_ramp import share
from takagi.certificates.checker.kernel.reader import listed, matrix, member, number
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Found, Outcome, Verdict
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated, bounds_row
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.prerequisite import prerequisite_claim
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import read_ranges


class CellRates:
    """The bounds from the numbers of one cell, without B.

    Attributes
    ----------
    pitch : of |beta'| [rad/s].   corners : the rows h.
    gain : gamma, at most;  drift : rho (|q*'| + |gamma'| p_s) + gamma w, the rest of |U'|.
    torque_share : E F(-U_low);  fed : E |f|, 0 where the limit g is.
    """

    def __init__(self, at: Loop, cell: Stated, lag: Fraction, signal: Fraction) -> None:
        """Take the set's peaks: ``lag`` of the effort lag of pitch, ``signal`` of e - x."""
        law, k = at.law, at.k
        self.pitch = min(at.plant.rate_limit, lag / (at.least_b * at.plant.lag) + at.led())
        ends = product(*(cell.ranges[name] for name in ("stiffness", "loop_gain", "lag_gain")))
        self.corners = [(a - G + law.nu[k], S, G) for a, G, S in ends]
        self.gain = at.ends(law.gamma)[1]
        moved = abs(at.slope(law.effort)) + abs(at.slope(law.gamma)) * signal
        w = cell.drift + cell.sizes["reference_slope"] * at.rate
        self.drift = at.rate * moved + self.gain * w
        self.torque_share = law.effort_torque * share(-at.low, law.overlap)
        self.fed = law.effort_torque * abs(law.inertia[k]) * (law.inertia_limit[k] > 0)

    def torque_rate(self, signal_rate: Fraction, bend: Fraction) -> Fraction:
        """Return the bound of |T_g'| for B and |v_s''| <= a."""
        return self.torque_share * (self.gain * signal_rate + self.drift) + self.fed * bend


def cell_rates(subject: Subject, loop: Any, where: str) -> list[CellRates]:
    """Return the bounds from the decimals of model, gains and the loop's claim, cell by cell."""
    peaks = member(loop, "peaks", where)
    lag, signal = (number(peaks, name, where) for name in ("effort_lag", "speed_signal"))
    cells = [Stated.read(cell, where) for cell in member(loop, "cells", where)]
    return [
        CellRates(Loop(subject, k, cell.sizes["wind_rate"]), cell, lag, signal)
        for k, cell in enumerate(cells)
    ]


def torque_step(law: Law, rates: list[Fraction]) -> Fraction:
    """Return the largest step of torque at a node, for the cells' wind rates."""
    steps = [Fraction(0)]
    ahead = list(zip(law.inertia, law.inertia_limit, rates, strict=True))
    for (f1, g1, rho1), (f2, g2, rho2) in pairwise(ahead):
        reach = min(rho1, rho2)
        # Piecewise linear in s with breaks where one term reaches its limit; odd, so s >= 0
        # suffices.
        bends = [reach, *(min(reach, g / abs(f)) for f, g in ((f1, g1), (f2, g2)) if f)]
        steps += [abs(_held(f1 * s, g1) - _held(f2 * s, g2)) for s in bends]
    return law.effort_torque * max(steps)


def _held(value: Fraction, limit: Fraction) -> Fraction:
    return min(max(value, -limit), limit)


def largest_bends(wind_rate: Any, law: Law, wind_filter: Fraction, where: str) -> list[Fraction]:
    """Return for each cell the largest |v_s''| [m/s^3] that a claim ``wind-rate`` allows."""
    ranges = read_ranges(wind_rate, where)
    return [max(one.bend(*ends, wind_filter) for one in ranges) for ends in pairwise(law.wind)]


def check_actuator_rates(claim: Any, data: Any, found: list[Outcome], where: str) -> Found:
    """Return the verdict on one claim; ``found`` are the verdicts on the claims before it.

    Raises
    ------
    CertificateError : a part is missing or malformed.
    """
    loop, unproved = prerequisite_claim(claim, data, found, where, "loop", "coherent-loop")
    if unproved:
        return Found(Verdict.UNDECIDED, "actuator_rates", {"unproved": unproved})
    place = f"claims[{claim['loop']}]"
    subject = Subject.read(loop, data["model"], data.get("gains"), place)
    bounds, law = cell_rates(subject, loop, place), subject.law
    cells = listed(claim, "cells", where, len(bounds), len(bounds))
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
    kept = None
    if "wind_rate" in claim:
        rate, unproved = prerequisite_claim(claim, data, found, where, "wind_rate", "wind-rate")
        if unproved:
            return Found(Verdict.UNDECIDED, "actuator_rates", {"unproved": unproved})
        if rate["loop"] != claim["loop"]:
            raise CertificateError(f"{where}.wind_rate: it is about another loop")
        filter_ = number(data["gains"], "wind_filter", "gains")
        bends = largest_bends(rate, law, filter_, f"claims[{claim['wind_rate']}]")
        fed = {k: bend for k, bend in enumerate(bends) if bounds[k].fed > 0}
        for k, bend in fed.items():
            if bend > number(cells[k], "schedule_bend", where):
                why = "the schedule wind's rate may change faster than is stated"
                failures.append((law.wind[k : k + 2], why))
        kept = max(fed.values(), default=None)
    if failures:
        return Found(Verdict.UNDECIDED, "actuator_rates", {"failures": failures})
    proved = {"cells": cells, "data": data, "law": law, "step": step, "where": where, "kept": kept}
    fed_cells = [bound.fed > 0 for bound in bounds]
    return Found(Verdict.PROVED, "actuator_rates", proved | {"fed": fed_cells})


def _failure(cell: Any, bound: CellRates, P: list[list[Fraction]], where: str) -> str:
    """Return the first property of one cell that is not proved, or nothing."""
    names = ("pitch_rate", "signal_rate", "schedule_bend", "torque_rate")
    pitch, B, bend, torque = (number(cell, name, where) for name in names)
    if min(pitch, B, bend) < 0:
        return "a negative bound"
    if bound.pitch > pitch:
        return "pitch may move faster than is stated"
    if not all(bounds_row(P, h, B) for h in bound.corners):
        return "the speed signal may move faster than is stated"
    if bound.torque_rate(B, bend) > torque:
        return "the torque asked for may move faster than is stated"
    return ""
