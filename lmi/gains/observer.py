r"""Observer gains: the dual of parallel distributed compensation.

With measured premises both plant and observer blend with the same h, and e = x - xhat obeys

    e' = sum_ij h_i h_j (A_i - L_j C_i) e,    in discrete time e+ = ...

Where the right-hand side has a part f(x) that depends on what is not measured, it does not cancel:
f(x) - f(xhat) = S e with the secant S(x, xhat), row by row a gradient of f between x and xhat (mean
value theorem).  With S in the hull of S_1 ... S_s,

    e' = sum_i h_i sum_k g_k (A_i + S_k - L C_i) e,     g unknown, so one L for all.

No bound on the error is needed, nor a small-gain argument; but the hull is that of derivatives of
f, not that of the factors F of f(x) = F(x) x, which is smaller and proves nothing here.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import (
    check_stabilisable,
    input_stack,
    positive_vector,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.cone.balance import balanced_inputs, state_units
from takagi.lmi.gains.decay.condition import pdc_condition
from takagi.lmi.gains.decay.pdc import pdc
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

MOST_ENTRIES = 12


def secant_vertices(low: ArrayLike, high: ArrayLike) -> Floats:
    """Return S_k, (2^v, n, n), whose hull has every S with f(x) - f(y) = S (x - y).

    low_ij <= df_i/dx_j <= high_ij on a convex set with x and y in it.  Row i of S is the gradient
    of f_i somewhere between x and y (mean value theorem), so S lies between low and high, entry
    by entry; the S_k are the combinations of the ends of the v entries that differ.

    Raises
    ------
    ModelError : shapes, entries that are not finite or out of order, more than 12 that differ.
    """
    try:
        ends = [np.asarray(side, dtype=np.float64) for side in (low, high)]
    except (TypeError, ValueError) as error:
        raise ModelError(f"low or high cannot be read as real numbers ({error})") from error
    if ends[0].ndim != 2 or ends[0].shape != ends[1].shape or ends[0].shape[0] != ends[0].shape[1]:
        raise ModelError(
            f"low has shape {ends[0].shape}, high {ends[1].shape}; both must be (n, n)"
        )
    wrong = ~(np.isfinite(ends[0]) & np.isfinite(ends[1]) & (ends[0] <= ends[1]))
    if wrong.any():
        i, j = (int(k) for k in np.argwhere(wrong)[0])
        raise ModelError(
            f"entry [{i}, {j}]: low is {ends[0][i, j]:g}, high is {ends[1][i, j]:g}; finite ends, "
            "the lower one first, are needed"
        )
    varying = np.argwhere(ends[0] < ends[1])
    if len(varying) > MOST_ENTRIES:
        raise ModelError(
            f"{len(varying)} entries vary, which is 2^{len(varying)} vertices; fix the narrow "
            f"ones in the middle, or give fewer vertices yourself; {MOST_ENTRIES} may vary"
        )
    S = np.repeat(ends[0][None], 2 ** len(varying), axis=0)
    for k, corner in enumerate(product((0, 1), repeat=len(varying))):
        for (i, j), end in zip(varying, corner, strict=True):
            S[k, i, j] = ends[end][i, j]
    return S


class Measured(Protocol):
    """What observer reads of a model: A (r, n, n) and C (r, p, n)."""

    @property
    def A(self) -> Array: ...

    @property
    def C(self) -> Array: ...


class _Dual:
    """The model with A' and C' in the places of A and B, one vertex for each secant."""

    def __init__(
        self, model: Measured, unmeasured: ArrayLike | None, sample_time: float | None
    ) -> None:
        A = vertex_stack(model)
        B = input_stack(model, A, "C")
        self.sample_time = sample_time_of(model, sample_time)
        if unmeasured is None:
            self.premises = tuple(getattr(model, "premises", ()))
            self.rules = tuple(getattr(model, "rules", ()))
        else:
            S = _secants(unmeasured, A.shape[1])
            A = (A[:, None] + S).reshape(-1, *A.shape[1:])
            B = np.repeat(B, len(S), axis=0)
            self.premises, self.rules = (), ()
        self.A, self.B = A.transpose(0, 2, 1), B


def _secants(unmeasured: ArrayLike, n: int) -> Array:
    """Return S, (s, n, n)."""
    S = vertex_stack(unmeasured)
    if S.shape[1] != n:
        raise ModelError(
            f"unmeasured has shape {S.shape}, the model has {n} states; vertices (s, {n}, {n}) of "
            "the secants are needed"
        )
    return S


def _relaxation(name: str | None, unmeasured: ArrayLike | None) -> str:
    """Return the relaxation's name, which secants leave no choice of."""
    if unmeasured is None:
        return "wang-tanaka-griffin" if name is None else name
    if name not in (None, "common-gain"):
        raise ModelError(
            f"relaxation {name!r} was asked for with unmeasured secants; the gain cannot depend "
            'on what is not measured: leave relaxation out, or give "common-gain"'
        )
    return "common-gain"


