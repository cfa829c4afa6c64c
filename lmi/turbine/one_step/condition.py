r"""LMIs of one step that changes the quadratic function, the gains and the wind class together.

The loop's corners A, d are linearised in the logarithms u of the gains (``loop_of_gains``), with
d = fixed + s_k error, where s_k is the multiple of the wind error that cell k tolerates.  In
coordinates where the present function is |x|^2 and P = I + X, a corner of cell k with multiplier
alpha_k (1 + a_k) and multiple s_k (1 + c_k) satisfies the invariance inequality if

    [ He(P (A + dA(u))) + alpha (1 + a) P     P (d + dd(u) + s c error) ]
    [ .                                      -alpha (1 + a)             ]  < 0 .

Let W = [dA(u) + alpha a I / 2,  dd(u) + s c error] and E = [I, 0]'.  Except for the products u c,
the part that is not linear in the unknowns is He(E X W), and for any t > 0

    He(E X W) = |t X E' + W / t|^2 / 2 - |t X E' - W / t|^2 / 2  <=  |t X E' + W / t|^2 / 2 :

By the Schur complement the last expression is a block row [t X E' + W / t] with -2 I on the
diagonal.  A solution of these LMIs satisfies the inequality above.  The present function and gains
satisfy the LMIs, so within the linearisation a step never makes the objective worse.  The LMI for
the decay rate d of a function R is the same without the column of d, with alpha = 2 d for all
cells.

Source: derived here; Dinh, Gumussoy, Michiels, Diehl (2012), IEEE Trans. Automatic Control 57(6),
for the convex-concave decomposition of bilinear matrix inequalities; Boyd, El Ghaoui, Feron,
Balakrishnan (1994), section 6.1.3, for the invariant set.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.condition.statements import lmi_of
from takagi.lmi.condition.term import LMI
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, added, block, identity, matrix, symmetric_block
from takagi.lmi.turbine.one_step.loop_of_gains import MovingCorners, WindCellCorners
from takagi.models.arrays import Floats, Indices

EYE = np.eye(3)[None]


@dataclass(frozen=True, slots=True, eq=False)
class Around:
    """Corners in coordinates where the present function is |x|^2.

    Attributes
    ----------
    moving : corners and their secants; the secants are zero when the gains are fixed.
    speed : (N,) alpha of each corner, or 2 d [1/s].
    scale : (N,) s of each corner.
    pace : (N,) index of the unknown that is the relative change of a corner's ``speed``.
    disturbed : whether the LMI contains the disturbance column d.
    """

    moving: MovingCorners
    speed: Floats
    scale: Floats
    pace: Indices
    disturbed: bool

    @classmethod
    def of(
        cls,
        moving: MovingCorners,
        T: Floats,
        speed: Floats,
        scale: Floats,
        pace: Indices,
        *,
        disturbed: bool,
    ) -> Around:
        """Return corners for x = T xhat."""
        inverse, at = np.linalg.inv(T), moving.at
        posed = MovingCorners(
            WindCellCorners(
                inverse @ at.A @ T, at.fixed @ inverse.T, at.error @ inverse.T, at.cell
            ),
            moving.members,
            inverse @ moving.A @ T,
            moving.fixed @ inverse.T,
            moving.error @ inverse.T,
        )
        return cls(posed, speed, scale, pace, disturbed)

    @property
    def d(self) -> Floats:
        """Return (N, 3): the disturbance d at the present gains and multiples."""
        at = self.moving.at
        return np.asarray(at.fixed + self.scale[:, None] * at.error)

    @property
    def dd(self) -> Floats:
        """Return (N, 3, 3): the change of d per unit of each gain's logarithm."""
        return np.asarray(self.moving.fixed + self.scale[:, None, None] * self.moving.error)

    @property
    def spread(self) -> Floats:
        """Return t (N,): the square root of |dA| or alpha / 2, whichever is larger.

        The bound on He(E X W) holds for every t > 0 and is exact where t X E' = W / t; this t makes
        both sides equally large for steps X of order one.
        """
        speeds = np.linalg.norm(self.moving.A, axis=(2, 3)).max(axis=1)
        return np.asarray(np.sqrt(np.maximum(speeds, self.speed / 2)), dtype=np.float64)


