r"""``coherent-loop``: the effort-sharing loop stays in a set at moving winds, and settles.

State (e, zeta, x): speed error, the effort by which pitch lags, the law's integral.  For schedule
winds v_s in a cell, |v - v_s| <= wind_error and |v_s'| <= wind_rate, the loop's matrix and
disturbance lie in the hull of the corners of

    A = [ a - G           S          G     ]      d = ( w,  f w + z, 0 )
        [ f (a - G + nu)  f S - T    f G   ]      w = kappa (r + g wind_error) + o wind_rate
        [ -nu             0          0     ]      (w and z each of both signs)

with T - (b'/b) v_s' in the place of T while v_s moves.  Its eleven coefficients are enclosed here
from the tables of the law and the plant's surface (``loop``, ``wind_cell``), and
compared with those the certificate states.  A cell also states its conditions: its winds, and the
limit of pitch effectiveness (``effectiveness_limit``, the frozen wake's).  Then,
exactly, at every corner

    -[[A'P + PA + alpha P, P d], [d'P, -alpha]] > 0    so  {V <= 1} is invariant, V = xi' P xi,
    -(A'P + PA + 2 rho P) > 0     so  V(xi - xi*) decays as exp(-2 rho t), v = v_s constant,
    -(A'R + RA + 2 r R) > 0       so  (xi - xi*)' R (xi - xi*) does with one rate r for all winds,

and P > h h' / peak^2 bounds each state on {V <= 1}, which must lie inside the enclosed box.

Invariance.  The first matrix is affine in (A, d), so it is positive on the hull.  From left and
right with (xi, 1) it says V' < -alpha (V - 1).  V is absolutely continuous, also where v_s passes a
node, because the tables are continuous.  A solution that starts in {V <= 1} would have to pass
V = 1 to leave it, where V' < 0 almost everywhere.  So it never leaves, and the assumption of the
box holds for all time.

Decay.  Let v = v_s be constant.  At an equilibrium x' = 0 makes e = 0, then zeta' = -T zeta = 0
makes zeta = 0, and speed leaves G x* + kappa r = 0.  The map x -> g(q* - gamma x) - n_g T_rated / J
(``loop``, 3) has a slope of at least G_min / kappa > 0 and the value r at 0, so it has at most one
zero, and |x*| <= kappa |r| / G_min; P_33 (kappa r_bar)^2 < G_min^2 says that this point has V < 1.
The secants between two points of the set lie in the same ranges as those from the trim, and the
residual cancels: eta = xi - xi* has eta' = A eta with coefficients in the same intervals.

v_s' is the rate that the law feeds forward, since its schedule wind is the output of its filter.

Not promised: anything outside {V <= 1}; pitch that starts below its lower limit; a wake with
states of its own (pitch effectiveness is a static map, the same at all times where decay is
claimed, equal to the surface in the trim); a torque that lags its command; sampling.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.reader import listed, member, number, read_matrix
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.corners import Corners, Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Settling, Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.turbine_claim import (
    DRIVES,
    PROGRAM,
    RIGID,
    TurbineClaim,
    profile,
    row_bound,
)
from takagi.certificates.checker.words.effort_sharing import loop_name, loop_sentence
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import range_within

IN_WIND_CLASS = (
    "start with V <= 1 and pitch at or above its lower limit",
    *DRIVES,
    *RIGID,
    *PROGRAM,
    "wind estimate from outside, within the stated wind limits",
)


@dataclass(frozen=True)
class EffortSharingLoop(TurbineClaim):
    """The loop stays in {V <= 1} and settles; see the module."""

    subject: Subject
    P: Matrix
    cells: list[Any]

    assumes: ClassVar[tuple[str, ...]] = IN_WIND_CLASS
    # ``state`` is words for the reader of the file.
    members: ClassVar[dict[str, Members | None]] = {
        **plain("state P"),
        "uncertainty": plain("inertia frozen_wake power_coefficient"),
        "box": plain("speed_error effort_lag speed_signal wind_share"),
        "peaks": plain("speed_error effort_lag speed_signal integral"),
        "settling": plain("P decay_rate"),
        "cells": plain(
            "wind effectiveness_limit stiffness loop_gain lag_gain share_gain lag_rate residual "
            "wind_gain inertia_gain effectiveness_slope reference_slope lag_disturbance "
            "integral_rate wind_error wind_rate multiplier decay_rate"
        ),
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim.

        Raises
        ------
        CertificateError : a part is missing or is not what it has to be.
        """
        subject = Subject.read(claim, data["model"], data.get("gains"), where)
        P = read_matrix(claim, "P", where, (3, 3))
        count = len(subject.law.wind) - 1
        cells = listed(claim, "cells", where, count, count)
        name = loop_name(subject.law, subject.uncertainty)
        return cls(claim, data, where, name, subject, P, cells)

    @cached_property
    def settling(self) -> Settling:
        """The quadratic function of the decay rate that all winds share."""
        return Settling.read(self.claim, self.where)

    def premises(self) -> Obligations:
        yield positive(self.P, "P is not symmetric positive definite")

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        box, law = self.subject.box, self.subject.law
        yield "", self._peak("speed_error", box.speed_error, (1, 0, 0))
        yield "", self._peak("effort_lag", box.effort_lag, (0, 1, 0))
        yield "", self._peak("speed_signal", box.speed_signal, (1, 0, -1))
        yield "", self._peak("integral", law.integral_limit, (0, 0, 1))
        failure = "the matrix of the common decay rate is not positive definite"
        yield "", iter((positive(self.settling.P, failure),))
        for k, cell in enumerate(self.cells):
            stated = Stated.read(cell, f"{self.where}.cells[{k}]")
            yield f"wind {range_within(law.wind[k], law.wind[k + 1])} m/s: ", self._cell(k, stated)

    def not_proved(self) -> str:
        return f"not proved, of {len(self.cells)} wind cells: "

    @property
    def peak(self) -> Fraction:
        """The bound of the speed error on the set [rad/s]."""
        where = self.where
        return number(member(self.claim, "peaks", where), "speed_error", f"{where}.peaks")

    def figures(self) -> Iterator[Figure | WindProfile]:
        plant, law, uncertainty = self.subject.plant, self.subject.law, self.subject.uncertainty
        yield Figure("common decay rate", "1/s", self.settling.decay_rate)
        yield profile("wind error", "m/s", self.cells, "wind_error")
        yield profile("wind rate", "m/s^2", self.cells, "wind_rate")
        yield profile("decay rate", "1/s", self.cells, "decay_rate")
        overspeed = (max(law.speed) + self.peak) / plant.rated_speed - 1
        yield Figure("overspeed", "-", overspeed, larger=False)
        low, high = uncertainty.inertia
        yield Figure("inertia, lower end", "of nominal", low, larger=False)
        yield Figure("inertia, upper end", "of nominal", high)
        yield Figure("frozen wake included", "", Fraction(uncertainty.frozen_wake))

    def sentence(self) -> str:
        subject, where = self.subject, self.where
        cells = [Stated.read(cell, where).sizes for cell in self.cells]
        return loop_sentence(
            subject.plant,
            subject.law,
            subject.uncertainty,
            cells,
            self.peak,
            self.settling.decay_rate,
        )

    def _peak(self, name: str, limit: Fraction, h: tuple[int, ...]) -> Obligations:
        """Yield that the stated peak bounds h xi on {V <= 1}, and lies inside the box."""
        peaks = member(self.claim, "peaks", self.where)
        peak = number(peaks, name, f"{self.where}.peaks")
        failure = f"the set is not inside its stated bound on {name}"
        yield positive(peak, failure)
        yield nonnegative(limit - peak, failure)
        yield positive(row_bound(self.P, Matrix([list(h)]), peak), failure)

    def _cell(self, k: int, stated: Stated) -> Obligations:
        law, sizes = self.subject.law, stated.sizes
        if stated.ranges["wind"] != law.wind[k : k + 2]:
            raise CertificateError(f"{stated.where}.wind: must be the law's interval {k}")
        if sizes["integral_rate"] != law.nu[k]:
            raise CertificateError(f"{stated.where}.integral_rate: differs from the law's")
        if stated.ranges["effectiveness_limit"] != sorted(law.limit[k : k + 2]):
            raise CertificateError(f"{stated.where}.effectiveness_limit: differs from the gains'")
        yield nonnegative(sizes["wind_rate"], "a negative wind rate")
        loop = Loop(self.subject, k, sizes["wind_rate"])
        yield from loop.enclosed(stated)
        yield from loop.limits()
        error, failure = sizes["wind_error"], "the wind limits are outside the enclosed ones"
        yield nonnegative(error, failure)
        yield nonnegative(self.subject.box.wind_share * law.wind[k] - error, failure)
        failure = "multiplier or decay rate has the wrong sign"
        yield positive(sizes["multiplier"], failure)
        yield nonnegative(sizes["decay_rate"], failure)
        corners = Corners(stated)
        yield from corners.obligations(self.P)
        yield from corners.settling(self.settling.P, self.settling.decay_rate)
