r"""A scheduled controller of the plant's order: one set of matrices a rule, measured premises.

    x' = sum_i h_i A_i x + B u,  y = C x,      s' = sum_i h_i (F_i s + G_i y),  u = sum_i h_i H_i s

(x+ and s+ in discrete time), where the weights h are known from measured signals, and B and C are
the same in all rules.  In the unknowns X, Y, Fb_i, Gb_i, Hb_i of ``condition`` (there
Ah, Bh, Ch, with D_K = 0) the condition that V = z'Pz, z = (x, s), decays as e^(-2 alpha t) is

    W = [[X, I], [I, Y]] > 0,     R_i = [ A_i X + B Hb_i   A_i            ]
                                        [ Fb_i             Y A_i + Gb_i C ]
    continuous   R_i + R_i' + 2 alpha W < 0
    discrete     [[rho^2 W, R_i'], [R_i, W]] > 0,   rho = e^(-alpha T)

for every rule.  R_i is affine in A_i, Fb_i, Gb_i and Hb_i because B and C are common; so the
condition at the rules implies it at every blend.  For one rule the condition is also necessary:
it holds for some unknowns if and only if a linear controller of the plant's order gives this decay.

Source: Scherer, Gahinet, Chilali (1997), IEEE Transactions on Automatic Control 42(7):896-911,
section IV; Li, Wang, Niemann, Tanaka (2000), Information Sciences 123:201-221, for rules (both
recalled).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from takagi.lmi.argument_checks import input_stack, number, sample_time_of, vertex_stack
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide
from takagi.lmi.expressions.expression import Expression, He, Inequality, block, matrix
from takagi.lmi.gains.output_feedback.condition import (
    controller_matrices,
    lyapunov_matrix,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel

# Bound on X and Y, in the model's units.  The LMIs still hold when all unknowns are scaled up, with
# more margin; without a bound the margin would have no largest value.
LARGEST = 1e3
# The blocks of R_i, by rows.
Blocks = tuple[tuple[Expression, Expression], tuple[Expression, Expression]]


class Observed(Protocol):
    """The matrices of a model that the design reads: A (r, n, n), B (r, n, m), C (r, p, n)."""

    @property
    def A(self) -> Array: ...

    @property
    def B(self) -> Array: ...

    @property
    def C(self) -> Array: ...


@dataclass(frozen=True, slots=True, eq=False)
class DynamicController:
    """s' = sum_i h_i (F_i s + G_i y), u = sum_i h_i H_i s.

    Attributes
    ----------
    F, G, H : (r, n, n), (r, n, p), (r, m, n).
    P : (2n, 2n) of V = z'Pz, z = (x, s), as the solver found it.
    """

    F: Floats
    G: Floats
    H: Floats
    P: Floats

    def rounded(self, digits: int) -> DynamicController:
        """Return the controller rounded to ``digits`` significant digits of each largest entry.

        F, G and H each have one last decimal, for all rules together; P is kept as it is.
        """

        def short(stack: Floats) -> Floats:
            largest = float(np.abs(stack).max()) or 1.0
            return np.round(stack, digits - 1 - int(np.floor(np.log10(largest)))) + 0.0

        return DynamicController(short(self.F), short(self.G), short(self.H), self.P)

    def closed_loop(self, model: TSModel) -> tuple[TSModel, Floats]:
        """Return a model with the states (x, s) and gains K (r, m + n, 2n), for ``certify``.

        Its inputs are u and s', so that u = H s and s' = F s + G C x are the law -K (x, s).  The
        certificate is about the decimals of K.  They contain the products G_i C, which are exact
        where C has entries 0 and 1 only.
        """
        B, C = _common(model.B, "B"), _common(model.C, "C")
        n, m = B.shape
        r = len(model.A)
        A = np.zeros((r, 2 * n, 2 * n))
        A[:, :n, :n] = model.A
        K = -np.block([[np.zeros((r, m, n)), self.H], [self.G @ C, self.F]])
        labels = tuple(f"s{k} [-]" for k in range(1, n + 1))
        rates = tuple(f"r{k} [-]" for k in range(1, n + 1))
        whole = TSModel(
            A,
            np.block([[B, np.zeros((n, n))], [np.zeros((n, m)), np.eye(n)]]),
            states=(*model.states, *labels),
            inputs=(*model.inputs, *rates),
            premises=model.premises,
            rules=model.rules,
            box=model.box,
            sample_time=model.sample_time,
            name=f"{model.name or 'model'} with its controller",
        )
        return whole, K


@dataclass(frozen=True, slots=True, eq=False)
class DynamicOutputDesign:
    """A controller, or why there is none.

    Attributes
    ----------
    controller : None if none was found.
    status : "candidate", "infeasible" or "unknown".
    diagnosis : why none was found, in words; empty otherwise.
    """

    controller: DynamicController | None
    status: str
    diagnosis: str = ""

    @property
    def found(self) -> bool:
        return self.controller is not None


def dynamic_output_condition(
    model: Observed, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> Condition:
    """Pose the LMIs of the module in X, Y and Fb_i, Gb_i, Hb_i.  Nothing is solved.

    Parameters
    ----------
    model : A (r, n, n); B (n, m) and C (p, n), the same in all rules.
    decay_rate : alpha in 1/s.
    sample_time : T in s of x+ = A x + B u; None takes the model's own.

    Raises
    ------
    ModelError : shapes, entries that are not finite, B or C that differ between rules.

    Source: Scherer, Gahinet, Chilali (1997), section IV; see the module.
    """
    A = vertex_stack(model)
    B, C = _common(input_stack(model, A, "B"), "B"), _outputs(model, A)
    alpha, step = float(number("decay_rate", decay_rate)), sample_time_of(model, sample_time)
    r, n = A.shape[:2]
    m, p = B.shape[1], C.shape[0]
    X, Y = Unknown("X", n, n, symmetric=True), Unknown("Y", n, n, symmetric=True)
    F = Unknown("F", n, n, count=r, latex=r"\hat{F}")
    G = Unknown("G", n, p, count=r, latex=r"\hat{G}")
    H = Unknown("H", m, n, count=r, latex=r"\hat{H}")
    known, Bs, Cs = matrix(A, "A_i"), matrix(B, "B"), matrix(C, "C")
    R = ((known @ X + Bs @ H, known), (F.as_expression(), Y @ known + G @ Cs))
    decay = (
        _continuous(R, X, Y, 2 * alpha)
        if step is None
        else _discrete(R, X, Y, math.exp(-2 * alpha * step))
    )
    most = LARGEST * np.eye(n)
    return pose(
        (block([[X, np.eye(n)], [None, Y]]) >> 0).named("W"),
        (block([[most - X, np.zeros((n, n))], [None, most - Y]]) >= 0).named("bounded"),
        decay.named("rule", rf"i = 1, \dots, {r}"),
        name="dynamic output feedback",
        source="Scherer, Gahinet, Chilali (1997), section IV",
    )


def _continuous(R: Blocks, X: Unknown, Y: Unknown, rate: float) -> Inequality:
    """Return R_i + R_i' + rate W < 0."""
    (R11, R12), (R21, R22) = R
    cross: Expression = R12 + R21.T
    first, second = He(R11), He(R22)
    if rate:
        cross = cross + rate * np.eye(X.rows)
        first, second = first + rate * X, second + rate * Y
    return block([[first, cross], [None, second]]) << 0


