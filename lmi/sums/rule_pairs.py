"""The inequalities of rules alone and of pairs of rules, which most relaxations start from."""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.term import LMI, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.summands import Summand

# Margin of a slack unknown for a margin 1 of Theta. The margin of a slack reduces the margin of the
# sum, r - 1 times in Tanaka and Wang's relaxation, so it must be small. But if it is much smaller,
# the centring near a least objective finds no interior point (seen at 1 / 128).
SLACK_SHARE = 2.0**-4


def rule_lmi(loop: DoubleSum, slack: tuple[Term, ...] = ()) -> LMI:
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
    loop: DoubleSum, rule_slack: tuple[Term, ...] = (), cross: tuple[Term, ...] = ()
) -> tuple[LMI, ...]:
    """Return Theta_ii + own < 0, and Theta_ij + Theta_ji + cross < 0 for the pairs i < j that act.

    Parameters
    ----------
    cross : with one contribution for all pairs, or one for each pair of ``loop.pairs()``.
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
        index=rf"1 \le i < j \le {loop.rules}" + together(loop),
    )
    return rule_lmi(loop, rule_slack), pairs


def together(loop: DoubleSum) -> str:
    """Return what the index range of pairs adds where some pairs never act, in LaTeX."""
    return "" if loop.active is None else r",\; h_i h_j \not\equiv 0"


def slack_unknown(loop: DoubleSum, name: str, size: int, count: int = 1) -> Unknown:
    """Return a symmetric slack unknown of its own for each double sum of a condition."""
    return Unknown(slack_name(loop, name), size, size, symmetric=True, count=count, latex=name)


def slack_name(loop: DoubleSum, name: str) -> str:
    """Return the name with the double sum's in front, where a condition has several."""
    return f"{loop.name}, {name}" if loop.name else name
