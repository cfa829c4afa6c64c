r"""One convex step in the quadratic function and the gains together.

The loop's corners A, d are straight lines in the logarithms u of the gains (``one_step_family``).
In coordinates where the present function is |x|^2, P = I + X, a corner of cell k with multiplier
alpha_k (1 + a_k) asks for

    [ He(P (A + dA(u))) + alpha (1 + a) P     P (d + dd(u))   ]
    [ .                                      -alpha (1 + a)   ]  < 0 .

With W = [dA(u) + alpha a I / 2,  dd(u)] all that is not linear is He(E X W), E = [I, 0]', and

    He(E X W) = |s X E' + W / s|^2 / 2 - |s X E' - W / s|^2 / 2  <=  |s X E' + W / s|^2 / 2 :

a block row [s X E' + W / s] with -2 I on the diagonal.  What satisfies these LMIs satisfies those
above, and the present function and gains do, so in the straight lines no step loses.  The decay
rate d of a function R is the same without the column of d, with alpha = 2 d for all cells.

Source: derived here; Dinh, Gumussoy, Michiels, Diehl (2012), IEEE Trans. Automatic Control 57(6),
for the convex-concave decomposition of bilinear matrix inequalities; Boyd, El Ghaoui, Feron,
Balakrishnan (1994), section 6.1.3, for the invariant set.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.term import LMI, Constant, Term, Unknown
from takagi.lmi.turbine.one_step_family import Moving

__all__ = ["Around", "limits", "motion_lmi", "shortfall"]

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
ONE = np.ones((1, 1, 1))
EYE = np.eye(3)[None]


@dataclass(frozen=True, slots=True, eq=False)
class Around:
    """Corners in coordinates where the present function is |x|^2.

    Attributes
    ----------
    moving : corners and secants; the secants are zero where the gains stay.
    speed : (N,) alpha of each corner, or 2 d [1/s].
    pace : (N,) which unknown relative change of ``speed`` is a corner's.
    disturbed : whether the column of d stands beside the motion.
    """

    moving: Moving
    speed: Floats
    pace: Indices
    disturbed: bool

    @classmethod
    def of(
        cls, moving: Moving, T: Floats, size: float, speed: Floats, pace: Indices, disturbed: bool
    ) -> Around:
        """Return corners for x = T xhat, disturbances times ``size``."""
        inverse = np.linalg.inv(T)
        at = moving.at
        corners = type(at)(inverse @ at.A @ T, size * at.d @ inverse.T, at.cell)
        posed = Moving(
            corners,
            moving.members,
            inverse @ moving.A @ T,
            size * moving.d @ inverse.T,
            moving.raised,
        )
        return cls(posed, speed, pace, disturbed)

    @property
    def spread(self) -> Floats:
        """Return s (N,): the root of how fast a corner moves, for steps in P of order one."""
        moved = np.linalg.norm(self.moving.A, axis=(2, 3)).max(axis=1)
        return np.asarray(np.sqrt(np.maximum(moved, self.speed / 2)), dtype=np.float64)


def motion_lmi(
    name: str, around: Around, chosen: Indices, P: Unknown, u: Unknown | None, pace: Unknown
) -> LMI:
    """Return the module's LMI over the chosen corners, each divided by its alpha.

    Parameters
    ----------
    u : scalars, one per gain; None where gains stay.
    pace : scalars, the relative changes of ``around.speed``.
    """
    moving, index = around.moving, around.pace[chosen]
    speed = around.speed[chosen][:, None, None]
    root = np.sqrt(speed)
    s = around.spread[chosen][:, None, None]
    A, d = moving.at.A[chosen] / speed, moving.at.d[chosen][:, :, None] / speed
    row = 2 if around.disturbed else 1
    step = (row, row)
    terms = [
        Term(unknown=P, left=EYE, right=A, plus_transpose=True),
        Term(unknown=P, left=EYE, right=EYE),
        Term(unknown=pace, left=EYE, members=index),
        Term(unknown=P, left=s / root * EYE, right=EYE, at=(row, 0)),
        Term(unknown=pace, left=root / (2 * s) * EYE, at=(row, 0), members=index),
    ]
    constants = [
        Constant(value=-s / root * EYE, at=(row, 0)),
        Constant(value=-2 * EYE, at=step),
    ]
    if around.disturbed:
        terms.append(Term(unknown=P, left=EYE, right=d, at=(0, 1)))
        terms.append(Term(unknown=pace, left=-ONE, at=(1, 1), members=index))
        constants.append(Constant(value=-ONE, at=(1, 1)))
    for j in range(3 if u is not None else 0):
        assert u is not None
        dA, dd = moving.A[chosen, j], moving.d[chosen, j][:, :, None]
        members = moving.members[chosen, j]
        both = (dA + dA.transpose(0, 2, 1)) / speed
        terms.append(Term(unknown=u, left=both, members=members))
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
            weight=0.0,
        )
        for name, end, sign in ends
    )
    return above, below


def shortfall(around: Around, P: Floats, u: Floats | None, pace: Floats) -> Floats:
    """Return (N,): largest eigenvalue of the bilinear inequality over its alpha; negative holds."""
    moving, at = around.moving, around.moving.at
    A, d = at.A, at.d
    if u is not None:
        by = u[moving.members]
        A = A + np.einsum("nj,njab->nab", by, moving.A)
        d = d + np.einsum("nj,nja->na", by, moving.d)
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
