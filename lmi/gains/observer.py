r"""Observer gains: the dual of parallel distributed compensation.

With measured premises both plant and observer blend with the same h, and e = x - xhat obeys

    e' = sum_ij h_i h_j (A_i - L_j C_i) e,    in discrete time e+ = ...
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import (
    input_stack,
    positive_vector,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.gains.decay.condition import pdc_condition
from takagi.lmi.gains.decay.pdc import pdc
from takagi.lmi.gains.requirements.closed_loop import check_stabilisable


class Measured(Protocol):
    """What observer reads of a model: A (r, n, n) and C (r, p, n)."""

    @property
    def A(self) -> Array: ...

    @property
    def C(self) -> Array: ...


class _Dual:
    """The model with A' and C' in the places of A and B."""

    def __init__(self, model: Measured, sample_time: float | None) -> None:
        A = vertex_stack(model)
        self.A, self.B = A.transpose(0, 2, 1), input_stack(model, A, "C")
        self.sample_time = sample_time_of(model, sample_time)
        self.premises = tuple(getattr(model, "premises", ()))
        self.rules = tuple(getattr(model, "rules", ()))


def observer_condition(
    model: Measured,
    *,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j (He(P A_i - N_j C_i) + 2 alpha P) < 0 as PDC of A', C': N_j = M_j'.

    The condition's Q is P itself, its M_j are N_j' = (P L_j)'.  Nothing is solved; parameters as
    for ``observer``.

    Raises ModelError: shapes, entries that are not finite, an unknown relaxation.

    Source: Tanaka and Wang (2001), section 4.2.
    """
    dual = _Dual(model, sample_time)
    return pdc_condition(dual, decay_rate=decay_rate, relaxation=relaxation)


def observer(
    model: Measured,
    *,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    gain_bound: float | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Design:
    """Return gains L_i, (r, n, p), for xhat' = sum_i h_i (A_i xhat + B_i u + L_i (y - yhat)).

    The error e = x - xhat obeys e' = sum_ij h_i h_j (A_i - L_j C_i) e, and V = e' P e decays as
    V' <= -2 alpha V.  In discrete time xhat+ stands for xhat', and V+ <= e^(-2 alpha T) V.

    Parameters
    ----------
    model : A (r, n, n) and C (r, p, n).
    decay_rate, gain_bound : as for ``pdc``.
    relaxation : as for ``pdc``.  A model of the error whose premises are not measured (as
        ``wind_observer_model``, or A_i + S_k with secants S_k of what is not measured) needs
        "common-gain".
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x; None takes the model's own.

    Not promised: anything when the memberships depend on what is not measured.

    Raises ModelError: shapes, numbers, an unknown relaxation, outputs that are dependent or show
    nothing, a vertex with an unstable mode that no output shows.

    Source: Tanaka and Wang (2001), section 4.2.
    """
    dual = _Dual(model, sample_time)
    n = dual.A.shape[1]
    names, step = getattr(model, "states", ()), dual.sample_time
    check_stabilisable(dual.A, dual.B, names=names, dual=True, step=step)
    design = pdc(
        dual,
        decay_rate=decay_rate,
        relaxation=relaxation,
        gain_bound=gain_bound,
        scales=None if scales is None else 1.0 / positive_vector("scales", scales, n),
    )
    if design.gains is None or design.P is None:
        diagnosis = design.answer.diagnosis.replace("no input moves", "no output shows")
        return replace(design, answer=replace(design.answer, diagnosis=diagnosis))
    P = np.linalg.inv(design.P)
    P = (P + P.T) / 2
    P /= np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    return replace(
        design,
        gains=design.gains.transpose(0, 2, 1).copy(),
        P=P,
        answer=replace(design.answer, P=P),
    )
