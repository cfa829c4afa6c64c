"""Gains together with a Lyapunov matrix for each rule, as double sums: u = -M(h) G^-1 x.

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

from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Try, WithAnswer
from takagi.lmi.argument_checks import (
    check_stabilisable,
    decay_parameter,
    fixed_mode,
    input_stack,
    number,
    positive_number,
    sample_time_of,
    too_slow,
    vertex_stack,
)
from takagi.lmi.condition.evaluate import rate_of_values
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import balanced_inputs, nearest_power, state_units
from takagi.lmi.cone.cone_program import assemble
from takagi.lmi.decision.decide import decide, improve
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, asks_for_decay, binding_items
from takagi.lmi.expressions.expression import Expression, He, Inequality, Parameter, block, matrix
from takagi.lmi.gains.decay.condition import Controlled, size_of_motion, theta_weight
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.sums.membership_shape import double_sums, rate_of, rule_table
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_motion import continuous_motion, kept_degrees
from takagi.lmi.varying.parameter_space import RateBounds, Space, membership_rates, space_of
from takagi.models.arrays import Floats, Indices, ShortRepr
from takagi.models.errors import ModelError

LARGEST_SLACK = 16.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FuzzyRequest:
    """What is asked for, in one set of coordinates.

    A, B : (r, n, n), (r, n, m).
    space : of the memberships.
    rates : bounds of |dw/dt| in 1/s, one array for each simplex; ignored in discrete time.
    sample_time : T in s; None for continuous time.
    relaxation : name of the double-sum relaxation.
    s, tau : (n,), (m,) of the coordinates, x = s xhat, u = tau uhat: powers of two.
    """

    A: Floats
    B: Floats
    space: Space
    rates: tuple[Floats, ...]
    sample_time: float | None
    relaxation: str
    s: Floats
    tau: Floats

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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class FuzzyDesign(ShortRepr, WithAnswer):
    """u = -sum_i h_i K_i x and V = x' P(h) x.

    Attributes
    ----------
    gains : (r, m, n), K_i = M_i G^-1; None unless found.
    matrices : (r, n, n): P_i of P(h) = sum_i h_i P_i; in discrete time S_i of P(h) = S(h)^-1.
    discrete : whether time is.
    decay_rate : alpha in 1/s that was asked for and holds; the answer's own is what was found.
    margin : as in ``Answer``.
    relaxation : name of the double-sum relaxation.
    answer : how it was found; its condition is in balanced states and inputs.
    """

    gains: Floats | None = None
    matrices: Floats | None = None
    discrete: bool
    decay_rate: float
    margin: float
    relaxation: str
    answer: Answer


# Bound on the effort nu: the largest margin exists only if every unknown is bounded.
LARGEST_EFFORT = 1e6
# More solvers than there are.
MANY = 99


def _searched(task: FuzzyRequest, alpha: float) -> FuzzyDesign:
    """Return the first design that has gains, with the least effort at half its margin."""
    fixed = fixed_mode(task.A, task.B, alpha, step=task.sample_time)
    if fixed is not None:
        outcome = Outcome("infeasible", {}, -np.inf, 0.0, {}, ())
        none = _design(task, task.condition(alpha), outcome, alpha)
        why = too_slow(task.A, fixed[:2], alpha, task.sample_time)
        return replace(none, answer=replace(none.answer, diagnosis=why))
    tries: tuple[Try, ...] = ()
    epsilons = (1.0,) if task.discrete else EPSILONS
    # Many solvers for one epsilon only: the last, or the first that a single one left open.
    undecided: list[float] = []
    # The list is read when all epsilons have been tried.
    again = ((epsilon, MANY) for epsilon in islice(undecided, 1))
    for epsilon, most in chain(((epsilon, 1) for epsilon in epsilons), again):
        condition = task.condition(alpha, epsilon)
        data = assemble(condition)
        outcome = decide(condition, rows={"nu": LARGEST_EFFORT}, assembled=data, most=most)
        tries = (*tries, *outcome.tries)
        outcome = replace(outcome, tries=tries)
        if outcome.status == "candidate":
            less = improve(condition, outcome, assembled=data)
            return _design(task, condition, less, alpha)
        if outcome.status == "unknown":
            undecided.append(epsilon)
    return _design(task, condition, outcome, alpha)


def _design(
    task: FuzzyRequest, condition: Condition, outcome: Outcome, alpha: float
) -> FuzzyDesign:
    good = outcome.status == "candidate"
    answer = replace(
        outcome.as_answer(condition, task.s),
        decay_rate=rate_of_values(condition, outcome.values, task.sample_time) if good else None,
        diagnosis="" if good else _diagnosis(task, condition, outcome),
    )
    plain = FuzzyDesign(
        discrete=task.discrete,
        decay_rate=alpha,
        margin=outcome.margin,
        relaxation=task.relaxation,
        answer=answer,
    )
    if not good:
        return plain
    s, r = task.s, len(task.A)
    G, M = outcome.values["G"], outcome.values["M"]
    lyapunov_members = outcome.values[task.P.name][task.members]
    slacks = np.broadcast_to(G * s[:, None], (r, *G.shape[1:])).copy()
    numerators = np.broadcast_to(M * task.tau[:, None], (r, *M.shape[1:])).copy()
    K = np.linalg.solve(slacks.transpose(0, 2, 1), numerators.transpose(0, 2, 1))
    gains = np.asarray(K.transpose(0, 2, 1), dtype=np.float64)
    if task.discrete:
        matrices = lyapunov_members * s * s[:, None]
    else:
        back = np.linalg.inv(slacks)
        matrices = back.transpose(0, 2, 1) @ lyapunov_members @ back
        matrices = (matrices + matrices.transpose(0, 2, 1)) / 2
    return replace(plain, gains=gains, matrices=matrices)


def _diagnosis(task: FuzzyRequest, condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    names = [lmi.name for lmi in condition.lmis if lmi.strict][1:]
    advice = ['take a richer relaxation ("liu-zhang", "polya-2")']
    advice += ["lower the decay rate"] if asks_for_decay(condition) else []
    if not task.discrete:
        advice.insert(0, "lower the rate bounds")
    binding = binding_items(condition, outcome.multipliers, *names)
    return (
        f"no gains by {task.relaxation} with one P a rule: {binding}; {', or '.join(advice)}, or "
        "shrink the box that the rules span"
    )


# Powers of four, so that their roots are powers of two: the middle of what helps, then outward.
EPSILONS = tuple(4.0**k for k in (-2, -1, -3, 0, -4, 1, -5, 2, -6, -8))


def fuzzy_pdc_condition(
    model: Controlled,
    *,
    rate_bounds: RateBounds | None = None,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    epsilon: float = 1.0,
    sample_time: float | None = None,
) -> Condition:
    """Pose the double sums of the module, 0 < P_i <= I, and the input effort nu.

    Parameters
    ----------
    model, rate_bounds, decay_rate, relaxation, sample_time : as for ``fuzzy_pdc``.
    epsilon : the scalar of continuous time, relative to the time of the vertices.

    Returns the condition in the model's coordinates as they are, with the unknowns ``P`` (``S`` in
    discrete time), ``G``, ``M``, ``nu`` and those of the relaxation.  Nothing is solved.

    Raises ModelError: as ``fuzzy_pdc``.

    Source: de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004); Mozelli,
    Palhares and Avellar (2009).
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    step = sample_time_of(model, sample_time)
    task = _task(model, A, B, step, rate_bounds, relaxation)
    return task.condition(
        float(number("decay_rate", decay_rate)), positive_number("epsilon", epsilon)
    )


