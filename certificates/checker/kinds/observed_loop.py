r"""``observed-loop``: plant and observer together stay in a set, and V falls along the loop.

    u = -sum_j h_j K_j xhat,     xhat' = sum_i h_i (A_i xhat + B_i u + L_i (y - yhat)),

where x' = sum_i h_i (A_i x + B_i u), y = sum_i h_i (C_i x + D_i u) of the plant on its box (x+ and
xhat+ in discrete time), and yhat is y at xhat.  With e = x - xhat:

Weights of the plant itself (``measured``: all premises are), z = (x, e):

    z' = sum_ij h_i h_j [ A_i - B_i K_j   B_i K_j       ] z,     u = -sum_j h_j [K_j  -K_j] z
                        [ 0               A_i - L_j C_i ]

Weights at the estimate (``estimated``), z = (xhat, e), one L, and (S_k, R_k) the slopes of f and y
by the state between any two points of the box (``slope-embedding``):

    z' = sum_ij h_i h_j sum_k g_k [ A_i - B_i K_j   L R_k       ] z,     u = -sum_j h_j [K_j  0] z
                                  [ 0               S_k - L R_k ]

Here the observer is xhat' = f(xhat, u) + L (y - yhat), as the blend is f on the box; so
e' = f(x, u) - f(xhat, u) - L (y - yhat).

P > 0, and the decrease of ``decay`` with P of order 2n along every blend and every k.  On
{z'Pz <= c}: every x_k keeps its range; so does xhat_k where the weights are at the estimate, since
both points and the segment between them have to be in the box; every u_k keeps its range for every
gain.  Then no motion leaves {z'Pz <= c}, V falls as e^(-2 alpha t), and x and xhat converge to the
rest.  Proof: while x (with weights at the estimate x and xhat) is in the box and u in its range, z'
is a mean of the matrices above, so V' <= -2 alpha V.  At a first time on the boundary of the set V
would have to grow, but there it falls.  So z stays in the set, where x, xhat and u are in the
ranges in which the model is equal to the plant.  In discrete time V(z+) <= e^(-2 alpha T) V(z)
keeps z in the set at every step.

Evidence: ``P``, ``level`` c, ``decay_rate`` alpha [1/s], and ``input_limits``, bounds on |u_k| that
are claimed besides the ranges; L is the law's (``gains.observer``).

Source: derived here; the separation of both parts is Tanaka and Wang (2001), chapter 4 (recalled),
the mean value form of the error is that of ``observer``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, never, positive
from takagi.certificates.checker.kernel.reader import numbers as read_numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.decay import falls_along, falls_as
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.kinds.observer import hidden_premises, joint_loops
from takagi.certificates.checker.loop.averages import refuse_averages
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.box_of_validity import (
    bounded_inputs,
    disturbances_in_range,
    half_width,
    reaches_at_most,
)
from takagi.certificates.checker.loop.observer_law import ObserverLaw, states_at_start
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.ellipsoid_size import LARGEST, square_root_below
from takagi.certificates.checker.words.rounded import at_least, exactly

# A quantity that must keep its range: a row of z, half of the range, and a description.
Bound = tuple[Matrix, Fraction, str]


@dataclass(frozen=True)
class ObservedLoop(LoopClaim):
    """Plant and observer stay in {z'Pz <= level}, and V = z'Pz falls; see the module."""

    decay_rate: Fraction = number("1/s", better="larger")
    level: Fraction = number(positive=True)
    P: Matrix = matrix("2n", "2n")

    def obligations(self) -> Obligations:
        loop, where = self.loop, self.where
        if self.decay_rate < 0:
            raise CertificateError(f"{where}.decay_rate: a number >= 0 is needed")
        if hidden := _unknown_premise(loop, _law(loop, where)):
            yield never(hidden)
        yield positive(self.P, NOT_DEFINITE)
        loops = whole_loops(self.claim, loop, where)
        yield from falls_along(loop, self.P, self.decay_rate, loops)
        yield from disturbances_in_range(loop, (Fraction(0),) * len(loop.disturbances))
        for row, half, quantity in ranges_kept(self.claim, loop, where):
            failure = f"{quantity} may leave its range in the model's box"
            yield reaches_at_most(self.P, self.level, row, half, failure)

    def sentence(self) -> str:
        loop, law = self.loop, _law(self.loop, self.where)
        first, weights = "x", "weights of the plant, which its measured outputs tell"
        if loop.scheduled_by is None and loop.rules > 1:
            weights = "weights of the plant, which it is assumed to know"
        if law.at_estimate:
            first, weights = "xhat", "weights at the estimate"
        boxed = any(side is not None for side in loop.box) or bool(loop.other_box)
        limits = ", ".join(map(exactly, input_limits(self.claim, loop, self.where)))
        limit_clause = f", with |u_k| <= {limits}" if limits else ""
        lies = f", in which x{' and xhat stay' if law.at_estimate else ' stays'} in the model's box"
        lies += words.granted(loop, disturbances_too=False)
        return (
            f"V = z'Pz with z = ({first}, x - xhat), for u = -K xhat of an observer with "
            f"{weights}, {falls_as(loop, self.decay_rate)}; "
            f"{{V <= {exactly(self.level)}}} is never left{lies if boxed else ''}{limit_clause}; "
            f"exact outputs, no time for computing{self._starts()}{words.deviations(loop, 'xu')}"
        )

    def _starts(self) -> str:
        """Return the largest initial deviation of each state, if all others start at rest."""
        loop = self.loop
        if loop.order > LARGEST:
            return ""
        N = starts(loop)
        S = N.T @ self.P @ N
        reach = ", ".join(
            f"{at_least(square_root_below(self.level / S[k, k]), 4)} in {name}"
            for k, name in enumerate(loop.states)
        )
        measured = any(states_at_start(loop.C, loop.D, loop.order))
        how = "at the measured states and else at rest" if measured else "at rest"
        return f"; where the estimate starts {how}, a state alone may start up to {reach}"


def starts(loop: PolytopicLoop) -> Matrix:
    """Return N of z = N x at the start: measured states are known, other estimates are at rest."""
    law, n = loop.observer, loop.order
    assert law is not None  # the kind asks for it
    is_measured = states_at_start(loop.C, loop.D, n)
    first = Matrix([[int(is_measured[i] and i == j) for j in range(n)] for i in range(n)])
    identity = Matrix.identity(n)
    return Matrix.blocks([[first if law.at_estimate else identity], [identity - first]])


def whole_loops(claim: Any, loop: PolytopicLoop, where: str) -> Iterator[tuple[str, Matrix]]:
    """Yield the matrices of z', each with a name."""
    law = _law(loop, where)
    if not law.at_estimate:
        yield from joint_loops(claim, loop, where, law.L)
        return
    (L,), n = law.L, loop.order
    blends = blends_of(replace(loop, C=(), D=(), E=()), claim, where)
    bounded(len(blends) * len(law.slopes), 2 * n)
    errors = [(L @ R, S - L @ R) for S, R in law.slopes]
    for blend in blends:
        A = blend.A
        for k, (push, error) in enumerate(errors):
            yield (
                f"{blend.label}, slope {k + 1}",
                Matrix.blocks([[A, push], [Matrix.zeros(n, n), error]]),
            )


def ranges_kept(claim: Any, loop: PolytopicLoop, where: str) -> Iterator[Bound]:
    """Yield the quantities with a range, and the inputs with limits in the claim."""
    law, n = _law(loop, where), loop.order
    identity, none = Matrix.identity(n), Matrix.zeros(n, n)
    if len({*loop.states, *loop.inputs}) < len(loop.states) + len(loop.inputs):
        raise CertificateError(f"{where}: a state and an input have one name, also in the box")
    plant = Matrix.blocks([[identity, identity if law.at_estimate else none]])
    for k, side in enumerate(loop.box):
        if side is None:
            continue
        half = half_width(side)
        yield plant.row(k), half, loop.states[k]
        if law.at_estimate:
            estimate = Matrix.blocks([[identity, none]])
            yield estimate.row(k), half, f"the estimate of {loop.states[k]}"
    halves = [(k, half_width(side)) for k, side in bounded_inputs(loop).items()]
    halves += enumerate(input_limits(claim, loop, where))
    for j, K in enumerate(loop.K):
        gain_row = Matrix.blocks([[K, Matrix.zeros(*K.shape) if law.at_estimate else -K]])
        for k, half in halves:
            name = loop.inputs[k] if loop.inputs else f"input {k + 1}"
            yield gain_row.row(k), half, f"{name} by gain {j + 1}"


def input_limits(claim: Any, loop: PolytopicLoop, where: str) -> list[Fraction]:
    """Return the limits of the claim on |u_k|; none if it has none."""
    if "input_limits" not in claim:
        return []
    return read_numbers(claim, "input_limits", where, loop.K[0].shape[0])


def _law(loop: PolytopicLoop, where: str) -> ObserverLaw:
    refuse_averages(loop, "observer", where)
    if loop.observer is None:
        raise CertificateError(f"{where}: gains with an observer are needed (gains.observer)")
    if not loop.C:
        raise CertificateError(f"{where}: the model has no output to observe from")
    if not loop.K or not loop.shared_weights:
        raise CertificateError(f"{where}: gains with the weights of the model are needed")
    return loop.observer


def _unknown_premise(loop: PolytopicLoop, law: ObserverLaw) -> str:
    """Return why the observer cannot compute its weights; empty if it can.

    It evaluates its premises before it commands, so that it does not know an input.
    """
    commanded = [name for name in loop.scheduled_by or () if name in loop.inputs]
    if commanded:
        return f"premises depend on {commanded[0]}, which the law knows after it has commanded"
    if not law.at_estimate:
        hidden = hidden_premises(loop)
        return f"premises depend on {hidden}, which is not measured" if hidden else ""
    # With weights at the estimate the observer knows estimated states, but no outside signals.
    outside = [name for name in loop.scheduled_by or () if name not in loop.states]
    return f"premises depend on {outside[0]}, which the observer does not know" if outside else ""
