"""The LMIs of gains with a Lyapunov function that depends on the memberships."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.gains.decay.condition import size_of_motion, theta_weight
from takagi.lmi.gains.fuzzy.sums import SoughtGains, continuous_sums, discrete_sums
from takagi.lmi.gains.requirements.closed_loop import gain_symbol, gain_unknown
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_motion import continuous_motion, kept_degrees
from takagi.lmi.varying.parameter_space import Space
from takagi.models.arrays import Floats

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
