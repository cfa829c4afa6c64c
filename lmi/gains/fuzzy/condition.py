"""The LMIs of gains with a fuzzy Lyapunov function, and what keeps their unknowns finite.

Gains together with a Lyapunov matrix for each rule, as double sums: u = -M(h) G^-1 x.

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
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.gains.decay.condition import size_of_motion, theta_weight
from takagi.lmi.gains.requirements.closed_loop import gain_member, gain_symbol, gain_unknown
from takagi.lmi.sums.double_sum import DoubleSum, Member, SumPart
from takagi.lmi.sums.membership_shape import double_sums, rate_parts, rule_table
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_motion import continuous_motion, kept_degrees
from takagi.lmi.varying.parameter_space import Space
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


LARGEST_SLACK = 16.0


def effort_lmi(sought: SoughtGains, nu: Unknown, *, discrete: bool) -> LMI:
    """Pose [[P_i, M_j'], [M_j, nu I]] >= 0: |u|^2 <= nu V; G_j + G_j' - S_i in discrete time."""
    r, n, m = sought.rules, sought.P.rows, sought.M.rows
    i, j = (index.ravel() for index in np.indices((r, r)))
    eye = np.eye(n)[None]
    rule_members = sought.members[i]
    gains = j if sought.M.count > 1 else np.zeros_like(j)
    slacks = j if sought.G.count > 1 else np.zeros_like(j)
    first: tuple[Term, ...] = (
        Term(
            unknown=sought.P,
            left=eye,
            right=eye,
            members=rule_members,
            symbol=f"{sought.P.symbol}_i",
        ),
    )
    if discrete:
        first = (
            Term(
                unknown=sought.P,
                left=-eye,
                right=eye,
                members=rule_members,
                latex=("-", ""),
                symbol=f"{sought.P.symbol}_i",
            ),
            Term(
                unknown=sought.G,
                left=eye,
                right=eye,
                members=slacks,
                plus_transpose=True,
                symbol=sought.slack_symbol,
            ),
        )
    inputs = np.eye(m)[None]
    return LMI(
        name="input effort",
        blocks=(n, m),
        terms=(
            *first,
            Term(
                unknown=sought.M,
                left=inputs,
                right=eye,
                at=(1, 0),
                members=gains,
                symbol=gain_symbol(sought.M),
            ),
            Term(unknown=nu, left=inputs, at=(1, 1), latex=("", "I")),
        ),
        count=r * r,
        strict=False,
        index=rf"i, j = 1, \dots, {r}",
    )


def scale_lmis(sought: SoughtGains) -> tuple[LMI, ...]:
    """Pose 0 < P_i <= I, and |G| <= 16, which only keeps the slack finite."""
    P, G = sought.P, sought.G
    eye = np.eye(P.rows)[None]
    every, slack_members = np.arange(P.count), np.arange(G.count)
    member_term = Term(unknown=P, left=eye, right=eye, members=every, symbol=f"{P.symbol}_i")
    bound = Constant(value=LARGEST_SLACK * eye, latex=f"{LARGEST_SLACK:g} I")
    return (
        LMI(
            name=f"{P.symbol} positive definite",
            blocks=(P.rows,),
            terms=(member_term,),
            count=P.count,
            index=rf"i = 1, \dots, {P.count}",
        ),
        LMI(
            name=f"scale of {P.symbol}",
            blocks=(P.rows,),
            terms=(member_term,),
            constants=(Constant(value=-eye, latex="-I"),),
            sign=-1,
            count=P.count,
            strict=False,
            index=rf"i = 1, \dots, {P.count}",
        ),
        LMI(
            name="scale of G",
            blocks=(P.rows, P.rows),
            terms=(Term(unknown=G, left=eye, right=eye, at=(0, 1), members=slack_members),),
            constants=(bound, replace(bound, at=(1, 1))),
            count=G.count,
            strict=False,
        ),
    )


SlackKind: TypeAlias = Literal["common", "rules"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FuzzyRequest:
    """What is asked for, in one set of coordinates.

    Attributes
    ----------
    A, B : (r, n, n), (r, n, m).
    space : of the memberships.
    rates : bounds of |dw/dt| in 1/s, one array for each simplex; ignored in discrete time.
    sample_time : T in s; None for continuous time.
    relaxation : name of the double-sum relaxation.
    slack : G the same in all rules, or one a rule.
    """

    A: Array
    B: Array
    space: Space
    rates: tuple[Floats, ...]
    sample_time: float | None
    relaxation: str
    slack: SlackKind

    @property
    def discrete(self) -> bool:
        return self.sample_time is not None

    @property
    def kappa(self) -> float:
        """Return a power of two about the size of A: what time is measured by."""
        return float(nearest_power(np.array([size_of_motion(self.A, 0.0, None) / 2]))[0])

    def sought(self, alpha: float) -> SoughtGains:
        """Return the unknowns; P has a member for each rule, or for each that may differ."""
        r, n, m = self.B.shape
        members = self._members()
        G = Unknown("G", n, n, count=r if self.slack == "rules" else 1)
        name = "S" if self.discrete else "P"
        return SoughtGains(
            A=self.A,
            B=self.B,
            P=Unknown(name, n, n, symmetric=True, count=int(members.max()) + 1),
            G=G,
            M=gain_unknown(r, m, n, self.relaxation),
            members=members,
            corners=self.space.corners,
            products=bool(self.space.premises),
            weight=theta_weight(self.A, alpha, self.sample_time),
        )

    def condition(self, alpha: float, eps: float = 1.0) -> Condition:
        """Return the condition; eps is the scalar of continuous time."""
        sought = self.sought(alpha)
        nu = Unknown("nu", 1, 1, latex=r"\nu")
        slack_unknowns: tuple[Unknown, ...] = ()
        lmis: tuple[LMI, ...] = scale_lmis(sought)
        sums: tuple[DoubleSum, ...]
        if self.discrete:
            sums = discrete_sums(sought)
        else:
            motion = continuous_motion(self.space, self._degrees(), self.rates)
            sums = continuous_sums(sought, motion.velocities, eps, self.kappa)
        for double_sum in sums:
            slack, relaxed_lmis = relaxation_named(self.relaxation)(double_sum)
            slack_unknowns, lmis = (*slack_unknowns, *slack), (*lmis, *relaxed_lmis)
        return Condition(
            name=f"fuzzy Lyapunov function and gains, {self.relaxation}",
            unknowns=(sought.P, sought.G, sought.M, nu, *slack_unknowns),
            lmis=(*lmis, effort_lmi(sought, nu, discrete=self.discrete)),
            objective={"nu": np.ones((1, 1, 1))},
            parameters=rate_parameter(alpha, self.sample_time),
            source="de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004)"
            if self.discrete
            else "Mozelli, Palhares and Avellar (2009)",
        )

    def _degrees(self) -> tuple[int, ...]:
        linear_degrees = tuple(int(size > 1) for size in self.space.sizes)
        return (
            linear_degrees
            if self.discrete
            else kept_degrees(linear_degrees, self.rates, discrete=False)
        )

    def _members(self) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Return (r,): rules that differ in what may jump only share a member of P."""
        varying_corners = self.space.corners * np.array(self._degrees(), dtype=np.intp)
        _, members = np.unique(varying_corners, axis=0, return_inverse=True)
        return np.asarray(members.ravel(), dtype=np.intp)
