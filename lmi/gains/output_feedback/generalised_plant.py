"""Plant and weights as one system, and the LMIs of its energy gain.

A plant with weights as one system: x' = A x + B1 w + B2 u, z = C1 x + D11 w + D12 u, y = ...

Energy gain by dynamic output feedback as LMIs; nothing here solves them.

For the generalised plant and a controller of its order, with the unknowns X, Y symmetric, Ah, Bh,
Ch and Dh,

    [ He(A X + B2 Ch)   Ah' + A + B2 Dh C2   B1 + B2 Dh D21   (C1 X + D12 Ch)'     ]
    [ .                 He(Y A + Bh C2)      Y B1 + Bh D21    (C1 + D12 Dh C2)'    ]  < 0
    [ .                 .                    -gamma I         (D11 + D12 Dh D21)'  ]
    [ .                 .                    .                -gamma I             ]

    [ X   I ]
    [ I   Y ]  > 0

and gamma least: the bounded real lemma of the loop after a congruence and a change of variables
that makes it linear.  Every norm above the optimum is reached by such a controller, so the least
gamma is that of all linear controllers.

Continuous time alone: the bilinear transform carries a sampled problem there and back, with its
norm.

Source: Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42, section IV, recalled.

The change of variables that makes dynamic output feedback linear, and its inverse.

For the plant x' = A x + B u, y = C x and a controller s' = A_K s + B_K y, u = C_K s + D_K y of the
same order, the Lyapunov matrix P of z = (x, s) is written with X and Y,

    P = [[Y, N], [N', *]],    P^-1 = [[X, M], [M', *]],    M N' = I - X Y.

In the unknowns X, Y and

    Dh = D_K
    Ch = C_K M' + D_K C X
    Bh = N B_K + Y B D_K
    Ah = N A_K M' + N B_K C X + Y B C_K M' + Y (A + B D_K C) X

the Lyapunov inequality of the closed loop is linear after a congruence.  P > 0 is W > 0,
W = [[X, I], [I, Y]].  In discrete time x+ and s+ replace x' and s'.

Source: Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42(7):896-911, section IV,
recalled.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, block, matrix
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Status


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class GeneralisedPlant(ShortRepr):
    """x' = A x + B1 w + B2 u, z = C1 x + D11 w + D12 u, y = C2 x + D21 w, in continuous time.

    Attributes
    ----------
    A, B1, B2 : (n, n), (n, q), (n, m).
    C1, D11, D12 : (p, n), (p, q), (p, m).
    C2, D21 : (k, n), (k, q); u does not reach y directly.
    """

    A: Floats
    B1: Floats
    B2: Floats
    C1: Floats
    C2: Floats
    D11: Floats
    D12: Floats
    D21: Floats

    def __post_init__(self) -> None:
        for name in ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21"):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            if value.ndim != 2 or not np.isfinite(value).all():
                raise ModelError(
                    f"{name} has shape {value.shape}; a matrix of finite numbers is needed"
                )
            object.__setattr__(self, name, value)
        n, q, m = self.A.shape[0], self.B1.shape[1], self.B2.shape[1]
        p, k = self.C1.shape[0], self.C2.shape[0]
        needed = {"A": (n, n), "B1": (n, q), "B2": (n, m), "C1": (p, n), "C2": (k, n)}
        needed |= {"D11": (p, q), "D12": (p, m), "D21": (k, q)}
        for name, shape in needed.items():
            if getattr(self, name).shape != shape or 0 in shape:
                raise ModelError(
                    f"{name} is {getattr(self, name).shape}; {shape} is needed, none of them 0"
                )

    def in_states(self, T: Floats) -> GeneralisedPlant:
        """Return the plant in the states xhat of x = T xhat."""
        back = np.asarray(np.linalg.inv(T), dtype=np.float64)
        return GeneralisedPlant(
            A=back @ self.A @ T,
            B1=back @ self.B1,
            B2=back @ self.B2,
            C1=self.C1 @ T,
            C2=self.C2 @ T,
            D11=self.D11,
            D12=self.D12,
            D21=self.D21,
        )

    def closed(self, controller: StateSpace) -> StateSpace:
        """Return the loop from w to z with u = K(s) y."""
        Ak, Bk, Ck, Dk = controller.A, controller.B, controller.C, controller.D
        A = np.block([[self.A + self.B2 @ Dk @ self.C2, self.B2 @ Ck], [Bk @ self.C2, Ak]])
        B = np.vstack([self.B1 + self.B2 @ Dk @ self.D21, Bk @ self.D21])
        C = np.hstack([self.C1 + self.D12 @ Dk @ self.C2, self.D12 @ Ck])
        return StateSpace(A, B, C, self.D11 + self.D12 @ Dk @ self.D21)


@dataclass(frozen=True, slots=True, eq=False)
class StateSpace:
    """x' = A x + B u, y = C x + D u: (n, n), (n, m), (p, n), (p, m); n may be 0."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats

    @property
    def order(self) -> int:
        """Return n."""
        return len(self.A)

    def response(self, frequency: float) -> Any:
        """Return the complex (p, m) response at a frequency in rad/s."""
        at = 1j * frequency * np.eye(self.order) - self.A
        return self.C @ np.linalg.solve(at, self.B) + self.D


