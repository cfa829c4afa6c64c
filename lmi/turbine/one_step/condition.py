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

from takagi.lmi.condition.term import LMI, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.turbine.one_step.loop_of_gains import MovingCorners, WindCellCorners
from takagi.models.arrays import Floats, Indices

ONE = np.ones((1, 1, 1))
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

    Parameters
    ----------
    u : scalars, one per gain; None if the gains are fixed.
    pace, wider : scalars, the relative changes a of ``around.speed`` and c of ``around.scale``.
    """
    moving, index = around.moving, around.pace[chosen]
    speed = around.speed[chosen][:, None, None]
    root = np.sqrt(speed)
    s = around.spread[chosen][:, None, None]
    A, d = moving.at.A[chosen] / speed, around.d[chosen][:, :, None] / speed
    error_columns = (around.scale[:, None] * moving.at.error)[chosen][:, :, None]
    changes = around.dd[chosen][:, :, :, None]
    row = 2 if around.disturbed else 1
    step = (row, row)
    terms = [
        Term(unknown=P, left=EYE, right=A, plus_transpose=True),
        Term(unknown=P, left=EYE, right=EYE),
        Term(unknown=pace, left=EYE, members=index),
        Term(unknown=P, left=s / root * EYE, right=EYE, at=(row, 0)),
        Term(unknown=pace, left=root / (2 * s) * EYE, at=(row, 0), members=index),
    ]
    constants = [Constant(value=-s / root * EYE, at=(row, 0)), Constant(value=-2 * EYE, at=step)]
    if around.disturbed:
        terms.append(Term(unknown=P, left=EYE, right=d, at=(0, 1)))
        terms.append(Term(unknown=pace, left=-ONE, at=(1, 1), members=index))
        terms.append(Term(unknown=wider, left=error_columns / speed, at=(0, 1), members=index))
        terms.append(
            Term(unknown=wider, left=error_columns / (s * root), at=(row, 1), members=index)
        )
        constants.append(Constant(value=-ONE, at=(1, 1)))
    for j in range(3 if u is not None else 0):
        assert u is not None
        dA, dd = moving.A[chosen, j], changes[:, j]
        members = moving.members[chosen, j]
        symmetrised = (dA + dA.transpose(0, 2, 1)) / speed
        terms.append(Term(unknown=u, left=symmetrised, members=members))
        terms.append(Term(unknown=u, left=dA / (s * root), at=(row, 0), members=members))
        if around.disturbed:
            terms.append(Term(unknown=u, left=dd / speed, at=(0, 1), members=members))
            terms.append(Term(unknown=u, left=dd / (s * root), at=(row, 1), members=members))
    return LMI(
        name=name,
        blocks=(3, 1, 3) if around.disturbed else (3, 3),
        terms=tuple(terms),
        constants=tuple(constants),
        sign=-1,
        count=len(chosen),
    )


def limits(unknown: Unknown, low: Floats, high: Floats) -> tuple[LMI, LMI]:
    """Return low <= scalar <= high for each member."""
    every = np.arange(unknown.count)
    term = Term(unknown=unknown, left=ONE, members=every)
    ends = ((f"{unknown.name} above", low, 1), (f"{unknown.name} below", high, -1))
    above, below = (
        LMI(
            name=name,
            blocks=(1,),
            terms=(term,),
            constants=(Constant(value=-end[:, None, None]),),
            sign=sign,
            count=unknown.count,
            strict=False,
        )
        for name, end, sign in ends
    )
    return above, below


def inside_box(P: Unknown, h: Floats) -> LMI:
    """Return P - h_i h_i' >= 0, which holds if and only if {x' P x <= 1} is inside |h_i' x| <= 1.

    The form with P instead of P^-1 keeps it linear in the unknown of this step.
    """
    return LMI(
        name="inside the box",
        blocks=(3,),
        terms=(Term(unknown=P, left=EYE, right=EYE),),
        constants=(Constant(value=-h[:, :, None] * h[:, None, :]),),
        count=len(h),
    )


def reach_in_speed(P: Unknown, h: Floats, eta: Unknown) -> LMI:
    """Return [[P, h], [h', eta]] >= 0: by the Schur complement eta >= h' P^-1 h.

    h' P^-1 h is the square of the largest speed error on {x' P x <= 1}, relative to the box.
    """
    return LMI(
        name="reach in speed",
        blocks=(3, 1),
        terms=(
            Term(unknown=P, left=EYE, right=EYE),
            Term(unknown=eta, left=ONE, right=ONE, at=(1, 1)),
        ),
        constants=(Constant(value=h[:, :, None], at=(0, 1)),),
    )


def mean_class(wider: Unknown, shares: Floats, mean: float) -> LMI:
    """Return sum of share_k c_k >= least."""
    every = np.arange(wider.count)
    zero = np.zeros(wider.count, dtype=np.intp)
    term = Term(unknown=wider, left=shares[:, None, None], items=zero, members=every)
    constant = Constant(value=-mean * ONE)
    return LMI(
        name="mean wind class", blocks=(1,), terms=(term,), constants=(constant,), strict=False
    )


def bounded_below(R: Unknown) -> LMI:
    """Return R >= I / 16, which keeps R positive definite in coordinates where it was I.

    An upper bound is not needed: the block t X E' of the overbound limits X = R - I.
    """
    return LMI(
        name="R positive definite",
        blocks=(3,),
        terms=(Term(unknown=R, left=EYE, right=EYE),),
        constants=(Constant(value=-EYE / 16),),
        strict=False,
    )


def bent(u: Unknown, bends: Floats) -> tuple[LMI, LMI]:
    """Return |u_(k+1) - u_k| <= bend for each cell, as two families of scalar inequalities."""
    k = np.arange(len(bends))
    above, below = (
        LMI(
            name=f"bend {side:+d}",
            blocks=(1,),
            terms=(
                Term(unknown=u, left=side * ONE, members=k),
                Term(unknown=u, left=-side * ONE, members=k + 1),
            ),
            constants=(Constant(value=bends[:, None, None]),),
            count=len(bends),
            strict=False,
        )
        for side in (1, -1)
    )
    return above, below


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
