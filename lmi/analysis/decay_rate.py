"""The condition of one quadratic function, and its largest decay rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Try
from takagi.lmi.argument_checks import (
    Vertices,
    decay_parameter,
    number,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.evaluate import margin, rate_of_parameter
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import (
    Outcome,
    advice_about_limit,
    asks_for_decay,
    binding_items,
    promised,
)
from takagi.lmi.decision.rounds import CHUNK, first_vertices
from takagi.lmi.expressions.expression import Expression, He, Parameter, matrix
from takagi.lmi.parameter_search.largest_parameter import extreme_parameter
from takagi.models.arrays import Floats


def common_lyapunov_condition(
    model: Vertices,
    *,
    decay_rate: float | Fraction = 0.0,
    weight: float | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose A_i' P + P A_i + 2 alpha P < 0 at every vertex, with 0 < P <= I.

    V = x' P x then decays as V' <= -2 alpha V along xdot = sum_i h_i A_i x for every h, however
    fast it varies.  P <= I only fixes the scale.  alpha is the parameter ``alpha``; in discrete
    time, A_i' P A_i - rho^2 P < 0, it is ``contraction``, rho^2 = e^(-2 alpha T).

    Parameters
    ----------
    model : a model (its A), (N, n, n) or (n, n); entries may be Fractions.
    decay_rate : alpha in 1/s; 0 asks for stability only.
    weight : margin of the vertex inequalities for a margin 1 of P; None takes their own size,
        max_i 2 |A_i|, so that the margin has no unit; see ``vertex_weight`` for discrete time.
    sample_time : T in s of x+ = A x, where the model cannot say; None takes the model's own,
        continuous time where it has none.

    Raises
    ------
    ModelError : shapes, no vertices, entries that are not finite, a sample time that is not
        positive or not the model's.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1, quadratic stability; Tanaka
    and Wang (2001), theorem 2, for discrete time.
    """
    A = vertex_stack(model)
    step = sample_time_of(model, sample_time)
    rate = decay_parameter(number("decay_rate", decay_rate), step)
    n = A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    decay = change_of(P, matrix(A, "A_{i}"), rate, step) << 0
    weight = vertex_weight(A, step=step) if weight is None else weight
    return pose(
        positive_definite(P),
        scale_bound(P),
        decay.named("vertex", rf"i = 1, \dots, {len(A)}", weight=weight),
        name="common quadratic Lyapunov function",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1"
        if step is None
        else "Tanaka and Wang (2001), theorem 2",
    )


def change_of(
    P: Unknown, A: Expression, rate: Parameter | Expression, step: float | None
) -> Expression:
    """Return He(P A) + 2 alpha P, or A' P A - rho^2 P in discrete time."""
    return He(P @ A) + 2 * rate * P if step is None else A.T @ P @ A - rate * P


def answer_in_states(
    condition: Condition,
    outcome: Outcome,
    A: Floats,
    s: Floats,
    *,
    step: float | None = None,
    diagnose: Callable[[Condition, Outcome], str] | None = None,
) -> Answer:
    """Return the outcome with P in the model's own states, its smallest eigenvalue made 1.

    ``A`` : vertices in these states; the condition is posed in x / s.
    ``diagnose`` : why there is no P; None for the words of one quadratic function.
    """
    P, rate = None, None
    if outcome.status == "candidate":
        scaled = outcome.values["P"][0]
        scaled = scaled / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(scaled)[0])))
        P = scaled / s / s[:, None]
        rate = rate_of(A * s / s[:, None], scaled, step=step)
    diagnosis = "" if P is not None else (diagnose or _diagnosis)(condition, outcome)
    return replace(outcome.as_answer(condition, s), P=P, decay_rate=rate, diagnosis=diagnosis)


def rate_of(A: Floats, P: Floats, *, step: float | None = None) -> float:
    """Return the largest alpha that P shows at every vertex, in 1/s.

    A_i' P + P A_i + 2 alpha P <= 0, or A_i' P A_i <= e^(-2 alpha T) P where a step T is given.
    """
    return float(rates_of(A, P, step=step).min())


def rates_of(A: Floats, P: Floats, *, step: float | None = None) -> Floats:
    """Return (N,), one rate a vertex: -1/2 lambda_max(He(F_i)), F_i = L' A_i L'^-1, P = L L'.

    In discrete time -ln(sigma_max(F_i)) / T; inf for a vertex that is zero.
    """
    R = np.linalg.cholesky(P).T
    rates = []
    for k in range(0, len(A), CHUNK):
        inside = np.linalg.solve(R.T, (R @ A[k : k + CHUNK]).transpose(0, 2, 1))
        if step is None:
            symmetric = inside + inside.transpose(0, 2, 1)
            rates.append(-np.linalg.eigvalsh(symmetric)[:, -1] / 2)
        else:
            with np.errstate(divide="ignore"):
                rates.append(-np.log(np.linalg.norm(inside, 2, axis=(1, 2))) / step)
    return np.concatenate(rates)