def motion_lmi(
    name: str,
    around: Around,
    chosen: Indices,
    P: Unknown,
    u: Unknown | None,
    pace: Unknown,
    wider: Unknown,
) -> LMI:
    """Return the module's LMI over the chosen corners, each divided by its alpha.

    The division gives all cells margins of the same order, although their alphas differ.

    ``u`` : scalars, one per gain; None if the gains are fixed.
    ``pace``, ``wider`` : scalars, the relative changes a of ``around.speed`` and c of
    ``around.scale``.
    """
    moving, index = around.moving, around.pace[chosen]
    speed = around.speed[chosen][:, None, None]
    root = np.sqrt(speed)
    s = around.spread[chosen][:, None, None]
    A, d = moving.at.A[chosen] / speed, around.d[chosen][:, :, None] / speed
    error_columns = (around.scale[:, None] * moving.at.error)[chosen][:, :, None]
    changes = around.dd[chosen][:, :, :, None]
    last = 2 if around.disturbed else 1
    P_A, a = P @ matrix(A, "A / \\alpha"), pace.members(index, "a")
    state = He(P_A) + P + a * identity(3)
    step = matrix(s / root * EYE, "t") @ P - matrix(s / root * EYE, "t")
    step = step + a * matrix(root / (2 * s) * EYE, r"\tfrac{1}{2t}")
    pushed, pushed_step = P @ matrix(d, "d"), None
    if around.disturbed:
        c = wider.members(index, "c")
        pushed = pushed + c * matrix(error_columns / speed, r"e / \alpha")
        pushed_step = c * matrix(error_columns / (s * root), "e / t")
    for j in range(3 if u is not None else 0):
        assert u is not None
        dA, dd = moving.A[chosen, j], changes[:, j]
        u_j = u.members(moving.members[chosen, j], f"u_{{{j + 1}}}")
        symmetrised = (dA + dA.transpose(0, 2, 1)) / speed
        state = state + u_j * matrix(symmetrised, rf"\mathrm{{He}}(dA_{{{j + 1}}}) / \alpha")
        step = step + u_j * matrix(dA / (s * root), f"dA_{{{j + 1}}} / t")
        if pushed_step is not None:
            pushed = pushed + u_j * matrix(dd / speed, rf"dd_{{{j + 1}}} / \alpha")
            pushed_step = pushed_step + u_j * matrix(dd / (s * root), f"dd_{{{j + 1}}} / t")
    cells = {(0, 0): state, (last, 0): step, (last, last): -2 * identity(3)}
    if pushed_step is not None:
        cells |= {(0, 1): pushed, (1, 1): -a - identity(1), (last, 1): pushed_step}
    sizes = (3, 1, 3) if around.disturbed else (3, 3)
    return lmi_of((symmetric_block(sizes, cells) << 0).named(name))


def limits(unknown: Unknown, low: Floats, high: Floats) -> tuple[LMI, LMI]:
    """Return low <= scalar <= high for each member."""
    each = unknown.members(np.arange(unknown.count), f"{unknown.symbol}_{{i}}")
    lowest, highest = matrix(low[:, None, None], "l_{i}"), matrix(high[:, None, None], "h_{i}")
    return (
        lmi_of((each >= lowest).named(f"{unknown.name} above")),
        lmi_of((each <= highest).named(f"{unknown.name} below")),
    )


def inside_box(P: Unknown, h: Floats) -> LMI:
    """Return P - h_i h_i' >= 0, which holds if and only if {x' P x <= 1} is inside |h_i' x| <= 1.

    The form with P instead of P^-1 keeps it linear in the unknown of this step.
    """
    squares = matrix(h[:, :, None] * h[:, None, :], r"h_{i} h_{i}^\top")
    return lmi_of((P >> squares).named("inside the box"))


def reach_in_speed(P: Unknown, h: Floats, eta: Unknown) -> LMI:
    """Return [[P, h], [h', eta]] >= 0: by the Schur complement eta >= h' P^-1 h.

    h' P^-1 h is the square of the largest speed error on {x' P x <= 1}, relative to the box.
    """
    reach = block([[P, matrix(h[:, :, None], "h")], [None, eta]])
    return lmi_of((reach >> 0).named("reach in speed"))


def mean_class(wider: Unknown, shares: Floats, mean: float) -> LMI:
    """Return sum of share_k c_k >= least."""
    c = wider.members(np.arange(wider.count), "c_{k}")
    total = added(c * matrix(shares[:, None, None], "p_{k}"), latex=r"\sum_k")
    return lmi_of((total >= np.array([[mean]])).named("mean wind class"))


def bounded_below(R: Unknown) -> LMI:
    """Return R >= I / 16, which keeps R positive definite in coordinates where it was I.

    An upper bound is not needed: the block t X E' of the overbound limits X = R - I.
    """
    return lmi_of((R >= EYE[0] / 16).named("R positive definite"))


def bent(u: Unknown, bends: Floats) -> tuple[LMI, LMI]:
    """Return |u_(k+1) - u_k| <= bend for each cell, as two families of scalar inequalities."""
    k = np.arange(len(bends))
    here, there = u.members(k, "u_{k}"), u.members(k + 1, "u_{k+1}")
    bend = matrix(bends[:, None, None], "b_{k}")
    return (
        lmi_of((here - there + bend >= 0).named("bend +1")),
        lmi_of((there - here + bend >= 0).named("bend -1")),
    )


def shortfall(around: Around, P: Floats, u: Floats | None, pace: Floats, wider: Floats) -> Floats:
    """Return (N,): the largest eigenvalue of the bilinear inequality divided by its alpha.

    A corner satisfies its inequality if its value is negative.  The products of unknowns are
    included here, unlike in the convex LMI.
    """
    moving, at = around.moving, around.moving.at
    scale = around.scale * (1 + wider[at.cell]) if around.disturbed else around.scale
    A, d = at.A, at.fixed + scale[:, None] * at.error
    if u is not None:
        by = u[moving.members]
        A = A + np.einsum("nj,njab->nab", by, moving.A)
        d = d + np.einsum("nj,nja->na", by, moving.fixed + scale[:, None, None] * moving.error)
    speed = around.speed * (1 + pace[around.pace])
    n = 4 if around.disturbed else 3
    M = np.zeros((len(A), n, n))
    PA = P @ A
    M[:, :3, :3] = (PA + PA.transpose(0, 2, 1)) / speed[:, None, None] + P
    if around.disturbed:
        M[:, :3, 3] = d @ P / speed[:, None]
        M[:, 3, :3] = M[:, :3, 3]
        M[:, 3, 3] = -1.0
    return np.asarray(np.linalg.eigvalsh(M)[:, -1], dtype=np.float64)
