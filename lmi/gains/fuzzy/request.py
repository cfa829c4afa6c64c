"""The LMIs of gains with a Lyapunov function that depends on the memberships."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.gains.decay.condition import size_of_motion, theta_weight
from takagi.lmi.gains.fuzzy.limits import effort_lmi, scale_lmis
from takagi.lmi.gains.fuzzy.sums import SoughtGains, continuous_sums, discrete_sums
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.fuzzy_condition import rate_slack, slack_unknown
from takagi.lmi.varying.parameter_motion import continuous_motion, kept_degrees
from takagi.lmi.varying.parameter_space import Space
from takagi.models.arrays import Floats

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
    bounded : dP/dt by one slack matrix X, in the place of the corners of the velocities.
    """

    A: Array
    B: Array
    space: Space
    rates: tuple[Floats, ...]
    sample_time: float | None
    relaxation: str
    slack: SlackKind
    bounded: bool

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
        more: tuple[Unknown, ...] = ()
        lmis: tuple[LMI, ...] = scale_lmis(sought)
        sums: tuple[DoubleSum, ...]
        if self.discrete:
            sums = discrete_sums(sought)
        elif self.bounded:
            X = slack_unknown(sought.P.rows)
            sums = continuous_sums(sought, (), eps, self.kappa, (X, self.rates[0]))
            more, lmis = (X,), (*lmis, *rate_slack(sought.P, X))
        else:
            motion = continuous_motion(self.space, self._degrees(), self.rates)
            sums = continuous_sums(sought, motion.velocities, eps, self.kappa)
        for one in sums:
            slack, found = relaxation_named(self.relaxation)(one)
            more, lmis = (*more, *slack), (*lmis, *found)
        return Condition(
            name=f"fuzzy Lyapunov function and gains, {self.relaxation}",
            unknowns=(sought.P, sought.G, sought.M, nu, *more),
            lmis=(*lmis, effort_lmi(sought, nu, discrete=self.discrete)),
            objective={"nu": np.ones((1, 1, 1))},
            parameters=rate_parameter(alpha, self.sample_time),
            source="de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004)"
            if self.discrete
            else "Mozelli, Palhares and Avellar (2009)",
        )

    def _degrees(self) -> tuple[int, ...]:
        ones = tuple(int(size > 1) for size in self.space.sizes)
        return ones if self.discrete else kept_degrees(ones, self.rates, discrete=False)

    def _members(self) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Return (r,): rules that differ in what may jump only share a member of P."""
        seen = self.space.corners * np.array(self._degrees(), dtype=np.intp)
        _, members = np.unique(seen, axis=0, return_inverse=True)
        return np.asarray(members.ravel(), dtype=np.intp)
