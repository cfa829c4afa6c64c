r"""Observer-based output feedback: parallel distributed compensation with an estimate.

    u = u* - sum_i h_i K_i s,
    s' = sum_i h_i (A_i s + B_i (u - u*) + L_i (y - y* - C_i s - D_i (u - u*)))

s is the estimate of x - x*; in discrete time s(t + T) replaces s'.  The weights h are those of the
plant, if they depend on measured outputs only, or the weights at the estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.pdc import PdcLaw
from takagi.models.ts.model import TSModel
from takagi.models.ts.vertex_arrays import finite_array


@dataclass(frozen=True, eq=False)
class OutputFeedback:
    """The law of the module.

    Attributes
    ----------
    feedback : K with model, premises and rests; it is evaluated at the estimate.
    L : (r, n, p); (n, p) gives all rules the same L.
    rows : indices of the p measured outputs among the outputs of the model.
    at_estimate : whether the weights are evaluated at the estimate.

    Raises
    ------
    ModelError : gains that do not fit, an output that the model does not have.
    """

    feedback: PdcLaw
    L: Floats
    rows: tuple[int, ...]
    at_estimate: bool

    def __post_init__(self) -> None:
        p = self.model.C.shape[1]
        if not self.rows or any(not 0 <= k < p for k in self.rows):
            raise ModelError(f"rows = {self.rows}: places of the model's {p} outputs are needed")
        r, n = self.model.A.shape[:2]
        L = finite_array("L", self.L)
        shape = (r, n, len(self.rows))
        if L.shape in (shape[1:], (1, *shape[1:])):
            L = np.broadcast_to(L, shape).copy()
        if L.shape != shape:
            raise ModelError(f"L has shape {L.shape}; {shape} or {shape[1:]} is needed")
        L.flags.writeable = False
        object.__setattr__(self, "L", L)

    @property
    def model(self) -> TSModel:
        return self.feedback.model

    @property
    def sample_time(self) -> float | None:
        """T in s of a law in discrete time; None for continuous time."""
        return self.model.sample_time

    @cached_property
    def _seen(self) -> dict[int, tuple[int, float]]:
        return seen_directly(self.model, self.rows)

    def memberships(self, estimate: ArrayLike, measured: ArrayLike) -> Floats:
        """Return h (r,) for s (n,) and y - y* (p,)."""
        point = np.array(estimate, dtype=np.float64)
        if not self.at_estimate:
            for state, (k, factor) in self._seen.items():
                point[state] = np.asarray(measured)[k] / factor
        return self.feedback.memberships(self.feedback.state_rest + point)

    def command(self, estimate: ArrayLike, measured: ArrayLike) -> Floats:
        """Return u (m,) for s (n,) and y - y* (p,), SI; see the module."""
        s = np.asarray(estimate, dtype=np.float64)
        K = np.tensordot(self.memberships(s, measured), self.feedback.gains, axes=1)
        return np.asarray(self.feedback.input_rest - K @ s, dtype=np.float64)

    def following(self, estimate: ArrayLike, measured: ArrayLike, sent: ArrayLike) -> Floats:
        """Return s' (s(t + T) in discrete time), (n,).

        Parameters
        ----------
        estimate, measured : s (n,) and y - y* (p,).
        sent : u (m,), the command that the plant gets.
        """
        s, y = (np.asarray(v, dtype=np.float64) for v in (estimate, measured))
        u = np.asarray(sent, dtype=np.float64) - self.feedback.input_rest
        h = self.memberships(s, y)
        model, rows = self.model, list(self.rows)
        stacks = (model.A, model.B, model.C[:, rows], model.D[:, rows], self.L)
        A, B, C, D, L = (np.tensordot(h, stack, axes=1) for stack in stacks)
        return np.asarray(A @ s + B @ u + L @ (y - C @ s - D @ u), dtype=np.float64)


def seen_directly(model: TSModel, rows: Sequence[int]) -> dict[int, tuple[int, float]]:
    """Return state -> (measured output, factor) for each output that is a factor times one state.

    Parameters
    ----------
    rows : indices of the measured outputs among the outputs of the model.
    """
    found = {}
    for k, row in enumerate(rows):
        C, D = model.C[:, row], model.D[:, row]
        places = np.flatnonzero(np.any(C != 0, axis=0))
        if len(places) == 1 and np.all(C == C[0]) and not np.any(D):
            state = int(places[0])
            found[state] = (k, float(C[0, state]))
    return found
