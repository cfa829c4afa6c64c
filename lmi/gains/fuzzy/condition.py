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
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.argument_checks import decay_parameter
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.expressions.expression import Expression, He, Inequality, Parameter, block, matrix
from takagi.lmi.gains.decay.condition import size_of_motion, theta_weight
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.membership_shape import double_sums, rate_of, rule_table
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
    def P_i(self) -> Expression:
        """Return the vertex's P, or S."""
        table = rule_table(self.rules, "vertex", self.members)
        return self.P.members(table, f"{self.P.symbol}_{{i}}")

    @property
    def closed(self) -> Expression:
        """Return A_i G_j - B_i M_j."""
        A_i, B_i = matrix(self.A, "A_{i}", over="i"), matrix(self.B, "B_{i}", over="i")
        return A_i @ self.G.over("j") - B_i @ self.M.over("j")

    def sums_of(self, thetas: Sequence[Expression], name: str) -> tuple[DoubleSum, ...]:
        """Return the double sums of these Theta_ij."""
        corners = self.corners if self.products else None
        return double_sums(thetas, name, rules=self.rules, weight=self.weight, corners=corners)


def discrete_sums(sought: SoughtGains, contraction: Parameter) -> tuple[DoubleSum, ...]:
    """Return the module's double sums, one for each next rule."""
    P, r = sought.P, sought.rules
    first = contraction * (sought.P_i - He(sought.G.over("j")))
    following = [
        P.members(np.full((r, r), member), f"{P.symbol}_{{{number + 1}}}")
        for number, member in enumerate(sought.members)
    ]
    thetas = [block([[first, None], [sought.closed, -P_l]]) for P_l in following]
    return sought.sums_of(thetas, "next rule")


def continuous_sums(
    sought: SoughtGains,
    velocities: Sequence[Sequence[Floats]],
    alpha: Parameter,
    eps: float,
    kappa: float,
) -> tuple[DoubleSum, ...]:
    """Return the module's double sums, one for each velocity.

    Parameters
    ----------
    velocities : corners of dw^k/dt, each one array a simplex.
    """
    P, G = sought.P, sought.G
    c, d = matrix([[kappa / np.sqrt(eps)]], "c"), matrix([[float(np.sqrt(eps))]], "d")
    first = He(sought.closed) + 2 * alpha * sought.P_i
    across = c * sought.P_i - (c * G).T + d * sought.closed
    last = -He(matrix([[kappa]], r"\kappa") * G)
    rates = (
        rate_of(P, sought.corners, velocity, members=sought.members) for velocity in velocities
    )
    thetas = [block([[first + rate, None], [across, last]]) for rate in rates]
    return sought.sums_of(thetas, "rates")


LARGEST_SLACK = 16.0


def effort_bound(sought: SoughtGains, nu: Unknown, *, discrete: bool) -> Inequality:
    """Pose [[P_i, M_j'], [M_j, nu I]] >= 0: |u|^2 <= nu V; G_j + G_j' - S_i in discrete time."""
    P, G, M, r = sought.P, sought.G, sought.M, sought.rules
    i, j = (index.ravel() for index in np.indices((r, r)))

    def of_gain(X: Unknown) -> Expression:
        return X.members(j, f"{X.symbol}_{{j}}") if X.count > 1 else X.as_expression()

    P_i = P.members(sought.members[i], f"{P.symbol}_i")
    first = -P_i + He(of_gain(G)) if discrete else P_i
    effort = block([[first, None], [of_gain(M), nu * np.eye(M.rows)]]) >= 0
    return effort.named("input effort", rf"i, j = 1, \dots, {r}")


def scale_bounds(sought: SoughtGains) -> tuple[Inequality, ...]:
    """Pose 0 < P_i <= I, and |G| <= 16, which only keeps the slack finite."""
    size = LARGEST_SLACK * np.eye(sought.P.rows)
    return (
        positive_definite(sought.P),
        scale_bound(sought.P),
        (block([[size, sought.G], [None, size]]) >= 0).named("scale of G"),
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
        rate = decay_parameter(alpha, self.sample_time)
        if self.discrete:
            sums = discrete_sums(sought, rate)
        else:
            motion = continuous_motion(self.space, self._degrees(), self.rates)
            sums = continuous_sums(sought, motion.velocities, rate, eps, self.kappa)
        relaxed = relaxation_named(self.relaxation)
        return pose(
            *scale_bounds(sought),
            *(lmi for double_sum in sums for lmi in relaxed(double_sum)[1]),
            effort_bound(sought, nu, discrete=self.discrete),
            minimise=nu,
            unknowns=(sought.P, sought.G, sought.M, nu),
            parameters=(rate,),
            name=f"fuzzy Lyapunov function and gains, {self.relaxation}",
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