def fuzzy_pdc(
    model: Controlled,
    *,
    rate_bounds: RateBounds | None = None,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> FuzzyDesign:
    """Return gains K_i for u = -sum_i h_i K_i x with V' <= -2 alpha V, V = x' P(h) x.

    In discrete time V(x+) <= e^(-2 alpha T) V(x) for whatever memberships come next.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    rate_bounds : in continuous time, how fast the memberships may move, as for
        ``fuzzy_lyapunov``; in discrete time left out.
    decay_rate : alpha in 1/s that must hold.
    relaxation : as for ``pdc``.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x + B u; a model knows its own.

    Returns a ``FuzzyDesign``; without gains its answer says which rules bind and what to relax.
    Nothing is proved here.

    Not promised: that the closed loop keeps the memberships to their rates; in continuous time
    that a no for the scalars epsilon that are tried is one for those between them.

    Raises ModelError: shapes, numbers, an unknown relaxation, inputs that are dependent or do
    nothing, a vertex with an unstable mode that no input moves, rate bounds missing or not used.

    Source: de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004); Mozelli,
    Palhares and Avellar (2009).
    """
    alpha = float(number("decay_rate", decay_rate))
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    step = sample_time_of(model, sample_time)
    s = state_units(A, scales, step=step)
    size = size_of_motion(A * s / s[:, None], 0.0, step) / 2
    tau = balanced_inputs(B / s[:, None], size)
    task = _task(model, A, B, step, rate_bounds, relaxation)
    task = replace(task, A=A * s / s[:, None], B=B * tau / s[:, None], s=s, tau=tau)
    names = tuple(getattr(model, "states", ()))
    check_stabilisable(task.A, task.B, units=s, names=names, step=step)
    return _searched(task, alpha)


def _task(
    model: Controlled,
    A: Floats,
    B: Floats,
    step: float | None,
    rate_bounds: RateBounds | None,
    relaxation: str,
) -> FuzzyRequest:
    relaxation_named(relaxation)
    if step is not None and rate_bounds is not None:
        raise ModelError(
            "rate_bounds are for continuous time; in discrete time the next memberships are "
            "arbitrary: leave them out"
        )
    if step is None and rate_bounds is None:
        raise ModelError(
            "rate_bounds is missing; give how fast the memberships may move (inf: at any rate)"
        )
    space = space_of(model, len(A))
    bounds = membership_rates(space, np.inf if rate_bounds is None else rate_bounds)
    return FuzzyRequest(
        A=A,
        B=B,
        space=space,
        rates=bounds,
        sample_time=step,
        relaxation=relaxation,
        s=np.ones(A.shape[1]),
        tau=np.ones(B.shape[2]),
    )
