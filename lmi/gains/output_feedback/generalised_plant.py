"""A plant with weights as one system: x' = A x + B1 w + B2 u, z = C1 x + D11 w + D12 u, y = ..."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Status


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GeneralisedPlant:
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

    Parameters
    ----------
    system : a transfer function or a state space of python-control; (A, B, C, D); a number or a
        matrix, which has no states.

    Raises
    ------
    ModelError : none of these, of discrete time, or improper.
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
