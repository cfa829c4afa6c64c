"""Relaxations with a matrix of slack unknowns X = [X_ij] < 0 that the Theta_ij stay below."""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.term import LMI, Term
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, selections
from takagi.lmi.sums.rule_pairs import SLACK_SHARE, pair_lmis, slack_name, slack_unknown
from takagi.models.arrays import Indices


def kim_lee(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < X_ii, Theta_ij + Theta_ji < 2 X_ij for i < j, [X_ij] < 0, each X_ij symmetric.

    For pairs that never act together X_ij is not constrained by a Theta_ij.

    Source: Kim and Lee (2000), IEEE Trans. Fuzzy Systems 8(5), theorem 3.
    """
    r, n = loop.rules, loop.size
    eye = np.eye(n)[None]
    X = slack_unknown(loop, "X", n, count=triangle(r))
    member = _places(r)
    rule_slack = Term(
        unknown=X,
        left=-eye,
        right=eye,
        at=None,
        members=np.diag(member),
        latex=("-", ""),
        symbol=f"{X.symbol}_{{ii}}",
    )
    i, j = loop.pairs()
    cross = Term(
        unknown=X,
        left=-2.0 * eye,
        right=eye,
        at=None,
        members=member[i, j],
        latex=("-2", ""),
        symbol=f"{X.symbol}_{{ij}}",
    )
    pairs = pair_lmis(loop, (rule_slack,), (cross,) if len(i) else ())
    return (X,), (*pairs, _whole_of_blocks(loop, X, member))


def liu_zhang(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < X_ii, Theta_ij + Theta_ji < X_ij + X_ij' for i < j, X = [X_ij] < 0.

    As Kim and Lee's, but the blocks off the diagonal need not be symmetric.

    Source: Liu and Zhang (2003), Automatica 39(9), theorem 2.
    """
    r, n = loop.rules, loop.size
    X = slack_unknown(loop, "X", r * n)
    E = selections(r, n)
    Et = E.transpose(0, 2, 1)
    rule_slack = Term(unknown=X, left=-Et, right=E, at=None, latex=(r"-E_i^\top", "E_i"))
    i, j = loop.pairs()
    cross = Term(
        unknown=X,
        left=-Et[i],
        right=E[j],
        at=None,
        plus_transpose=True,
        latex=(r"-E_i^\top", "E_j"),
    )
    pairs = pair_lmis(loop, (rule_slack,), (cross,) if len(i) else ())
    return (X,), (*pairs, negative_whole(loop, X))


def negative_whole(loop: DoubleSum, X: Unknown) -> LMI:
    """Return X < 0."""
    eye = np.eye(X.rows)[None]
    return LMI(
        name=slack_name(loop, "slack"),
        blocks=(X.rows,),
        terms=(Term(unknown=X, left=eye, right=eye),),
        sign=-1,
        weight=SLACK_SHARE * loop.weight,
    )


def _places(rules: int) -> Indices:
    """Return (rules, rules): which member the block (i, j) is, the same as (j, i)."""
    i, j = np.triu_indices(rules)
    member = np.zeros((rules, rules), dtype=np.intp)
    member[i, j] = member[j, i] = np.arange(len(i))
    return member


def _whole_of_blocks(loop: DoubleSum, X: Unknown, member: Indices) -> LMI:
    """Return [X_ij] < 0, block (i, j) and its mirror image being member place[i, j] of X."""
    r, n = loop.rules, loop.size
    E = selections(r, n)
    Et = E.transpose(0, 2, 1)
    a, b = np.triu_indices(r, 1)
    diagonal = Term(
        unknown=X,
        left=E,
        right=Et,
        items=np.zeros(r, dtype=np.intp),
        members=np.diag(member),
        latex=("E_i", r"E_i^\top"),
        symbol=f"{X.symbol}_{{ii}}",
        factor=r"\sum_i",
    )
    cross = Term(
        unknown=X,
        left=E[a],
        right=Et[b],
        items=np.zeros(len(a), dtype=np.intp),
        members=member[a, b],
        plus_transpose=True,
        latex=("E_i", r"E_j^\top"),
        symbol=f"{X.symbol}_{{ij}}",
        factor=r"\sum_{i<j}",
    )
    return LMI(
        name=slack_name(loop, "slack"),
        blocks=(r * n,),
        terms=(diagonal, cross) if len(a) else (diagonal,),
        sign=-1,
        weight=SLACK_SHARE * loop.weight,
    )
