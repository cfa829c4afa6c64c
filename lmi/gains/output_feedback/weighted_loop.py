r"""Mixed sensitivity: the controller with the least norm of [W1 S; W2 K S; W3 T].

With e = r - y, u = K e, y = G u, the sensitivity is S = (I + G K)^-1 and T = I - S.  W1 asks for
a small error where it is large, W2 limits the input, W3 the bandwidth:

    || [ W1 S ; W2 K S ; W3 T ] ||_inf  =  gamma,     least over all K that stabilise the loop.

Source: Skogestad and Postlethwaite (2005), Multivariable Feedback Control, 2nd edition, sections
2.8.3 and 9.3.5; Kwakernaak (1993), Automatica 29.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from takagi.lmi.gains.output_feedback.controller import (
    ABOVE,
    OutputFeedback,
    hinf_output_feedback,
)
from takagi.lmi.gains.output_feedback.generalised_plant import (
    GeneralisedPlant,
    StateSpace,
    state_space,
)
from takagi.models.errors import ModelError


def mixed_sensitivity(
    plant: Any,
    W1: Any = None,
    W2: Any = None,
    W3: Any = None,
    *,
    tolerance: float = ABOVE,
    time_limit: float | None = None,
) -> OutputFeedback:
    """Return the controller u = K(s) (r - y) with the least norm of [W1 S; W2 K S; W3 T].

    Parameters
    ----------
    plant : G, strictly proper: a transfer function or state space of python-control, or (A, B, C,
        D); p outputs, m inputs, in continuous time.
    W1, W2, W3 : weights of r - y (p columns), of u (m columns) and of y (p columns): as the plant,
        or a number for that number in every channel; at least one.  Stable and proper.
    tolerance : how far above the least gamma the controller may be, relative.
    time_limit : seconds for all solver calls together.

    Returns
    -------
    An ``OutputFeedback``: ``controller`` from e = r - y to u, of the order of plant and weights
    together, and ``gain``, gamma, recomputed from the closed loop.

    Raises
    ------
    ModelError : no weight, systems that do not fit, of discrete time or improper; a plant with a
        direct term, a weight that is not stable.

    Source: Skogestad and Postlethwaite (2005), sections 2.8.3 and 9.3.5.
    """
    G = state_space("the plant", plant)
    if not G.order or G.D.any():
        raise ModelError(
            "the plant has a direct term from u to y, or no states; a strictly proper plant is "
            "needed: put the actuator's or the sensor's lag into it"
        )
    p, m = G.D.shape
    weights = {"W1": (W1, p), "W2": (W2, m), "W3": (W3, p)}
    given = {
        name: _weight(name, weight, width)
        for name, (weight, width) in weights.items()
        if weight is not None
    }
    if not given:
        raise ModelError("no weight was given; give at least one of W1, W2, W3")
    return hinf_output_feedback(augmented(G, given), tolerance=tolerance, time_limit=time_limit)


def augmented(G: StateSpace, weights: dict[str, StateSpace]) -> GeneralisedPlant:
    """Return the generalised plant: w = r, z the weighted signals, y the error e = r - G u."""
    n, (p, m) = G.order, G.D.shape
    # The input of each weight, as rows over x, r and u.
    sees = {
        "W1": (-G.C, np.eye(p), np.zeros((p, m))),
        "W2": (np.zeros((m, n)), np.zeros((m, p)), np.eye(m)),
        "W3": (G.C, np.zeros((p, p)), np.zeros((p, m))),
    }
    orders = [weight.order for weight in weights.values()]
    total = n + sum(orders)
    A, B1, B2 = np.zeros((total, total)), np.zeros((total, p)), np.zeros((total, m))
    A[:n, :n], B2[:n] = G.A, G.B
    C1, D11, D12 = [], [], []
    start = n
    for name, weight in weights.items():
        x, r, u = sees[name]
        own = slice(start, start + weight.order)
        A[own, :n], A[own, own] = weight.B @ x, weight.A
        B1[own], B2[own] = weight.B @ r, weight.B @ u
        rows = np.zeros((len(weight.D), total))
        rows[:, :n], rows[:, own] = weight.D @ x, weight.C
        C1.append(rows)
        D11.append(weight.D @ r)
        D12.append(weight.D @ u)
        start += weight.order
    C2 = np.zeros((p, total))
    C2[:, :n] = -G.C
    return GeneralisedPlant(
        A=A,
        B1=B1,
        B2=B2,
        C1=np.vstack(C1),
        C2=C2,
        D11=np.vstack(D11),
        D12=np.vstack(D12),
        D21=np.eye(p),
    )


def _weight(name: str, weight: Any, width: int) -> StateSpace:
    found = state_space(name, weight)
    if found.D.shape == (1, 1) and width > 1:
        parts = (found.A, found.B, found.C, found.D)
        found = StateSpace(*(np.asarray(np.kron(np.eye(width), M), np.float64) for M in parts))
    if found.D.shape[1] != width:
        raise ModelError(
            f"{name} has {found.D.shape[1]} inputs; {width} are needed, or one for a weight that "
            "is the same in every channel"
        )
    if found.order and np.linalg.eigvals(found.A).real.max() >= 0:
        raise ModelError(
            f"{name} has a pole at {np.linalg.eigvals(found.A).real.max():g}; a stable weight is "
            "needed: move an integrator a little to the left, s + 1e-4 for s"
        )
    return found
