"""Observer gains: the dual of parallel distributed compensation."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.quadratic import vertex_weight
from takagi.lmi.answer import Design
from takagi.lmi.intake import check_stabilisable, input_stack, positive_vector, vertex_stack
from takagi.lmi.solver.balance import balanced_inputs, balanced_states
from takagi.lmi.synthesis.compensation import pdc
from takagi.lmi.synthesis.compensation_condition import pdc_condition
from takagi.lmi.synthesis.relaxations import relaxation_named
from takagi.lmi.term import Array, Condition

__all__ = ["Measured", "observer", "observer_condition"]


class Measured(Protocol):
    """What observer reads of a model: A (r, n, n) and C (r, p, n)."""

    @property
    def A(self) -> Array: ...

    @property
    def C(self) -> Array: ...


class _Dual:
    """The model with A' and C' in the places of A and B."""

    def __init__(self, model: Measured) -> None:
        A = vertex_stack(model)
        self.A, self.B = A.transpose(0, 2, 1), input_stack(model, A, "C")


def observer_condition(
    model: Measured, *, decay_rate: float = 0.0, relaxation: str = "wang-tanaka-griffin"
) -> Condition:
    """Pose sum_ij h_i h_j (He(P A_i - N_j C_i) + 2 alpha P) < 0 as PDC of A', C': N_j = M_j'.

    The condition's Q is P itself, its M_j are N_j' = (P L_j)'.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, an unknown relaxation.

    Source: Tanaka and Wang (2001), section 4.2.
    """
    return pdc_condition(_Dual(model), decay_rate=decay_rate, relaxation=relaxation)


def observer(
    model: Measured,
    *,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    gain_bound: float | None = None,
    scales: ArrayLike | None = None,
) -> Design:
    """Return gains L_i, (r, n, p), for xhat' = sum_i h_i (A_i xhat + B_i u + L_i (y - yhat)).

    The error e = x - xhat obeys e' = sum_ij h_i h_j (A_i - L_j C_i) e, and V = e' P e decays as
    V' <= -2 alpha V.

    Parameters
    ----------
    model : A (r, n, n) and C (r, p, n).
    decay_rate, relaxation, gain_bound : as for ``pdc``.
    scales : (n,) engineering range of each state; None balances.

    Not promised: anything when the memberships depend on what is not measured; the error then
    has further terms.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, outputs that are dependent or show
        nothing, a vertex with an unstable mode that no output shows.

    Source: Tanaka and Wang (2001), section 4.2.
    """
    relaxation_named(relaxation)
    dual = _Dual(model)
    n = dual.A.shape[1]
    _check_detectable(dual, tuple(getattr(model, "states", ())))
    design = pdc(
        dual,
        decay_rate=decay_rate,
        relaxation=relaxation,
        gain_bound=gain_bound,
        scales=None if scales is None else 1.0 / positive_vector("scales", scales, n),
    )
    if design.gains is None or design.P is None:
        said = design.answer.diagnosis.replace("no input moves", "no output shows")
        return replace(design, answer=replace(design.answer, diagnosis=said))
    P = np.linalg.inv(design.P)
    P = (P + P.T) / 2
    P /= np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    return replace(
        design,
        gains=design.gains.transpose(0, 2, 1).copy(),
        P=P,
        answer=replace(design.answer, P=P),
    )


def _check_detectable(dual: _Dual, names: tuple[str, ...]) -> None:
    A, B = dual.A.astype(np.float64), dual.B.astype(np.float64)
    s = balanced_states(A)
    A, B = A * s / s[:, None], B / s[:, None]
    B = B * balanced_inputs(B, vertex_weight(A))
    check_stabilisable(A, B, units=s, names=names, dual=True)