class ControllerFound:
    """A controller, or the reason why there is none."""

    __slots__ = ()
    if TYPE_CHECKING:

        @property
        def controller(self) -> StateSpace | None: ...

        @property
        def status(self) -> Status: ...

        @property
        def diagnosis(self) -> str: ...

    @property
    def found(self) -> bool:
        """Return whether there is a controller."""
        return self.controller is not None

    def require(self) -> StateSpace:
        """Return the controller.

        Raises
        ------
        ModelError : there is none; the message is the diagnosis.
        """
        if self.controller is None:
            raise ModelError(f"no controller was found ({self.status}): {self.diagnosis}")
        return self.controller


def state_space(name: str, system: Any) -> StateSpace:
    """Return a system in state space, from what the user has.

    ``system`` : a transfer function or a state space of python-control; (A, B, C, D); a number or a
    matrix, which has no states.

    Raises ModelError: none of these, of discrete time, or improper.
    """
    if isinstance(system, StateSpace):
        return system
    if hasattr(system, "poles") and hasattr(system, "dt"):
        if system.dt not in (None, 0):
            raise ModelError(
                f"{name} is of discrete time (dt = {system.dt}); continuous time is needed: take "
                "the bilinear transform, which keeps H-infinity norms, and back"
            )
        import control

        try:
            converted = system if hasattr(system, "A") else control.ss(system, method="scipy")
        except (ValueError, control.ControlMIMONotImplemented) as error:
            raise ModelError(
                f"{name} cannot be written in state space ({error}); give (A, B, C, D)"
            ) from error
        matrices: tuple[Any, ...] = (converted.A, converted.B, converted.C, converted.D)
    elif isinstance(system, tuple) and len(system) == 4:
        matrices = system
    else:
        D = np.atleast_2d(_numbers(name, system))
        return StateSpace(np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((D.shape[0], 0)), D)
    A, B, C, D = (np.atleast_2d(_numbers(name, matrix)) for matrix in matrices)
    n = A.shape[0] if A.size else 0
    if not n:
        return StateSpace(np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((D.shape[0], 0)), D)
    if A.shape != (n, n) or B.shape != (n, D.shape[1]) or C.shape != (D.shape[0], n):
        raise ModelError(
            f"{name}: A {A.shape}, B {B.shape}, C {C.shape}, D {D.shape} do not fit together"
        )
    return StateSpace(A, B, C, D)


def _numbers(name: str, value: ArrayLike) -> Floats:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"{name} is {value!r}; a transfer function or state space of python-control, "
            "(A, B, C, D), a matrix or a number is needed"
        ) from error
    if array.ndim > 2 or not np.isfinite(array).all():
        raise ModelError(f"{name} has shape {array.shape}; a matrix of finite numbers is needed")
    return array


