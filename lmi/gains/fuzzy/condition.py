"""The LMIs of gains with a fuzzy Lyapunov function, and what keeps their unknowns finite.

Gains together with a Lyapunov matrix for each rule, as double sums: u = -M(h) G^-1 x.

    discrete     [ rho^2 (S_i - G - G')   *    ]
                 [ A_i G - B_i M_j        -S_l ]        for every next rule l

    continuous   [ He(A_i G - B_i M_j) + dP/dt + 2 alpha P_i                  *               ]
                 [ c (P_i - G') + d (A_i G - B_i M_j)                         -kappa (G + G') ]

with c = kappa / sqrt(eps), d = sqrt(eps), each summed with h_i h_j and negative definite.

Discrete time: V = x' S(h)^-1 x.  With G' S^-1 G >= G + G' - S the first says that
(A G - B M)' S(h+)^-1 (A G - B M) < rho^2 G' S(h)^-1 G, which is V(x+) < rho^2 V(x).

Continuous time: V = x' N' P(h) N x, N = G^-1, and eps / kappa a time that is searched over.  With
z = N x on both sides of the first block row, and (sqrt(eps) / kappa) N x' on those of the second,
x' = (A - B M N) x, the slack vanishes and V' + 2 alpha V < 0 is left.

Small eps and P_i = G, or S_i = G, show whatever a common Lyapunov matrix shows.

Source: de Oliveira, Bernussou and Geromel (1999), Systems and Control Letters 37, and Guerra and
Vermeiren (2004), Automatica 40(5), for discrete time; Mozelli, Palhares and Avellar (2009),
Information Sciences 179, for continuous time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.argument_checks import decay_parameter
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.expressions.expression import Expression, He, Inequality, Parameter, block, matrix
from takagi.lmi.gains.decay.condition import size_of_motion, theta_weight
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.sums.membership_shape import double_sums, rate_of, rule_table
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_motion import continuous_motion, kept_degrees
from takagi.lmi.varying.parameter_space import Space
from takagi.models.arrays import Floats, Indices

LARGEST_SLACK = 16.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FuzzyRequest:
    """What is asked for, in one set of coordinates.

    A, B : (r, n, n), (r, n, m).
    space : of the memberships.
    rates : bounds of |dw/dt| in 1/s, one array for each simplex; ignored in discrete time.
    sample_time : T in s; None for continuous time.
    relaxation : name of the double-sum relaxation.
    """

    A: Array
    B: Array
    space: Space
    rates: tuple[Floats, ...]
    sample_time: float | None
    relaxation: str

    @property
    def discrete(self) -> bool:
        return self.sample_time is not None

    @property
    def degrees(self) -> tuple[int, ...]:
        """Return the degree of P in each simplex; 0 where it may not depend on what jumps."""
        linear = tuple(int(size > 1) for size in self.space.sizes)
        return linear if self.discrete else kept_degrees(linear, self.rates, discrete=False)

    @property
    def members(self) -> Indices:
        """Return (r,): rules that differ in what may jump only share a member of P."""
        varying_corners = self.space.corners * np.array(self.degrees, dtype=np.intp)
        _, members = np.unique(varying_corners, axis=0, return_inverse=True)
        return np.asarray(members.ravel(), dtype=np.intp)

    @property
    def P(self) -> Unknown:
        """Return the Lyapunov matrices; S in discrete time."""
        n, count = self.A.shape[1], int(self.members.max()) + 1
        return Unknown("S" if self.discrete else "P", n, n, symmetric=True, count=count)

    @property
    def G(self) -> Unknown:
        """Return the slack."""
        return Unknown("G", *self.A.shape[1:])

    @property
    def M(self) -> Unknown:
        """Return the numerators of the gains."""
        r, n, m = self.B.shape
        return gain_unknown(r, m, n, self.relaxation)

    def condition(self, alpha: float, eps: float = 1.0) -> Condition:
        """Return the condition; eps is the scalar of continuous time."""
        nu = Unknown("nu", 1, 1, latex=r"\nu")
        rate = decay_parameter(alpha, self.sample_time)
        sums = double_sums(
            self.next_rules(rate) if self.discrete else self.at_rates(rate, eps),
            "next rule" if self.discrete else "rates",
            rules=len(self.A),
            weight=theta_weight(self.A, alpha, self.sample_time),
            corners=self.space.corners if self.space.premises else None,
        )
        relaxed = relaxation_named(self.relaxation)
        size = LARGEST_SLACK * np.eye(self.A.shape[1])
        return pose(
            positive_definite(self.P),
            scale_bound(self.P),
            # This only keeps the slack finite.
            (block([[size, self.G], [None, size]]) >= 0).named("scale of G"),
            *(lmi for double_sum in sums for lmi in relaxed(double_sum)[1]),
            self.effort_bound(nu),
            minimise=nu,
            unknowns=(self.P, self.G, self.M, nu),
            parameters=(rate,),
            name=f"fuzzy Lyapunov function and gains, {self.relaxation}",
            source="de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004)"
            if self.discrete
            else "Mozelli, Palhares and Avellar (2009)",
        )

    @property
    def P_i(self) -> Expression:
        """Return the vertex's P, or S."""
        table = rule_table(len(self.A), "vertex", self.members)
        return self.P.members(table, f"{self.P.symbol}_{{i}}")

    @property
    def closed(self) -> Expression:
        """Return A_i G - B_i M_j."""
        A_i, B_i = matrix(self.A, "A_{i}", over="i"), matrix(self.B, "B_{i}", over="i")
        return A_i @ self.G - B_i @ self.M.over("j")

    def next_rules(self, contraction: Parameter) -> list[Expression]:
        """Return the module's Theta_ij of discrete time, one for each next rule."""
        S, r = self.P, len(self.A)
        first = contraction * (self.P_i - He(self.G))
        following = [
            S.members(np.full((r, r), member), f"S_{{{number + 1}}}")
            for number, member in enumerate(self.members)
        ]
        return [block([[first, None], [self.closed, -S_l]]) for S_l in following]

    def at_rates(self, alpha: Parameter, eps: float) -> list[Expression]:
        """Return the module's Theta_ij of continuous time, one for each velocity."""
        # A power of two about the size of A: what time is measured by.
        size = float(nearest_power(size_of_motion(self.A, 0.0, None) / 2))
        c, d = matrix([[size / np.sqrt(eps)]], "c"), matrix([[float(np.sqrt(eps))]], "d")
        first = He(self.closed) + 2 * alpha * self.P_i
        across = c * self.P_i - (c * self.G).T + d * self.closed
        last = -He(matrix([[size]], r"\kappa") * self.G)
        velocities = continuous_motion(self.space, self.degrees, self.rates).velocities
        rates = (
            rate_of(self.P, self.space.corners, velocity, members=self.members)
            for velocity in velocities
        )
        return [block([[first + rate, None], [across, last]]) for rate in rates]

    def effort_bound(self, nu: Unknown) -> Inequality:
        """Pose [[P_i, M_j'], [M_j, nu I]] >= 0: |u|^2 <= nu V; He(G) - S_i in discrete time."""
        r, M = len(self.A), self.M
        i, j = (index.ravel() for index in np.indices((r, r)))
        M_j = M.members(j, f"{M.symbol}_{{j}}") if M.count > 1 else M.as_expression()
        P_i = self.P.members(self.members[i], f"{self.P.symbol}_i")
        first = -P_i + He(self.G) if self.discrete else P_i
        effort = block([[first, None], [M_j, nu * np.eye(M.rows)]]) >= 0
        return effort.named("input effort", rf"i, j = 1, \dots, {r}")
