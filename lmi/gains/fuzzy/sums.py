r"""Gains together with a Lyapunov matrix for each rule, as double sums: u = -M(h) G^-1 x.

    discrete     [ rho^2 (S_i - G_j - G_j')   *    ]
                 [ A_i G_j - B_i M_j          -S_l ]        for every next rule l

    continuous   [ He(A_i G - B_i M_j) + dP/dt + 2 alpha P_i                  *               ]
                 [ c (P_i - G') + d (A_i G - B_i M_j)                         -kappa (G + G') ]

with c = kappa / sqrt(eps), d = sqrt(eps), each summed with h_i h_j and negative definite.

Discrete time: V = x' S(h)^-1 x.  With G' S^-1 G >= G + G' - S the first says that
(A G - B M)' S(h+)^-1 (A G - B M) < rho^2 G' S(h)^-1 G, which is V(x+) < rho^2 V(x).  G may have a
member a rule; then u = -M(h) G(h)^-1 x.

Continuous time: V = x' N' P(h) N x, N = G^-1, and eps / kappa a time that is searched over.  With
z = N x on both sides of the first block row, and (sqrt(eps) / kappa) N x' on those of the second,
x' = (A - B M N) x, the slack vanishes and V' + 2 alpha V < 0 is left.

Small eps and P_i = G, or S_i = G, show whatever a common Lyapunov matrix shows.

Source: de Oliveira, Bernussou and Geromel (1999), Systems and Control Letters 37, and Guerra and
Vermeiren (2004), Automatica 40(5), for discrete time; Mozelli, Palhares and Avellar (2009),
Information Sciences 179, for continuous time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.requirements.closed_loop import gain_member, gain_symbol
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.membership_parts import double_sums, rate_parts, rule_table
from takagi.lmi.sums.summands import Member, SumPart
from takagi.models.arrays import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SoughtGains:
    """The unknowns, and the rules they are for.

    Attributes
    ----------
    A, B : (r, n, n), (r, n, m).
    P : the Lyapunov matrices; S in discrete time.
    G, M : slack, one or one a rule; M_j.
    members : (r,), the member of P for each rule.
    corners : (r, K), the corner of each simplex that rule i takes.
    products : the memberships are known to be products over these corners.
    weight : margin of a double sum for a margin 1 of P.
    """

    A: Array
    B: Array
    P: Unknown
    G: Unknown
    M: Unknown
    members: Indices
    corners: Indices
    products: bool
    weight: float

    @property
    def rules(self) -> int:
        return len(self.A)

    @property
    def slack(self) -> Member:
        """Return which member of G appears in Theta_ij."""
        return "first" if self.G.count == 1 else "gain"

    @property
    def slack_symbol(self) -> str:
        return self.G.symbol if self.G.count == 1 else f"{self.G.symbol}_{{j}}"

    def of_rule(self) -> Member:
        """Return which member of P appears in Theta_ij: that of the vertex."""
        return rule_table(self.rules, "vertex", self.members)

    def closed(
        self, at: tuple[int, int], factor: float, latex: str = ""
    ) -> tuple[SumPart, SumPart]:
        """Return factor (A_i G_j - B_i M_j)."""
        eye = np.eye(self.P.rows)[None]
        on_diagonal = at[0] == at[1]
        return (
            SumPart(
                unknown=self.G,
                left=factor * self.A,
                right=eye,
                at=at,
                member=self.slack,
                plus_transpose=on_diagonal,
                latex=(f"{latex}A_{{i}}", ""),
                symbol=self.slack_symbol,
            ),
            SumPart(
                unknown=self.M,
                left=-factor * self.B,
                right=eye,
                at=at,
                member=gain_member(self.M),
                plus_transpose=on_diagonal,
                latex=(f"-{latex}B_{{i}}", ""),
                symbol=gain_symbol(self.M),
            ),
        )

    def sum_of(self, parts: Sequence[SumPart], name: str = "") -> DoubleSum:
        """Return the double sum of two blocks with these parts."""
        n = self.P.rows
        return DoubleSum(
            rules=self.rules,
            blocks=(n, n),
            parts=tuple(parts),
            weight=self.weight,
            name=name,
            corners=self.corners if self.products else None,
        )


def discrete_sums(sought: SoughtGains) -> tuple[DoubleSum, ...]:
    """Return the module's double sums, one for each next rule; rho^2 is ``contraction``."""
    P, G, r = sought.P, sought.G, sought.rules
    eye = np.eye(P.rows)[None]
    common = (
        SumPart(
            unknown=P,
            left=eye,
            right=eye,
            member=sought.of_rule(),
            parameter="contraction",
            latex=(r"\rho^2", ""),
            symbol=f"{P.symbol}_{{i}}",
        ),
        SumPart(
            unknown=G,
            left=-eye,
            right=eye,
            member=sought.slack,
            plus_transpose=True,
            parameter="contraction",
            latex=(r"-\rho^2", ""),
            symbol=sought.slack_symbol,
        ),
        *sought.closed((1, 0), 1.0),
    )
    following = [
        SumPart(
            unknown=P,
            left=-eye,
            right=eye,
            at=(1, 1),
            member=np.full((r, r), member),
            latex=("-", ""),
            symbol=f"{P.symbol}_{{{number + 1}}}",
        )
        for number, member in enumerate(sought.members)
    ]
    return double_sums(
        sought.sum_of(common), [(next_part,) for next_part in following], "next rule"
    )


def continuous_sums(
    sought: SoughtGains,
    velocities: Sequence[Sequence[Floats]],
    eps: float,
    kappa: float,
) -> tuple[DoubleSum, ...]:
    """Return the module's double sums, one for each velocity; alpha is the parameter ``alpha``.

    Parameters
    ----------
    velocities : corners of dw^k/dt, each one array a simplex.
    """
    P, G = sought.P, sought.G
    eye = np.eye(P.rows)[None]
    rule_member, symbol = sought.of_rule(), f"{P.symbol}_{{i}}"
    across = kappa / np.sqrt(eps)
    parts = (
        *sought.closed((0, 0), 1.0),
        SumPart(
            unknown=P,
            left=2.0 * eye,
            right=eye,
            member=rule_member,
            parameter="alpha",
            latex=(r"2\alpha", ""),
            symbol=symbol,
        ),
        SumPart(
            unknown=P,
            left=across * eye,
            right=eye,
            at=(1, 0),
            member=rule_member,
            latex=("c", ""),
            symbol=symbol,
        ),
        SumPart(unknown=G, left=-across * eye, right=eye, at=(0, 1), latex=("-c", "")),
        *sought.closed((1, 0), float(np.sqrt(eps)), "d "),
        SumPart(
            unknown=G,
            left=-kappa * eye,
            right=eye,
            at=(1, 1),
            plus_transpose=True,
            latex=(r"-\kappa", ""),
        ),
    )
    plain = sought.sum_of(parts)
    rate_terms = [
        rate_parts(P, sought.corners, velocity, members=sought.members) for velocity in velocities
    ]
    return double_sums(plain, rate_terms)
