"""A plant with its disturbances and outputs as one system, and its loop with a controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError


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
