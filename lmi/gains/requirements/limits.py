"""Limits of a design as LMIs.

Limits hold on the ellipsoid x' P x <= 1: inputs and states on it, initial states inside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import positive_number, positive_vector
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.statements import lmi_of
from takagi.lmi.condition.term import LMI, Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import block, matrix
from takagi.models.errors import ModelError

MOST_CORNERS = 4096
# Margin of a limit for a margin 1 of Q, in states and inputs of order one.
LIMIT_WEIGHT = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Limits in the coordinates of the condition; None where none exists.

    inputs : (m,), |K_i x|_k <= inputs_k on the ellipsoid.
    initial : (points, n), all inside the ellipsoid.
    states : (n,), |x_k| <= states_k on the ellipsoid; inf for no limit.
    gain : spectral norm of K_i in the model's units.
    state_units, input_units : (n,), (m,) of the coordinates, x = s xhat, u = tau uhat.
    """

    inputs: Array | None
    initial: Array | None
    states: Array | None
    gain: float | None
    state_units: Array
    input_units: Array

    @property
    def level(self) -> bool:
        """Return whether the size of the ellipsoid matters, not only its shape."""
        return any(limit is not None for limit in (self.inputs, self.states, self.initial))

    def scaled(self, s: Array, tau: Array) -> Limits:
        """Return the limits in the coordinates x = s xhat, u = tau uhat."""
        return Limits(
            None if self.inputs is None else self.inputs / tau,
            None if self.initial is None else self.initial / s,
            None if self.states is None else self.states / s,
            self.gain,
            self.state_units * s,
            self.input_units * tau,
        )


def limits_of(
    n: int,
    m: int,
    *,
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
) -> Limits:
    """Return checked limits in the model's own units.

    Raises ModelError: lengths, entries that are not positive, an initial box outside the state box.
    """
    inputs = None if input_limit is None else positive_vector("input_limit", input_limit, m)
    initial = None if initial_box is None else _initial(initial_box, n)
    states = None
    if state_box is not None:
        states = np.asarray(state_box, dtype=np.float64)
        finite = positive_vector("state_box", np.where(np.isposinf(states), 1.0, states), n)
        states = np.where(np.isposinf(np.broadcast_to(states, (n,))), np.inf, finite)
    if initial is not None and states is not None and np.any(initial >= states):
        k = int(np.argmax(initial / states))
        raise ModelError(
            f"state {k + 1}: the initial box reaches to {initial[k]:g}, the state box only to "
            f"{states[k]:g}; an ellipsoid between them needs the first to be smaller"
        )
    gain = None if gain_bound is None else positive_number("gain_bound", gain_bound)
    points = None if initial is None else corners_of_box(initial)
    return Limits(inputs, points, states, gain, np.ones(n), np.ones(m))


def _initial(half_widths: ArrayLike, n: int) -> Array:
    """Return half-widths, (n,): positive, or 0 for a state that starts at rest, but not all."""
    try:
        at_rest = np.asarray(half_widths, dtype=np.float64) == 0
    except (TypeError, ValueError):
        at_rest = np.zeros(n, dtype=bool)
    if at_rest.shape != (n,) or at_rest.all():
        return positive_vector("initial_box", half_widths, n)
    return np.where(
        at_rest, 0.0, positive_vector("initial_box", np.where(at_rest, 1.0, half_widths), n)
    )


def input_lmis(
    Q: Unknown, M: Unknown, limit: Array, *, name: str = "input limit", symbol: str = r"\bar u"
) -> tuple[LMI, ...]:
    """Pose [[u_k^2, m_k], [m_k', Q]] > 0, m_k row k of M_i: |K_i x|_k <= u_k where x' P x <= 1.

    By convexity every blend of the gains then keeps the limit too.

    ``limit`` : (m,).
    ``name``, ``symbol`` : of the LMI and of its limit, in LaTeX; two LMIs of one name in a
    condition would share their multipliers.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.2.3.
    """
    m, r = M.rows, M.count
    rule, k = np.divmod(np.arange(r * m), m)
    e_k = matrix(np.eye(m)[k][:, None, :], r"e_k^\top")
    bound = matrix((limit**2)[k][:, None, None], rf"{symbol}_k^2")
    lmi = block([[bound, e_k @ M.members(rule, f"{M.symbol}_i")], [None, Q]]) >> 0
    ranges = [rf"i = 1, \dots, {r}"] * (r > 1) + [rf"k = 1, \dots, {m}"] * (m > 1)
    labels = tuple(
        f"{name.replace('input ', '')} of input {b + 1}, rule {a + 1}"
        for a, b in zip(rule, k, strict=True)
    )
    return (lmi_of(lmi.named(name, r",\; ".join(ranges), weight=LIMIT_WEIGHT, labels=labels)),)


def initial_lmis(Q: Unknown, points: Array) -> tuple[LMI, ...]:
    """Pose [[1, x0'], [x0, Q]] > 0: the point x0 lies in x' P x <= 1."""
    lmi = block([[np.eye(1), matrix(points[:, None, :], r"x_0^\top")], [None, Q]]) >> 0
    index = r"x_0 \text{ a corner of the initial box}"
    return (lmi_of(lmi.named("initial state", index, weight=LIMIT_WEIGHT)),)


