r"""What "as large as possible" means for the ellipsoid {x' P x <= 1}, Q = P^-1: objectives as LMIs.

    volume      det Q largest:  v <= (z_1 ... z_n)^(1/n),  [[Q, T], [T', diag(z)]] >= 0 with T lower
                triangular and z its diagonal; then det Q >= z_1 ... z_n, with equality attained.
                The geometric mean is a tree of [[a, c], [c, b]] >= 0, c^2 <= a b, whose leaves are
                z_1, ..., z_n and, up to a power of two, its root itself.
    trace       sum_k Q_kk / w_k^2 largest: the sum of the squared semi-axes in units w_k.
    points      the largest beta with beta x_k in the ellipsoid for every given point: gamma =
                1 / beta^2 least, [[gamma, x_k'], [x_k, Q]] >= 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.2.2, for the aims; Ben-Tal and
Nemirovski (2001), Lectures on Modern Convex Optimization, for the determinant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown, triangle


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """An objective for Q, with what it needs: its LMIs are not claims, only an epigraph."""

    objective: Mapping[str, Array]
    unknowns: tuple[Unknown, ...] = ()
    lmis: tuple[LMI, ...] = field(default=())

    def put_on(self, condition: Condition) -> Condition:
        """Return the condition with this objective in the place of its own."""
        return Condition(
            name=condition.name,
            unknowns=condition.unknowns + self.unknowns,
            lmis=condition.lmis + self.lmis,
            objective=self.objective,
            parameters=condition.parameters,
            source=condition.source,
        )


def trace_measure(Q: Unknown, units: Array) -> Measure:
    """Return: sum_k Q_kk / units_k^2 largest; units (n,)."""
    return Measure({Q.name: -np.diag(units**-2.0)[None]})


def points_measure(Q: Unknown, points: Array) -> Measure:
    """Return: the largest multiple of the given points, (k, n), in the ellipsoid.

    The multiple is gamma^(-1/2).
    """
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    one = np.eye(Q.rows)[None]
    inside = LMI(
        name="multiple of the points",
        blocks=(1, Q.rows),
        terms=(
            Term(unknown=gamma, left=np.ones((1, 1, 1))),
            Term(unknown=Q, left=one, right=one, at=(1, 1)),
        ),
        constants=(Constant(value=points[:, None, :], at=(0, 1), latex=r"x_k^\top"),),
        count=len(points),
        strict=False,
        index=rf"k = 1, \dots, {len(points)}",
    )
    return Measure({"gamma": np.ones((1, 1, 1))}, (gamma,), (inside,))


def volume_measure(Q: Unknown) -> Measure:
    """Return: det(Q)^(1/n) largest; v is the unknown ``volume``."""
    n = Q.rows
    if n == 1:
        return trace_measure(Q, np.ones(1))
    v = Unknown("volume", 1, 1, latex="v")
    # The tree's nodes, the root first, then its leaves: children of node k are 2 k and 2 k + 1.
    nodes = 2 ** int(np.ceil(np.log2(n))) - 1
    c = Unknown("means", 1, 1, count=nodes + n, latex="c")
    T = Unknown("factor", 1, 1, count=triangle(n - 1), latex="T")
    root = LMI(
        name="volume",
        blocks=(1,),
        terms=(
            Term(unknown=c, left=np.ones((1, 1, 1)), symbol="c_1"),
            Term(unknown=v, left=-np.ones((1, 1, 1)), latex=("-", "")),
        ),
        strict=False,
    )
    return Measure(
        {"volume": -np.ones((1, 1, 1))}, (v, c, T), (_factor_lmi(Q, T, c), _mean_lmi(c, n), root)
    )


def _factor_lmi(Q: Unknown, T: Unknown, c: Unknown) -> LMI:
    """Pose [[Q, T], [T', z]] >= 0: T lower triangular, z its diagonal, the leaves of the tree."""
    n = Q.rows
    one = np.eye(n)
    single = one[:, :, None] * one[:, None, :]
    row, column = np.tril_indices(n, -1)
    below = one[row][:, :, None] * one[column][:, None, :]
    leaves = np.arange(c.count - n, c.count)
    dots = ", " if n == 2 else r", \dots, "
    here, there = np.zeros(n, dtype=np.intp), np.zeros(len(row), dtype=np.intp)
    return LMI(
        name="factor of Q",
        blocks=(n, n),
        terms=(
            Term(unknown=Q, left=one[None], right=one[None]),
            Term(
                unknown=T,
                left=below,
                at=(0, 1),
                items=there,
                members=np.arange(len(row)),
                symbol=r"T_{\text{lower}}",
            ),
            *(
                Term(
                    unknown=c,
                    left=single,
                    at=(side, 1),
                    items=here,
                    members=leaves,
                    symbol=r"\mathrm{diag}(z)",
                )
                for side in (0, 1)
            ),
        ),
        strict=False,
        index=rf"z = (c_{{{c.count - n + 1}}}{dots}c_{{{c.count}}})",
    )


def _mean_lmi(c: Unknown, n: int) -> LMI:
    """Pose [[c_2k, c_k], [c_k, c_2k+1]] >= 0 at every node; the root again for missing leaves."""
    nodes = c.count - n
    k = np.arange(1, nodes + 1)
    terms = [
        Term(
            unknown=c,
            left=np.ones((1, 1, 1)),
            at=at,
            items=np.arange(nodes),
            members=np.where(index <= c.count, index, 1) - 1,
            symbol=symbol,
        )
        for index, at, symbol in (
            (2 * k, (0, 0), "c_{2k}"),
            (2 * k + 1, (1, 1), "c_{2k+1}"),
            (k, (0, 1), "c_k"),
        )
    ]
    missing = "" if nodes + 1 == n else rf",\; c_l = c_1 \text{{ for }} l > {c.count}"
    return LMI(
        name="geometric mean",
        blocks=(1, 1),
        terms=tuple(terms),
        count=nodes,
        strict=False,
        index=rf"k = 1, \dots, {nodes}{missing}",
    )
