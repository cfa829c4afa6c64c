r"""LMIs for memberships that move within bounds on their rates; nothing here solves them.

dP/dt is posed at every corner of the velocities: of the premises, dw_k/dt = +-rho_k, or of the
memberships, |dh_i/dt| <= phi_i with sum_i dh_i/dt = 0.

Source: Tanaka, Hori and Wang (2003), IEEE Trans. Fuzzy Systems 11(4), for bounds on dh/dt; Geromel
and Colaneri (2006), Systems and Control Letters 55, for the corners.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.polynomials.simplex_polynomials import Degrees
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.membership_parts import double_sums, rate_parts, rule_table
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.sums.summands import SumPart
from takagi.lmi.varying.parameter_condition import (
    SOURCES,
    Form,
    SoughtPolynomial,
    check_form,
    form_lmis,
    polynomial_lmis,
)
from takagi.lmi.varying.parameter_space import VaryingLoop
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

RATE_SOURCES = "Tanaka, Hori and Wang (2003); Geromel and Colaneri (2006)"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Question:
    """Which P(h) is sought, for which motion of h.

    Attributes
    ----------
    degrees : of P in each simplex, 0 where h jumps in continuous time.
    rates : bounds of |dw/dt| in 1/s, one array a simplex.
    relaxation : "polya-<d>", or a named one.
    form : "direct" or "dilated".
    """

    degrees: Degrees
    rates: tuple[Floats, ...]
    relaxation: str
    form: Form

    @property
    def polya(self) -> int | None:
        """Return d of "polya-<d>", or None."""
        match = re.fullmatch(r"polya-(\d+)", self.relaxation)
        return int(match[1]) if match else None

    def check(self, loop: VaryingLoop) -> None:
        """Raise ModelError where what was asked does not go together."""
        check_form(self.form)
        relaxation_named(self.relaxation)
        plain = loop.sample_time is None and self.form == "direct"
        linear = max(self.degrees) <= 1
        if self.polya is None and not (plain and linear and loop.K is None):
            raise ModelError(
                f"relaxation {self.relaxation} is for a double sum: continuous time, no gains, "
                'form="direct", degree 1; take "polya-<d>"'
            )

    def condition(self, loop: VaryingLoop, alpha: float | Fraction) -> Condition:
        """Return the condition in the loop's states."""
        self.check(loop)
        sought = SoughtPolynomial.of(loop, self.degrees, self.rates, polya=self.polya or 0)
        unknowns: tuple[Unknown, ...]
        if self.polya is None and any(self.degrees):
            unknowns, lmis = _named(sought, loop, self.relaxation)
        else:
            unknowns, lmis = form_lmis(sought, self.form)
        source = SOURCES[self.form]
        if loop.sample_time is None and any(self.degrees):
            source = f"{source}; {RATE_SOURCES}"
        return Condition(
            name=f"fuzzy Lyapunov function, degree {self.degrees}, {self.relaxation}",
            unknowns=(sought.P, *unknowns),
            lmis=lmis,
            parameters=rate_parameter(alpha, loop.sample_time),
            source=source,
        )


def _named(
    sought: SoughtPolynomial, loop: VaryingLoop, relaxation: str
) -> tuple[tuple[Unknown, ...], tuple[LMI, ...]]:
    """Pose sum_ij h_i h_j (He(P_j A_i) + 2 alpha P_j + dP/dt) < 0 by a named relaxation."""
    A, corners = loop.A.astype(np.float64), loop.space.corners
    members = sought.basis.corners(corners)
    eye = np.eye(sought.P.rows)[None]
    gain = rule_table(len(A), "gain", members)
    plain = DoubleSum(
        rules=len(A),
        blocks=(sought.P.rows,),
        parts=(
            SumPart(
                unknown=sought.P,
                left=eye,
                right=A,
                member=gain,
                plus_transpose=True,
                latex=("", "A_{i}"),
                symbol="P_{j}",
            ),
            SumPart(
                unknown=sought.P,
                left=2.0 * eye,
                right=eye,
                member=gain,
                parameter="alpha",
                latex=(r"2\alpha", ""),
                symbol="P_{j}",
            ),
        ),
        weight=sought.weight,
        corners=corners if loop.space.premises else None,
    )
    rate_terms = [
        rate_parts(sought.P, corners, velocity, members=members)
        for velocity in sought.motion.velocities
    ]
    unknowns: list[Unknown] = []
    lmis = list(polynomial_lmis(sought))
    for loop_at_rate in double_sums(plain, rate_terms):
        slack, relaxed_lmis = relaxation_named(relaxation)(loop_at_rate)
        unknowns += slack
        lmis += relaxed_lmis
    return tuple(unknowns), tuple(lmis)
