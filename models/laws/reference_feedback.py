r"""A law with references and measured outputs: integrals, and an observer with constant matrices.

    u = u* - K_x s - K_xi xi,     s' = A s + B (u - u*) + L (y - y* - C s),     xi' = h(y) - r

s estimates the deviations of the plant's own states.  For callers that know an observer of all
states (``takagi.models.laws.pdc.OutputFeedback``) the estimate has a row for every state, 0 for the
integrals, which the law has itself and which stand behind the outputs in what it knows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.laws.pdc import PdcLaw
from takagi.models.tracking import ConstantObserver
from takagi.models.ts.model import TSModel


@dataclass(frozen=True, eq=False)
class ReferenceFeedback:
    """The law of the module.

    Attributes
    ----------
    feedback : K with model and rests; the columns of own states are those of the estimate.
    observer : its matrices.
    rows : indices of the measured outputs among the outputs of the model.
    states : places of the states that are estimated.
    """

    feedback: PdcLaw
    observer: ConstantObserver
    rows: tuple[int, ...]
    states: tuple[int, ...]
    at_estimate: ClassVar[bool] = False

    @property
    def model(self) -> TSModel:
        return self.feedback.model

    @property
    def sample_time(self) -> float | None:
        """None: the law is of continuous time."""
        return self.model.sample_time

    @property
    def integrals(self) -> list[int]:
        """Places of the states that the law has itself."""
        return [k for k in range(len(self.model.states)) if k not in self.states]

    @property
    def L(self) -> Floats:
        """(1, n, p), with rows of 0 for the integrals."""
        gains = np.zeros((1, len(self.model.states), len(self.rows)))
        gains[0, list(self.states)] = self.observer.L
        return gains

    def command(self, estimate: ArrayLike, measured: ArrayLike) -> Floats:
        """Return u (m,) for the estimate (n,) and what is known: y - y* (p,), then xi."""
        z = np.array(estimate, dtype=np.float64)
        z[self.integrals] = np.asarray(measured)[len(self.rows) :]
        return np.asarray(self.feedback.input_rest - self.feedback.gains[0] @ z, dtype=np.float64)

    def following(self, estimate: ArrayLike, measured: ArrayLike, sent: ArrayLike) -> Floats:
        """Return the rate of the estimate (n,); ``sent`` is u (m,) as the plant gets it."""
        observer, rates = self.observer, np.zeros(len(self.model.states))
        s = np.asarray(estimate, dtype=np.float64)[list(self.states)]
        u = np.asarray(sent, dtype=np.float64) - self.feedback.input_rest
        gap = np.asarray(measured, dtype=np.float64)[: len(self.rows)] - observer.C @ s
        rates[list(self.states)] = observer.A @ s + observer.B @ u + observer.L @ gap
        return rates

    def linear(self, H: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, G, K of z' = F z + G (y - y*), u - u* = -K z, z = (xi, s) as the states.

        Parameters
        ----------
        H : (q, p), the slopes of what follows by y.
        """
        observer, K, n = self.observer, self.feedback.gains[0], len(self.model.states)
        F, G = np.zeros((n, n)), np.zeros((n, len(self.rows)))
        states = list(self.states)
        F[states] = -observer.B @ K
        F[np.ix_(states, states)] += observer.A - observer.L @ observer.C
        G[states], G[self.integrals] = observer.L, H
        return F, G, K