def vertex_weight(A: Array, *, step: float | None = None) -> float:
    """Return max_i 2 |A_i| (spectral norm), the natural size of the vertex inequalities.

    In discrete time that of A_i' P A_i - P, max_i 2 |A_i - I| + |A_i - I|^2, but no more than 1,
    which the margin of rho^2 P - A_i' P A_i cannot exceed.
    """
    largest = float(np.linalg.norm(motion(A, step).astype(np.float64), 2, axis=(1, 2)).max())
    if step is not None:
        return capped(largest)
    return 2.0 * largest if largest > 0 else 1.0


def capped(change: float) -> float:
    return min(1.0, 2.0 * change + change**2) if change > 0 else 1.0


def _diagnosis(condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    slower = "lower the decay rate, " if asks_for_decay(condition) else ""
    return (
        f"no common P: {binding_items(condition, outcome.multipliers, 'vertex')}; {slower}"
        "shrink the box that these vertices span, or use a Lyapunov function that depends "
        "on the memberships"
    )


ROUNDS, ADDED = 40, 12
# The search starts again in coordinates where the last P is the identity: so many times, each time
# with so many steps. This is needed because P becomes singular near a rate that is not attained.
ATTEMPTS, STEPS = 12, 6
# The search ends when the upper bound is at most this many tolerances above the rate.  The bound
# is computed up to two tolerances above the rate, so this must be more than 2.
ENOUGH = 4.0
# Reciprocal condition number of P, in balanced states, below which it is not used.
WORST = 1e-8


def max_decay_rate(
    model: Vertices,
    *,
    tolerance: float = 1e-6,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Answer:
    """Return the largest alpha, and its P, with A_i' P + P A_i + 2 alpha P <= 0 at every vertex.

    Discrete time: A_i' P A_i <= e^(-2 alpha T) P.  Found by ``extreme_parameter``: each step poses
    the condition at the rate that the last P shows and asks for the P that gains most on it, and
    the multipliers bound every rate from above.  It ends when the two meet.

    Parameters
    ----------
    model : a model (its A), or vertices (N, n, n).
    tolerance : relative to the rate, and to a thousandth of the size of the vertices [1/s] when
        the rate is nearer to 0.
    scales : (n,) engineering range of each state; None balances the vertices.
    sample_time : T in s of x+ = A x, where vertices are given; a model knows its own.

    Returns an ``Answer``: ``decay_rate`` is recomputed from the returned P, slightly below the
    largest; ``bound`` is above every rate, to solver accuracy, and by the tolerance at most, or by
    a thousandth where less was asked for.  The rate may be negative: then V grows at most that
    fast, and the status is still "candidate".

    The supremum may not be attained (a defective eigenvalue); then P is badly conditioned near it,
    and where the search stops short of the bound by more than that, the status is "unknown", the
    diagnosis has both rates, and ``feasible`` the P that shows the lower one.  In discrete time
    V+ < 1e-7 V within a step is not told from V+ = 0.

    Raises ModelError: shapes, no vertices, entries that are not finite, a sample time that is not
    positive or not the model's.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1.3.
    """
    answer = fast_decay(model, tolerance=tolerance, scales=scales, sample_time=sample_time)
    if answer.decay_rate is None:
        return answer
    A = vertex_stack(model).astype(np.float64)
    step = sample_time_of(model, sample_time)
    s = state_units(A, scales, step=step)
    size = vertex_weight(A * s / s[:, None], step=step) / (step or 1.0)
    rate, bound = answer.decay_rate, answer.bound
    largest_known = abs(bound) if np.isfinite(bound) else 0.0
    if bound <= rate + promised(tolerance) * max(largest_known, 1e-3 * size):
        return answer
    upper_bound = (
        f"no P shows more than {bound:.6g} 1/s" if np.isfinite(bound) else "no bound is known"
    )
    return replace(
        answer,
        status="unknown",
        P=None,
        decay_rate=None,
        feasible=answer.values,
        diagnosis=(
            f"the largest rate is not settled: a P shows {rate:.6g} 1/s, {upper_bound}; ask for a "
            "rate between them, with common_lyapunov, or for a larger tolerance"
        ),
    )


def fast_decay(
    model: Vertices,
    *,
    tolerance: float = 1e-6,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Answer:
    """Return the P that shows the fastest decay that was found, whether or not it is the largest.

    As ``max_decay_rate``, for callers that only need a P with fast decay: the upper bound may be
    far above the rate.
    """
    A = vertex_stack(model).astype(np.float64)
    step = sample_time_of(model, sample_time)
    tolerance = float(number("tolerance", tolerance, at_least=1e-12))
    s = state_units(A, scales, step=step)
    scaled = A * s / s[:, None]
    size = vertex_weight(scaled, step=step) / (step or 1.0)
    search = _Search(scaled, step, tolerance, size)
    chosen, P = first_vertices(search.A), np.eye(A.shape[1])
    tries: list[Try] = []
    for _ in range(ROUNDS):
        P, upper = search.ascend(search.A[chosen], P, tries)
        rates = rates_of(search.A, P, step=step)
        order = np.argsort(rates)
        fresh = order[~np.isin(order, chosen)][:ADDED]
        lowest = float(rates[chosen].min())
        if not len(fresh) or rates[fresh[0]] >= lowest - search.hair(lowest):
            break
        chosen = np.concatenate([chosen, fresh])
    upper = max(rate_of(search.A, P, step=step), min(upper, search.slowest_mode()))
    condition, outcome = search.centre(search.A[chosen], P)
    answer = answer_in_states(condition, outcome, A, s, step=step)
    return replace(answer, bound=upper, tries=(*tries, *outcome.tries))


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """Vertices in balanced states, the sample time, the tolerance, and the vertices' size [1/s]."""

    A: Floats
    step: float | None
    tolerance: float
    size: float

    def hair(self, rate: float) -> float:
        """Return the absolute tolerance of the rate."""
        # A rate of zero has no size of its own; a thousandth of the loop's speed replaces it.
        return self.tolerance * max(abs(rate) if np.isfinite(rate) else 0.0, 1e-3 * self.size)

    def slowest_mode(self) -> float:
        """Return the rate of the slowest mode of any vertex, which no P exceeds.

        It is increased by the possible rounding error of the eigenvalue; a defective eigenvalue has
        the largest one.
        """
        n = self.A.shape[1]
        values = np.linalg.eigvals(self.A)
        off = np.finfo(float).eps ** (1.0 / n) * np.linalg.norm(self.A, 2, axis=(1, 2))
        if self.step is None:
            return float((off - values.real.max(axis=1)).min())
        moduli = np.maximum(np.abs(values).max(axis=1) - off, 0.0)
        with np.errstate(divide="ignore"):
            return float((-np.log(moduli) / self.step).min())

    def ascend(self, A: Floats, P: Floats, tries: list[Try]) -> tuple[Floats, float]:
        """Return the P that shows the largest rate of these vertices, and a bound on that rate."""
        upper, rate = np.inf, rate_of(A, P, step=self.step)
        for _ in range(ATTEMPTS):
            better, bound = self._attempt(A, P, tries)
            upper = min(upper, bound)
            # Near a supremum that is not attained P is almost singular, and shows no rate any more.
            usable = np.linalg.eigvalsh(better)[0] > WORST
            gained = rate_of(A, better, step=self.step) - rate if usable else -np.inf
            if gained > 0:
                P, rate = better, rate + gained
            if not gained > self.hair(rate) or upper - rate <= ENOUGH * self.hair(rate):
                break
        return P, max(upper, rate)

    def _attempt(self, A: Floats, P: Floats, tries: list[Try]) -> tuple[Floats, float]:
        R = np.linalg.cholesky(P).T
        inside = np.linalg.solve(R.T, (R @ A).transpose(0, 2, 1)).transpose(0, 2, 1)
        extreme = extreme_parameter(
            common_lyapunov_condition(inside, sample_time=self.step),
            "alpha" if self.step is None else "contraction",
            largest=self.step is None,
            start={"P": np.eye(len(R))[None]},
            step=self._difference,
            limit=None if self.step is None else 0.0,
            steps=STEPS,
            worst=min(0.5, WORST / float(np.linalg.eigvalsh(P)[0] / np.linalg.eigvalsh(P)[-1])),
            centre=False,
        )
        tries.extend(extreme.outcome.tries)
        better = R.T @ extreme.best["P"][0] @ R
        better = np.asarray((better + better.T) / (2 * np.linalg.norm(better)))
        return better, rate_of_parameter(extreme.bound, self.step)

    def _difference(self, value: float) -> float:
        """Return the absolute tolerance of the parameter."""
        rate_tolerance = self.hair(rate_of_parameter(value, self.step))
        return (
            rate_tolerance
            if self.step is None
            else float(value * np.expm1(2 * self.step * rate_tolerance))
        )

    def centre(self, chosen: Floats, P: Floats) -> tuple[Condition, Outcome]:
        """Return the best conditioned P just below the rate, checked at all vertices."""
        rate = rate_of(self.A, P, step=self.step)
        aim = rate - self.hair(rate) if np.isfinite(rate) else 0.0
        condition = common_lyapunov_condition(chosen, decay_rate=aim, sample_time=self.step)
        # One attempt: where it fails so near the largest rate, P itself is at hand.
        outcome = decide(condition, most=1)
        if outcome.status != "candidate" or not (
            rate_of(self.A, outcome.values["P"][0], step=self.step) >= aim
        ):
            P = P / np.linalg.eigvalsh(P)[-1]
            checked_margin = margin(condition, {"P": P[None]})
            outcome = replace(
                outcome, status="candidate", values={"P": P[None]}, margin=checked_margin
            )
        return condition, outcome