def _discrete(R: Blocks, X: Unknown, Y: Unknown, shrink: float) -> Inequality:
    """Return [[shrink W, R_i'], [R_i, W]] > 0."""
    (R11, R12), (R21, R22) = R
    one = np.eye(X.rows)
    rows: list[list[object]] = [
        [shrink * X, shrink * one, R11.T, R21.T],
        [None, shrink * Y, R12.T, R22.T],
        [None, None, X, one],
        [None, None, None, Y],
    ]
    return block(rows) >> 0


def dynamic_output_feedback(
    model: Observed, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> DynamicOutputDesign:
    """Return a controller of the plant's order that reads only the measured outputs.

    The premises must be measured, because the controller uses the plant's weights.  Nothing is
    proved here: round the controller and pass its ``closed_loop`` to ``certify``, which takes the
    same claims as for any other model.

    Parameters
    ----------
    model, decay_rate, sample_time : as of ``dynamic_output_condition``.

    Raises
    ------
    ModelError : as ``dynamic_output_condition``.

    Source: Scherer, Gahinet, Chilali (1997); see the module.
    """
    condition = dynamic_output_condition(model, decay_rate=decay_rate, sample_time=sample_time)
    outcome = decide(condition)
    if outcome.status != "candidate":
        return DynamicOutputDesign(None, outcome.status, outcome.reason)
    A = vertex_stack(model).astype(np.float64)
    B, C = _common(input_stack(model, A, "B"), "B"), _outputs(model, A)
    X, Y = outcome.values["X"][0], outcome.values["Y"][0]
    direct = np.zeros((1, B.shape[1], len(C)))
    hats = (outcome.values["F"], outcome.values["G"], outcome.values["H"], direct)
    F, G, H, _ = controller_matrices((A, B, C), X, Y, hats)
    controller = DynamicController(F, G, H, lyapunov_matrix(X, Y))
    return DynamicOutputDesign(controller, outcome.status)


def _outputs(model: Observed, A: Array) -> Array:
    C = np.asarray(model.C, dtype=np.float64)
    if C.ndim == 2:
        C = C[None]
    if C.ndim != 3 or not C.shape[1] or C.shape[2] != A.shape[1]:
        raise ModelError(f"C has shape {C.shape}; (r, p, {A.shape[1]}) with an output is needed")
    return _common(C, "C")


def _common(stack: Array, letter: str) -> Array:
    found = np.asarray(stack, dtype=np.float64)
    if found.ndim == 2:
        return found
    if np.any(found != found[0]):
        raise ModelError(
            f"{letter} differs between the rules; a controller that is affine in the weights needs "
            f"the same {letter} in all: put a filter in front of the input or behind the output, "
            "whose state takes it into A"
        )
    return np.asarray(found[0])