def observer_condition(
    model: Measured,
    *,
    decay_rate: float = 0.0,
    relaxation: str | None = None,
    unmeasured: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j (He(P A_i - N_j C_i) + 2 alpha P) < 0 as PDC of A', C': N_j = M_j'.

    The condition's Q is P itself, its M_j are N_j' = (P L_j)'.  Nothing is solved.

    Parameters
    ----------
    model, decay_rate, relaxation, unmeasured, sample_time : as for ``observer``.

    Raises
    ------
    ModelError : shapes, entries that are not finite, an unknown relaxation.

    Source: Tanaka and Wang (2001), section 4.2.
    """
    name = _relaxation(relaxation, unmeasured)
    dual = _Dual(model, unmeasured, sample_time)
    return pdc_condition(dual, decay_rate=decay_rate, relaxation=name)


@limited
def observer(
    model: Measured,
    *,
    decay_rate: float = 0.0,
    relaxation: str | None = None,
    gain_bound: float | None = None,
    unmeasured: ArrayLike | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Design:
    """Return gains L_i, (r, n, p), for xhat' = sum_i h_i (A_i xhat + B_i u + L_i (y - yhat)).

    The error e = x - xhat obeys e' = sum_ij h_i h_j (A_i - L_j C_i) e, and V = e' P e decays as
    V' <= -2 alpha V.  In discrete time xhat+ stands for xhat', and V+ <= e^(-2 alpha T) V.

    With ``unmeasured`` the plant is x' = sum_i h_i (A_i x + B_i u) + f(x), h measured, f not, and
    the observer has f(xhat) too.  One gain L serves all rules and every secant of f.

    Parameters
    ----------
    model : A (r, n, n) and C (r, p, n).
    decay_rate, gain_bound : as for ``pdc``.
    relaxation : as for ``pdc``; None takes all pairs, or "common-gain" with ``unmeasured``.  A
        model all of whose premises are unmeasured, but which is one of the error already (as
        ``wind_observer_model``), needs "common-gain".
    unmeasured : S_k, (s, n, n), whose hull has every secant of f: f(x) - f(xhat) = S (x - xhat);
        ``secant_vertices`` gives them from bounds on the derivatives of f.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x; None takes the model's own.
    time_limit : seconds for all solver calls; "unknown" when they are over.  None for no limit.

    Not promised: anything when the memberships depend on what is not measured and ``unmeasured``
    does not say so; nor where x or xhat leaves the set on which the secants were bounded.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, outputs that are dependent or show
        nothing, a vertex with an unstable mode that no output shows.

    Source: Tanaka and Wang (2001), section 4.2; with secants derived in the module.
    """
    name = _relaxation(relaxation, unmeasured)
    if name != "auto":
        relaxation_named(name)
    dual = _Dual(model, unmeasured, sample_time)
    n = dual.A.shape[1]
    _check_detectable(dual, tuple(getattr(model, "states", ())))
    design = pdc(
        dual,
        decay_rate=decay_rate,
        relaxation=name,
        gain_bound=gain_bound,
        scales=None if scales is None else 1.0 / positive_vector("scales", scales, n),
    )
    if design.gains is None or design.P is None:
        diagnosis = design.answer.diagnosis.replace("no input moves", "no output shows")
        return replace(design, answer=replace(design.answer, diagnosis=diagnosis))
    P = np.linalg.inv(design.P)
    P = (P + P.T) / 2
    P /= np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    rules = len(vertex_stack(model))
    return replace(
        design,
        gains=design.gains.transpose(0, 2, 1)[:rules].copy(),
        P=P,
        answer=replace(design.answer, P=P),
    )


def _check_detectable(dual: _Dual, names: tuple[str, ...]) -> None:
    A, B = dual.A.astype(np.float64), dual.B.astype(np.float64)
    s = state_units(A, None, step=dual.sample_time)
    A, B = A * s / s[:, None], B / s[:, None]
    B = B * balanced_inputs(B, vertex_weight(A))
    check_stabilisable(A, B, units=s, names=names, dual=True, step=dual.sample_time)