def factors(X: Floats, Y: Floats) -> tuple[Floats, Floats]:
    """Return M and N (n, n) with M N' = I - X Y, by its singular values."""
    U, sizes, V = np.linalg.svd(np.eye(len(X)) - X @ Y)
    return U * np.sqrt(sizes), V.T * np.sqrt(sizes)


def controller_matrices(
    plant: tuple[Floats, Floats, Floats],
    X: Floats,
    Y: Floats,
    hats: tuple[Floats, Floats, Floats, Floats],
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return A_K, B_K, C_K, D_K from the unknowns of the LMIs.

    Parameters
    ----------
    plant : A (n, n), or (r, n, n) for one matrix a rule; B (n, m); C (p, n).
    X, Y : (n, n), with I - X Y invertible.
    hats : Ah (n, n), Bh (n, p), Ch (m, n), Dh (m, p), each with a first axis of rules where A has
        one.
    """
    A, B, C = plant
    Ah, Bh, Ch, Dh = hats
    M, N = factors(X, Y)
    C_K = _transposed(_solved(M, _transposed(Ch - Dh @ C @ X)))
    B_K = _solved(N, Bh - Y @ B @ Dh)
    remainder = Ah - N @ B_K @ C @ X - Y @ B @ C_K @ M.T - Y @ (A + B @ Dh @ C) @ X
    A_K = _transposed(_solved(M, _transposed(_solved(N, remainder))))
    return A_K, B_K, C_K, Dh


def _solved(M: Floats, right_side: Floats) -> Floats:
    return np.asarray(np.linalg.solve(M, right_side), dtype=np.float64)


def _transposed(stack: Floats) -> Floats:
    return np.asarray(stack.swapaxes(-1, -2))


def hinf_output_feedback_condition(plant: GeneralisedPlant) -> Condition:
    """Pose the module's LMIs; the objective is gamma.

    ``plant`` : in continuous time; u does not reach y directly.

    Returns the condition in the plant's coordinates as they are, with the unknowns ``X``, ``Y``,
    ``Ah``, ``Bh``, ``Ch``, ``Dh`` and ``gamma``.  Nothing is solved.

    Raises ModelError: none; the plant has been checked.
    """
    n, q, m = len(plant.A), plant.B1.shape[1], plant.B2.shape[1]
    p, outputs = len(plant.C1), len(plant.C2)
    X = Unknown("X", n, n, symmetric=True)
    Y = Unknown("Y", n, n, symmetric=True)
    Ah = Unknown("Ah", n, n, latex=r"\hat A")
    Bh = Unknown("Bh", n, outputs, latex=r"\hat B")
    Ch = Unknown("Ch", m, n, latex=r"\hat C")
    Dh = Unknown("Dh", m, outputs, latex=r"\hat D")
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    A, B1, B2 = matrix(plant.A, "A"), matrix(plant.B1, "B_1"), matrix(plant.B2, "B_2")
    C1, C2 = matrix(plant.C1, "C_1"), matrix(plant.C2, "C_2")
    D11, D12 = matrix(plant.D11, "D_{11}"), matrix(plant.D12, "D_{12}")
    D21 = matrix(plant.D21, "D_{21}")
    gain = block(
        [
            [
                He(A @ X + B2 @ Ch),
                Ah.T + A + B2 @ Dh @ C2,
                B1 + B2 @ Dh @ D21,
                (C1 @ X + D12 @ Ch).T,
            ],
            [None, He(Y @ A + Bh @ C2), Y @ B1 + Bh @ D21, (C1 + D12 @ Dh @ C2).T],
            [None, None, -gamma * np.eye(q), (D11 + D12 @ Dh @ D21).T],
            [None, None, None, -gamma * np.eye(p)],
        ]
    )
    return pose(
        (block([[X, np.eye(n)], [None, Y]]) >> 0).named("Lyapunov function"),
        (gain << 0).named("bounded real"),
        minimise=gamma,
        name="energy gain by dynamic output feedback",
        source="Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42",
    )
