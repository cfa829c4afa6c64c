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
gain.  V falls on the whole boundary, so no motion leaves the set; on the set the model is equal to
the plant.

Evidence: ``P``, ``level`` c, ``decay_rate`` alpha [1/s], and ``input_limits``, bounds on |u_k| that
are claimed besides the ranges; L is the law's (``gains.observer``).

Source: derived here; the separation of both parts is Tanaka and Wang (2001), chapter 4 (recalled),
the mean value form of the error is that of ``observer``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.decay import decrease, decrease_factor
from takagi.certificates.checker.kinds.disturbance_channel import zero
from takagi.certificates.checker.kinds.observer import hidden_premises, joint_loops
from takagi.certificates.checker.loop.averages import refuse_averages
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.box_of_validity import (
    beyond_range,
    bounded_inputs,
    reaches_at_most,
    row_of,
)
from takagi.certificates.checker.loop.observer_law import ObserverLaw
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded

# A quantity that must keep its range: a row of z, half of the range, and a description.
Bound = tuple[Matrix, Fraction, str]


def check_observed_loop(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED if every inequality of the module holds, else UNDECIDED with the first."""
    name, n = text(claim, "name", where), loop.order
    alpha, level = number(claim, "decay_rate", where), number(claim, "level", where)
    P = read_matrix(claim, "P", where, (2 * n, 2 * n))
    if alpha < 0 or level <= 0:
        raise CertificateError(f"{where}: decay_rate >= 0 and level > 0 are needed")
    law = _law(loop, where)
    hidden = _unknown_premise(loop, law)
    if hidden:
        return Claim(name, Verdict.UNDECIDED, hidden)
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    factor = decrease_factor(loop, alpha)
    for label, G in whole_loops(claim, loop, where):
        if not decrease(loop, P, G, factor).is_positive_definite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {label}")
    if beyond := beyond_range(loop, (Fraction(0),) * len(loop.disturbances)):
        return Claim(name, Verdict.UNDECIDED, beyond)
    for row, half, what in ranges_kept(claim, loop, where):
        if not reaches_at_most(P, level, row, half):
            return Claim(name, Verdict.UNDECIDED, f"{what} may leave its range in the model's box")
    said = {"name": name, "loop": loop, "P": P, "level": level, "alpha": alpha}
    said["limits"] = input_limits(claim, loop, where)
    return Found(Verdict.PROVED, "observed_loop", said)


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
            yield f"{blend.label}, slope {k + 1}", Matrix.blocks([[A, push], [zero(n, n), error]])


def ranges_kept(claim: Any, loop: PolytopicLoop, where: str) -> Iterator[Bound]:
    """Yield the quantities with a range, and the inputs with limits in the claim."""
    law, n = _law(loop, where), loop.order
    one, none = Matrix.identity(n), zero(n, n)
    if len({*loop.states, *loop.inputs}) < len(loop.states) + len(loop.inputs):
        raise CertificateError(f"{where}: a state and an input have one name, also in the box")
    plant = Matrix.blocks([[one, one if law.at_estimate else none]])
    for k, side in enumerate(loop.box):
        if side is None:
            continue
        half = min(-side[0], side[1])
        yield row_of(plant, k), half, loop.states[k]
        if law.at_estimate:
            estimate = Matrix.blocks([[one, none]])
            yield row_of(estimate, k), half, f"the estimate of {loop.states[k]}"
    halves = [(k, min(-side[0], side[1])) for k, side in bounded_inputs(loop).items()]
    halves += enumerate(input_limits(claim, loop, where))
    for j, K in enumerate(loop.K):
        whole = Matrix.blocks([[K, zero(*K.shape) if law.at_estimate else -K]])
        for k, half in halves:
            name = loop.inputs[k] if loop.inputs else f"input {k + 1}"
            yield row_of(whole, k), half, f"{name} by gain {j + 1}"


def input_limits(claim: Any, loop: PolytopicLoop, where: str) -> list[Fraction]:
    """Return the limits of the claim on |u_k|; none if it has none."""
    if "input_limits" not in claim:
        return []
    return numbers(claim, "input_limits", where, loop.K[0].shape[0])


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
