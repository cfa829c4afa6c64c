r"""The energy gain over a family of systems, by a Lyapunov function polynomial in its parameter.

With V = x' P(h) x, for each coefficient in h and, where h moves, each corner of its rates,

    continuous   [ He(P A) + dP/dt   P B        C'       ]
                 [ .                 -gamma I   D'       ]  < 0
                 [ .                 .          -gamma I ]

    discrete     [ P(h)   0         C'        A' P(h+) ]
                 [ .      gamma I   D'        B' P(h+) ]
                 [ .      .         gamma I   0        ]  > 0
                 [ .      .         .         P(h+)    ]

with A, B, C, D, P polynomials in h, P(h) > 0 and gamma least.

Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7), for polynomial P; Gahinet
and Apkarian (1994), Int. J. Robust and Nonlinear Control 4, for the bounded real lemma.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.analysis.disturbance.channel import (
    ChannelUnits,
    DisturbanceChannel,
    disturbance_channel,
)
from takagi.lmi.analysis.gain_pairs import gain_stack
from takagi.lmi.answer import Answer, ObjectiveUnit
from takagi.lmi.argument_checks import (
    Vertices,
    decay_parameter,
    input_stack,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.evaluate import lmi_value
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import optimise
from takagi.lmi.decision.outcome import Outcome, not_least
from takagi.lmi.expressions.expression import He, Inequality, block
from takagi.lmi.polynomials import Degrees, Known
from takagi.lmi.varying.parameter_condition import (
    Motion,
    SoughtPolynomial,
    decrease_lmi,
    polynomial_lmis,
)
from takagi.lmi.varying.parameter_motion import kept_degrees
from takagi.lmi.varying.parameter_space import (
    RateBounds,
    Space,
    VaryingLoop,
    decided_lyapunov,
    degrees_of,
    lyapunov_in_states,
    membership_rates,
    no_lyapunov,
    polya_of,
    space_of,
)
from takagi.models.arrays import Floats

SOURCE = "Oliveira and Peres (2007); Gahinet and Apkarian (1994)"


def robust_hinf_norm(
    model: Vertices,
    gains: ArrayLike | None,
    channel: tuple[Floats, Floats, Floats, Floats],
    *,
    degree: int | Sequence[int] = 1,
    polya: int = 0,
    rate_bounds: RateBounds = 0.0,
) -> Answer:
    """Return the least gamma, and its P(h), with |y|_2 <= gamma |w|_2 for every h that is allowed.

    For constant h an upper bound on the largest H-infinity norm of the family; it comes closer to
    that as degree and polya grow.

    model : A (r, n, n), B (r, n, m) where there are gains, sample time and premises.
    gains : K (r, m, n) of u = -sum_j h_j K_j x; None for the model as it is.
    channel : (E, C, D, F), (r, ., .) each: w enters by E, and y = C x + D u + F w.
    degree : of P in the memberships, or in each premise's; 0 is a common P.
    polya : how far the LMIs' degrees are raised before their coefficients are taken.
    rate_bounds : how fast h may move, as for ``fuzzy_lyapunov``; 0 is not at all.

    An ``Answer``: ``lyapunov_function`` is P(h), ``gain`` the least gamma that it shows at every
    coefficient, recomputed from it, in units of y over units of w.

    Raises ModelError: shapes, entries that are not finite, no disturbance or no output, numbers.
    """
    E, C, D, F = channel
    A = vertex_stack(model).astype(np.float64)
    path = disturbance_channel(A, E, C, F, sample_time=sample_time_of(model))
    feedback = None
    if gains is not None:
        B = input_stack(model, A).astype(np.float64)
        feedback = B, gain_stack(gains, len(B), B.shape[2], B.shape[1]), D
    space = space_of(model, len(A))
    task = _Path(path, space, membership_rates(space, rate_bounds), feedback)
    return _least(task, degrees_of(space, degree), polya_of(polya))


def _least(path: _Path, degrees: Degrees, polya: int) -> Answer:
    """Return the least gain that P(h) of these degrees shows."""
    at_rules = path.at_rules
    s = state_units(at_rules.A, None, step=at_rules.sample_time)
    units = ChannelUnits.of(at_rules, s)
    task = path.scaled(units)
    condition = task.condition(degrees, polya)
    why = task.loop.hopeless(0.0)
    if why:
        return no_lyapunov(condition, s, why)
    # Where the same P(h) shows no stability there is nothing to minimise.
    stable = task.stability(degrees, polya, s)
    if not stable.found:
        return stable
    outcome = optimise(condition)
    if outcome.status != "candidate":
        return _unsettled(stable, condition, outcome, s, units)
    basis = task.sought(degrees, polya).basis
    size = units.output * units.disturbance / units.rate
    return replace(
        outcome.as_answer(condition, s),
        lyapunov_function=lyapunov_in_states(outcome, task.loop, s, basis, size),
        gain=_shown(condition, outcome) * units.output / units.disturbance,
        objective_unit=ObjectiveUnit("gain", units.output / units.disturbance),
        tries=(*stable.tries, *outcome.tries),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """A path from disturbance to output, its memberships, and the bounds of their rates.

    With u = -K(h) x, which enters by B and is seen by D, feedback is B, K and D: (r, n, m),
    (r, m, n), (r, p, m).
    """

    path: DisturbanceChannel
    space: Space
    rates: tuple[Floats, ...]
    feedback: tuple[Floats, Floats, Floats] | None = None

    @property
    def loop(self) -> VaryingLoop:
        B, K = (None, None) if self.feedback is None else self.feedback[:2]
        return VaryingLoop(self.path.A, B, K, self.space, self.path.sample_time)

    @property
    def at_rules(self) -> DisturbanceChannel:
        """Return the closed loop's path at the rules."""
        if self.feedback is None:
            return self.path
        _, K, D = self.feedback
        return replace(self.path, A=self.loop.corners, C=self.path.C - D @ K)

    @property
    def output(self) -> Known:
        """Return C(h) of the closed loop, transposed."""
        C = self.space.known(self.path.C)
        if self.feedback is not None:
            _, K, D = self.feedback
            C = C - self.space.known(D) @ self.space.known(K)
        return Known(C.basis, C.values.transpose(0, 2, 1))

    def scaled(self, units: ChannelUnits) -> _Path:
        """Return the path in units of order one."""
        feedback, s = self.feedback, units.states
        if feedback is not None:
            B, K, D = feedback
            feedback = B / s[:, None] / units.rate, K * s, D / units.output
        rates = tuple(rate / units.rate for rate in self.rates)
        return _Path(self.path.scaled(units), self.space, rates, feedback)

    def sought(self, degrees: Degrees, polya: int) -> SoughtPolynomial:
        loop = self.loop
        varying_degrees = kept_degrees(degrees, self.rates, discrete=loop.sample_time is not None)
        weight = vertex_weight(loop.corners, step=loop.sample_time)
        return SoughtPolynomial.of(loop, varying_degrees, self.rates, polya=polya, weight=weight)

    def condition(self, degrees: Degrees, polya: int) -> Condition:
        sought = self.sought(degrees, polya)
        gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
        return pose(
            *polynomial_lmis(sought, bounded=False),
            _bounded_real(sought, gamma, self),
            minimise=gamma,
            name=f"energy gain, polynomial Lyapunov function of degree {sought.basis.degrees}",
            source=SOURCE,
        )

    def stability(self, degrees: Degrees, polya: int, s: Floats) -> Answer:
        """Return whether P(h) of this degree shows stability at all, in states x / s."""
        sought = self.sought(degrees, polya)
        rate = decay_parameter(0.0, self.path.sample_time)
        condition = pose(
            *polynomial_lmis(sought),
            decrease_lmi(sought, rate),
            name="stability by the same P(h)",
            source=SOURCE,
        )
        advice = "raise the degree or polya, lower the rate bounds, or shrink the box"
        return decided_lyapunov(condition, self.loop, s, sought.basis, advice)

    def known(self, vertices: Floats, sought: SoughtPolynomial) -> Known:
        return sought.motion.known(self.space.known(vertices))


