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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from typing import Any, ClassVar, Self

from takagi.certificates.checker.arithmetic.effort_ramp import share
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import listed, member, number, read_matrix
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.loop_claim import IN_WIND_CLASS
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import read_ranges
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.turbine_claim import (
    TurbineClaim,
    prerequisite_claim,
    row_bound,
)
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rates import beyond_words, fed_words
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly, range_around

NAME = "actuator rates of the effort-sharing loop"


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
        self.gain = at.over(law.gamma)[1]
        moved = abs(at.slope(law.effort)) + abs(at.slope(law.gamma)) * signal
        w = cell.drift + cell.sizes["reference_slope"] * at.rate
        self.drift = at.rate * moved + self.gain * w
        self.torque_share = law.effort_torque * share(-at.efforts[0], law.overlap)
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


@dataclass(frozen=True)
class ActuatorRates(TurbineClaim):
    """Bounds of the pitch and torque rates; see the module.

    ``loop``, ``wind_rate`` : the claims that this one names, the second one or None.
    """

    loop: Any
    wind_rate: Any
    unproved: str

    assumes: ClassVar[tuple[str, ...]] = IN_WIND_CLASS
    members: ClassVar[dict[str, Members | None]] = {
        **plain("loop wind_rate torque_step"),
        "cells": plain("pitch_rate signal_rate torque_rate schedule_bend"),
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim; ``earlier`` are the verdicts on the claims before it.

        Raises
        ------
        CertificateError : a part is missing or malformed.
        """
        loop, unproved = prerequisite_claim(claim, data, earlier, where, "loop", "coherent-loop")
        rate = None
        if not unproved and "wind_rate" in claim:
            rate, unproved = prerequisite_claim(
                claim, data, earlier, where, "wind_rate", "wind-rate"
            )
            if not unproved and rate["loop"] != claim["loop"]:
                raise CertificateError(f"{where}.wind_rate: it is about another loop")
        return cls(claim, data, where, NAME, loop, rate, unproved)

    @cached_property
    def subject(self) -> Subject:
        """Plant and law, as the loop's claim states them."""
        return Subject.read(self.loop, self.data["model"], self.data.get("gains"), self._place)

    @cached_property
    def bounds(self) -> list[CellRates]:
        """The bounds that each cell of the loop's claim gives."""
        return cell_rates(self.subject, self.loop, self._place)

    @property
    def cells(self) -> list[Any]:
        """The cells of the claim, one for each of the loop's."""
        return listed(self.claim, "cells", self.where, len(self.bounds), len(self.bounds))

    @cached_property
    def bends(self) -> dict[int, Fraction]:
        """The largest |v_s''| in the winds of the claim ``wind-rate``, by cell that is fed v_s'."""
        if self.wind_rate is None:
            return {}
        wind_filter = number(self.data["gains"], "wind_filter", "gains")
        place = f"claims[{self.claim['wind_rate']}]"
        bends = largest_bends(self.wind_rate, self.subject.law, wind_filter, place)
        return {k: bend for k, bend in enumerate(bends) if self.bounds[k].fed > 0}

    @property
    def _place(self) -> str:
        return f"claims[{self.claim['loop']}]"

    def premises(self) -> Obligations:
        if self.unproved:
            yield never(self.unproved)

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        wind, cells, where = self.subject.law.wind, self.cells, self.where
        P = read_matrix(self.loop, "P", self._place)
        for k, (cell, bound) in enumerate(zip(cells, self.bounds, strict=True)):
            required = _bounded(cell, bound, P, f"{where}.cells[{k}]")
            yield f"wind {range_around(*wind[k : k + 2])} m/s: ", required
        rates = [number(cell, "wind_rate", self._place) for cell in self.loop["cells"]]
        step = number(self.claim, "torque_step", where) - torque_step(self.subject.law, rates)
        failure = "torque may step by more than is stated where v_s passes a node"
        yield "", iter((nonnegative(step, failure),))
        failure = "the schedule wind's rate may change faster than is stated"
        for k, bend in self.bends.items():
            spare = number(cells[k], "schedule_bend", where) - bend
            place = f"wind {range_around(*wind[k : k + 2])} m/s: "
            yield place, iter((nonnegative(spare, failure),))

    def figures(self) -> Iterator[Figure | WindProfile]:
        step = number(self.claim, "torque_step", self.where)
        yield Figure("torque step", "N m", step, larger=False)
        for name, unit in (("pitch_rate", "rad/s"), ("torque_rate", "N m/s")):
            largest = max(number(cell, name, self.where) for cell in self.cells)
            yield Figure(f"largest {name.replace('_', ' ')}", unit, largest, larger=False)

    def sentence(self) -> str:
        where, data, cells = self.where, self.data, self.cells
        pitch, torque, bend = (
            [number(cell, name, where) for cell in cells]
            for name in ("pitch_rate", "torque_rate", "schedule_bend")
        )
        pitch_limit, torque_limit = (
            number(data["model"], f"{name}_rate_limit", "model") for name in ("pitch", "torque")
        )
        fed = [a for a, bound in zip(bend, self.bounds, strict=True) if bound.fed > 0]
        within = [rate <= torque_limit for rate in torque]
        # A limit is rounded down; a value stated to be below it is compared after rounding.
        limit = at_least(pitch_limit, 6)
        below = sum(rate < Fraction(limit) for rate in pitch)
        step = number(self.claim, "torque_step", where)
        return (
            "on the proved set and within its wind limits, under what the claim "
            "about these assumes, of "
            f"{len(cells)} wind cells: pitch moves at most "
            f"at {at_most(max(pitch), 6)} rad/s, and in {below} stays below the drive's limit of "
            f"{limit} rad/s; the torque asked for moves, between the law's wind nodes, at most at "
            f"{at_most(max(torque), 4)} N m/s{fed_words(fed, list(self.bends.values()))}, and in "
            f"{sum(within)} within the turbine's limit of {exactly(torque_limit)} N m/s"
            f"{beyond_words(within, self.subject.law.wind)}; it steps by "
            f"at most {at_most(step, 4)} N m where the schedule wind passes a node"
        )


def _bounded(cell: Any, bound: CellRates, P: Matrix, where: str) -> Obligations:
    """Yield that the stated rates of one cell are bounds."""
    names = ("pitch_rate", "signal_rate", "schedule_bend", "torque_rate")
    pitch, B, bend, torque = (number(cell, name, where) for name in names)
    yield nonnegative(min(pitch, B, bend), "a negative bound")
    yield nonnegative(pitch - bound.pitch, "pitch may move faster than is stated")
    for h in bound.corners:
        yield positive(
            row_bound(P, Matrix.of([h]), B), "the speed signal may move faster than is stated"
        )
    failure = "the torque asked for may move faster than is stated"
    yield nonnegative(torque - bound.torque_rate(B, bend), failure)
