r"""Dynamic output feedback of full order: one controller a rule, with measured premises.

    x' = sum_i h_i A_i x + B u,  y = C x,      s' = sum_i h_i (F_i s + G_i y),  u = sum_i h_i H_i s

(x+ and s+ in discrete time), with the weights h known from what is measured, and with B and C the
same in all rules.  With P = [[Y, N], [N', *]], P^-1 = [[X, M], [M', *]], M N' = I - X Y, and

    Hb_i = H_i M',   Gb_i = N G_i,   Fb_i = N F_i M' + N G_i C X + Y B H_i M' + Y A_i X,

the condition that V = z'Pz, z = (x, s), decays as e^(-2 alpha t) is linear in X, Y, Fb, Gb, Hb:

    W = [[X, I], [I, Y]] > 0,     R_i = [ A_i X + B Hb_i   A_i          ]
                                        [ Fb_i             Y A_i + Gb_i C ]
    continuous   R_i + R_i' + 2 alpha W < 0
    discrete     [[rho^2 W, R_i'], [R_i, W]] > 0,   rho = e^(-alpha T)

for every rule.  It is affine in h as B and C are common, so that rules suffice.  Nothing is lost
for one rule: this is every linear controller of the plant's order.

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
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel

# Bound on the unknowns, relative to the states' units: without one a margin says nothing.
LARGEST = 1e3


class Observed(Protocol):
    """What the design reads of a model: A (r, n, n), B (r, n, m), C (r, p, n)."""

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
        """Return the controller with so many significant digits of the largest of each matrix."""

        def short(stack: Floats) -> Floats:
            largest = float(np.abs(stack).max()) or 1.0
            return np.round(stack, digits - 1 - int(np.floor(np.log10(largest)))) + 0.0

        return DynamicController(short(self.F), short(self.G), short(self.H), self.P)

    def closed_loop(self, model: TSModel) -> tuple[TSModel, Floats]:
        """Return a model with the states (x, s) and gains K (r, m + n, 2n), for ``certify``.

        Its inputs are u and s', so that u = H s and s' = F s + G C x are the law -K (x, s).  The
        certificate is about the decimals of K, in which G_i C is a product: exact where C has
        entries 0 and 1.
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
    controller : None where none was found.
    status : "candidate", "infeasible" or "unknown".
    diagnosis : of the solver, in words.
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
    F = Unknown("F", n, n, count=r, latex=r"\hat F")
    G = Unknown("G", n, p, count=r, latex=r"\hat G")
    H = Unknown("H", m, n, count=r, latex=r"\hat H")
    one = np.eye(n)[None]
    diagonal = (
        Term(unknown=X, left=one, right=one),
        Term(unknown=Y, left=one, right=one, at=(1, 1)),
    )
    positive = LMI(
        name="W",
        blocks=(n, n),
        terms=diagonal,
        constants=(Constant(value=one, at=(0, 1), latex="I"),),
    )
    bounded = LMI(
        name="bounded",
        blocks=(n, n),
        terms=diagonal,
        constants=(
            Constant(value=-LARGEST * one, latex=r"-\kappa I"),
            Constant(value=-LARGEST * one, at=(1, 1), latex=r"-\kappa I"),
        ),
        sign=-1,
        weight=0.0,
    )
    R = _Motion(A, B, C, X, Y, F, G, H)
    decay = R.continuous(alpha) if step is None else R.discrete(math.exp(-2 * alpha * step))
    return Condition(
        name="dynamic output feedback",
        unknowns=(X, Y, F, G, H),
        lmis=(positive, bounded, decay),
        source="Scherer, Gahinet, Chilali (1997), section IV",
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """R_i of the module as terms of an LMI."""

    A: Array
    B: Array
    C: Array
    X: Unknown
    Y: Unknown
    F: Unknown
    G: Unknown
    H: Unknown

    def continuous(self, alpha: float) -> LMI:
        """Return R_i + R_i' + 2 alpha W < 0."""
        whole = np.eye(2 * self.n)
        fixed = self._fixed(whole, whole) + 2 * alpha * self._cross(whole)
        return LMI(
            name="rule",
            blocks=(2 * self.n,),
            terms=(*self._moving(whole, whole), *self._weighted(2 * alpha, whole)),
            constants=(Constant(value=fixed, at=None),),
            sign=-1,
            count=len(self.A),
            index=rf"i = 1, \dots, {len(self.A)}",
        )

    def discrete(self, shrink: float) -> LMI:
        """Return [[shrink W, R_i'], [R_i, W]] > 0."""
        whole = np.eye(2 * self.n)
        upper, lower = np.vstack([whole, 0 * whole]), np.vstack([0 * whole, whole])
        fixed = self._fixed(lower, upper) + shrink * self._cross(upper) + self._cross(lower)
        return LMI(
            name="rule",
            blocks=(4 * self.n,),
            terms=(
                *self._moving(lower, upper),
                *self._weighted(shrink, upper),
                *self._weighted(1.0, lower),
            ),
            constants=(Constant(value=fixed, at=None),),
            count=len(self.A),
            index=rf"i = 1, \dots, {len(self.A)}",
        )

    @property
    def n(self) -> int:
        return int(self.A.shape[1])

    def _halves(self, place: Array) -> tuple[Array, Array]:
        """Return the columns of a place (size, 2n) that belong to x, and to s."""
        return place[:, : self.n], place[:, self.n :]

    def _moving(self, rows: Array, columns: Array) -> list[Term]:
        """Return R_i and its transpose, with its rows and columns (size, 2n) placed."""
        first, second = self._halves(rows)
        left, right = self._halves(columns)
        each = np.arange(len(self.A))
        parts: list[tuple[Unknown, Array, Array, bool]] = [
            (self.X, first @ self.A, left.T[None], False),
            (self.H, (first @ self.B)[None], left.T[None], True),
            (self.F, second[None], left.T[None], True),
            (self.Y, second[None], self.A @ right.T, False),
            (self.G, second[None], (self.C @ right.T)[None], True),
        ]
        return [
            Term(
                unknown=unknown,
                left=before,
                right=behind,
                at=None,
                plus_transpose=True,
                members=each if by_rule else None,
            )
            for unknown, before, behind, by_rule in parts
        ]

    def _weighted(self, factor: float, place: Array) -> list[Term]:
        """Return factor times X and Y of W."""
        pairs = zip((self.X, self.Y), self._halves(place), strict=True)
        return [
            Term(unknown=one, left=factor * half[None], right=half.T[None], at=None)
            for one, half in pairs
        ]

    def _fixed(self, rows: Array, columns: Array) -> Array:
        """Return the A_i that stands alone in R_i, and its transpose, (r, size, size)."""
        alone = self._halves(rows)[0] @ self.A @ self._halves(columns)[1].T
        return np.asarray(alone + alone.transpose(0, 2, 1))

    def _cross(self, place: Array) -> Array:
        """Return the I beside X and Y in W."""
        first, second = self._halves(place)
        return np.asarray(first @ second.T + second @ first.T)


def dynamic_output_feedback(
    model: Observed, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> DynamicOutputDesign:
    """Return a controller of the plant's order from the measured outputs.

    The premises have to be measured: the controller's weights are the plant's.  Rounded, the
    controller is proved by ``certify`` of its ``closed_loop``, with the claims of any model.

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
    B = _common(input_stack(model, vertex_stack(model), "B"), "B")
    C = _outputs(model, A)
    X, Y = outcome.values["X"][0], outcome.values["Y"][0]
    U, sizes, V = np.linalg.svd(np.eye(len(X)) - X @ Y)
    M, N = U * np.sqrt(sizes), V.T * np.sqrt(sizes)
    H = outcome.values["H"] @ np.linalg.inv(M).T
    G = np.linalg.solve(N, outcome.values["G"])
    inner = outcome.values["F"] - N @ G @ C @ X - Y @ B @ H @ M.T - Y @ A @ X
    F = np.linalg.solve(N, inner) @ np.linalg.inv(M).T
    # P [X, I; M', 0] = [I, Y; 0, N'].
    zero, one = np.zeros_like(X), np.eye(len(X))
    P = np.block([[one, Y], [zero, N.T]]) @ np.linalg.inv(np.block([[X, one], [M.T, zero]]))
    return DynamicOutputDesign(DynamicController(F, G, H, (P + P.T) / 2), outcome.status)


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