def state_lmis(Q: Unknown, box: Array) -> tuple[LMI, ...]:
    """Pose Q_kk < b_k^2: |x_k| <= b_k where x' P x <= 1."""
    k = np.flatnonzero(np.isfinite(box))
    if not len(k):
        return ()
    e_k = matrix(np.eye(Q.rows)[k][:, :, None], "e_k")
    lmi = e_k.T @ Q @ e_k << matrix((box[k] ** 2)[:, None, None], r"\bar x_k^2")
    labels = tuple(f"box of state {a + 1}" for a in k)
    index = r"k \text{ with a limit}"
    return (lmi_of(lmi.named("state box", index, weight=LIMIT_WEIGHT, labels=labels)),)


def row_lmis(Q: Unknown, rows: Array, limit: Array, *, name: str) -> tuple[LMI, ...]:
    """Pose c_t Q c_t' < b_t^2: |c_t x| <= b_t where x' P x <= 1, for known rows c_t.

    ``rows`` : (T, n), e.g. the rows of known gains.
    ``limit`` : (T,) b.
    """
    c_t = matrix(rows[:, None, :], "c_t")
    lmi = c_t @ Q @ c_t.T << matrix((limit**2)[:, None, None], "b_t^2")
    return (lmi_of(lmi.named(name, rf"t = 1, \dots, {len(rows)}", weight=LIMIT_WEIGHT)),)


def gain_lmis(
    Q: Unknown, M: Unknown, limits: Limits
) -> tuple[tuple[Unknown, ...], tuple[LMI, ...]]:
    """Pose q I < Q and [[Q, M_i'], [M_i, g^2 q I]] > 0, which give |K_i| <= g.

    K Q K' <= g^2 q I and Q >= q I leave K K' <= g^2 I.  Sufficient, not necessary.  I stands for
    the identity in the model's units: diag(s)^-2 and diag(tau)^-2 in scaled ones.
    """
    assert limits.gain is not None
    q = Unknown("q", 1, 1)
    states = matrix(np.diag(limits.state_units**-2.0), "I")
    inputs = matrix(np.diag(limits.input_units**-2.0) * limits.gain**2, "g^2 I")
    rules = np.arange(M.count)
    M_i = M.members(rules, f"{M.symbol}_i")
    bound = (block([[Q, None], [M_i, q * inputs]]) >> 0).named(
        "gain bound",
        rf"i = 1, \dots, {M.count}",
        weight=LIMIT_WEIGHT,
        labels=tuple(f"gain bound, rule {k + 1}" for k in rules),
    )
    return (q,), (lmi_of((Q - q * states >= 0).named("Q above q")), lmi_of(bound))


def corners_of_box(box: Array) -> Array:
    """Return (k, n), of every pair of opposite corners one; half-widths may be 0, but not all.

    Raises
    ------
    ModelError : more corners than LMIs that can be solved.
    """
    some = np.flatnonzero(box)
    if 2 ** (len(some) - 1) > MOST_CORNERS:
        raise ModelError(
            f"initial_box: {len(some)} states have {2 ** len(some)} corners, more than "
            f"{2 * MOST_CORNERS}; leave it out, or give limits for fewer states"
        )
    # A corner and its opposite are in the ellipsoid together.
    signs = np.array(
        [(1.0, *signs_behind) for signs_behind in product((1.0, -1.0), repeat=len(some) - 1)]
    )
    corners = np.zeros((len(signs), len(box)))
    corners[:, some] = signs * box[some]
    return corners


def limit_lmis(
    Q: Unknown, M: Unknown, limits: Limits | None
) -> tuple[tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return the LMIs, and their own unknowns, of all limits that there are."""
    if limits is None:
        return (), ()
    unknowns: tuple[Unknown, ...] = ()
    lmis: tuple[LMI, ...] = ()
    if limits.inputs is not None:
        lmis += input_lmis(Q, M, limits.inputs)
    if limits.initial is not None:
        lmis += initial_lmis(Q, limits.initial)
    if limits.states is not None:
        lmis += state_lmis(Q, limits.states)
    if limits.gain is not None:
        unknowns, bounds = gain_lmis(Q, M, limits)
        lmis += bounds
    return unknowns, lmis


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GivenLimits:
    """Limits in the model's units, not checked yet; None where nothing is asked.

    The members are those arguments of ``pdc`` that have the same names.

    Raises ModelError: a region that is none.
    """

    input_limit: ArrayLike | None = None
    initial_box: ArrayLike | None = None
    state_box: ArrayLike | None = None
    gain_bound: float | None = None
    scales: ArrayLike | None = None
    sample_time: float | None = None
    region: EigenvalueRegion | None = None

    def limits(self, n: int, m: int) -> Limits:
        """Return the checked limits on n states, m inputs and the gains, as ``limits_of``."""
        return limits_of(
            n,
            m,
            input_limit=self.input_limit,
            initial_box=self.initial_box,
            state_box=self.state_box,
            gain_bound=self.gain_bound,
        )

    def __post_init__(self) -> None:
        if self.region is not None and not isinstance(self.region, EigenvalueRegion):
            raise ModelError(
                f"region is {self.region!r}; an EigenvalueRegion is needed, e.g. "
                "EigenvalueRegion.disc(5.0)"
            )