def _bounded_real(sought: SoughtPolynomial, gamma: Unknown, task: _Path) -> Inequality:
    path, A, B = task.path, sought.matrix, task.known(task.path.B, sought)
    at = sought.coefficients(sought.product(A), sought.product(B))
    motion = Motion(sought, at)
    C = at.known(sought.motion.known(task.output), r"C(h)^\top")
    D = at.known(task.known(path.D.transpose(0, 2, 1), sought), r"D(h)^\top")
    signals, outputs = gamma * np.eye(D.shape[0]), gamma * np.eye(D.shape[1])
    rows: list[list[object]]
    if sought.discrete:
        rows = [
            [motion.P, 0, C, motion.into_next(A, "A(h)")],
            [None, signals, D, motion.into_next(B, "B(h)")],
            [None, None, outputs, 0],
            [None, None, None, motion.P_next],
        ]
        return at.named(block(rows) >> 0, "bounded real")
    first = He(motion.into(A, "A(h)")) + motion.P_dot
    rows = [[first, motion.into(B, "B(h)"), C], [None, -signals, D], [None, None, -outputs]]
    return at.named(block(rows) << 0, "bounded real")


def _shown(condition: Condition, outcome: Outcome) -> float:
    """Return the least gamma that the found P allows in every item, by a Schur complement.

    With gamma = 0 the LMI is [[X, Y], [Y', Z]] in its states and its signals; gamma adds gamma I
    to Z, so it is lambda_max(Y' X^-1 Y - Z).
    """
    lmi = condition.lmis[-1]
    values = {**outcome.values, "gamma": np.zeros((1, 1, 1))}
    F: Floats = lmi.sign * lmi_value(lmi, values, condition.parameters)
    n, signals = lmi.blocks[0], lmi.blocks[0] + lmi.blocks[1] + lmi.blocks[2]
    states = [k for k in range(lmi.size) if k < n or k >= signals]
    X, Y = F[:, states][:, :, states], F[:, states, n:signals]
    if np.linalg.eigvalsh(X).min() <= 0:
        return np.inf
    total = Y.transpose(0, 2, 1) @ np.linalg.solve(X, Y) - F[:, n:signals, n:signals]
    return float(np.linalg.eigvalsh((total + total.transpose(0, 2, 1)) / 2)[:, -1].max())


def _unsettled(
    stable: Answer, condition: Condition, outcome: Outcome, s: Floats, units: ChannelUnits
) -> Answer:
    unit = units.output / units.disturbance
    reason = not_least(outcome.objective * unit, outcome.lower_bound * unit)
    return replace(
        stable,
        status="unknown",
        lyapunov_function=None,
        decay_rate=None,
        margin=min(outcome.margin, 0.0),
        values={},
        multipliers={},
        bound=np.inf,
        coordinates=s,
        condition=condition,
        feasible=outcome.feasible,
        diagnosis=(f"there is such a P(h), so a bound exists, but {reason}; leave out fast states"),
        tries=(*stable.tries, *outcome.tries),
    )
