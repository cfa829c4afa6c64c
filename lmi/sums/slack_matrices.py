"""Relaxations by pairs of rules, alone and with slack matrices."""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.statements import lmi_of
from takagi.lmi.condition.term import LMI
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.expressions.expression import Expression, He, added, matrix
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, Summand, selections
from takagi.models.arrays import Indices

# Margin of a slack unknown for a margin 1 of Theta. The margin of a slack reduces the margin of the
# sum, r - 1 times in Tanaka and Wang's relaxation, so it must be small. But if it is much smaller,
# the centring near a least objective finds no interior point (seen at 1 / 128).
SLACK_SHARE = 2.0**-4


def rule_lmi(loop: DoubleSum, slack: Expression | None = None) -> LMI:
    """Return Theta_ii + slack < 0."""
    r = loop.rules
    i = np.arange(r)
    return loop.lmi(
        "rule",
        # With a single gain nothing depends on j.
        (Summand(i, i, np.ones(r), names=("i", "i")),),
        slack,
        count=r,
        label=lambda item: f"rule {item + 1} of {r}",
        index=rf"i = 1, \dots, {r}",
    )


def pair_lmis(
    loop: DoubleSum, rule_slack: Expression | None = None, cross: Expression | None = None
) -> tuple[LMI, ...]:
    """Return Theta_ii + own < 0, and Theta_ij + Theta_ji + cross < 0 for the pairs i < j.

    ``cross`` : the same for all pairs, or one for each of ``loop.pairs()``.
    """
    i, j = loop.pairs()
    if not len(i):
        return (rule_lmi(loop, rule_slack),)
    unit_weights = np.ones(len(i))
    pairs = loop.lmi(
        "pair",
        (Summand(i, j, unit_weights), Summand(j, i, unit_weights, names=("j", "i"))),
        cross,
        count=len(i),
        label=lambda item: f"rules {i[item] + 1} and {j[item] + 1}",
        index=rf"1 \le i < j \le {loop.rules}",
    )
    return rule_lmi(loop, rule_slack), pairs


def slack_unknown(loop: DoubleSum, name: str, size: int, count: int = 1) -> Unknown:
    """Return a symmetric slack unknown of its own for each double sum of a condition."""
    return Unknown(slack_name(loop, name), size, size, symmetric=True, count=count, latex=name)


def slack_name(loop: DoubleSum, name: str) -> str:
    """Return the name with the double sum's in front, where a condition has several."""
    return f"{loop.name}, {name}" if loop.name else name


def kim_lee(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < X_ii, Theta_ij + Theta_ji < 2 X_ij for i < j, [X_ij] < 0, each X_ij symmetric.

    Source: Kim and Lee (2000), IEEE Trans. Fuzzy Systems 8(5), theorem 3.
    """
    r, n = loop.rules, loop.size
    X = slack_unknown(loop, "X", n, count=triangle(r))
    member, E = _places(r), selections(r, n)
    X_ii = X.members(np.diag(member), f"{X.symbol}_{{ii}}")
    i, j = loop.pairs()
    cross = -2 * X.members(member[i, j], f"{X.symbol}_{{ij}}") if len(i) else None
    E_i = matrix(E, "E_i")
    blocks = added(E_i @ X_ii @ E_i.T, latex=r"\sum_i")
    a, b = np.triu_indices(r, 1)
    if len(a):
        X_ij = X.members(member[a, b], f"{X.symbol}_{{ij}}")
        E_a, E_b = matrix(E[a], "E_i"), matrix(E[b], "E_j")
        blocks += He(added(E_a @ X_ij @ E_b.T, latex=r"\sum_{i<j}"))
    return (X,), (*pair_lmis(loop, -X_ii, cross), _negative_slack(loop, blocks))


def liu_zhang(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < X_ii, Theta_ij + Theta_ji < X_ij + X_ij' for i < j, X = [X_ij] < 0.

    As Kim and Lee's, but the blocks off the diagonal need not be symmetric.

    Source: Liu and Zhang (2003), Automatica 39(9), theorem 2.
    """
    r, n = loop.rules, loop.size
    X = slack_unknown(loop, "X", r * n)
    E = selections(r, n)
    i, j = loop.pairs()
    E_i = matrix(E, "E_i")
    cross = -He(matrix(E[i], "E_i").T @ X @ matrix(E[j], "E_j")) if len(i) else None
    return (X,), (*pair_lmis(loop, -E_i.T @ X @ E_i, cross), negative_whole(loop, X))


def negative_whole(loop: DoubleSum, X: Unknown) -> LMI:
    """Return X < 0."""
    return _negative_slack(loop, X.as_expression())


def _negative_slack(loop: DoubleSum, X: Expression) -> LMI:
    name = slack_name(loop, "slack")
    return lmi_of((X << 0).named(name, weight=SLACK_SHARE * loop.weight))


def _places(rules: int) -> Indices:
    """Return (rules, rules): which member the block (i, j) is, the same as (j, i)."""
    i, j = np.triu_indices(rules)
    member = np.zeros((rules, rules), dtype=np.intp)
    member[i, j] = member[j, i] = np.arange(len(i))
    return member
