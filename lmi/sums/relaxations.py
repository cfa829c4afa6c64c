"""Sufficient LMIs for sum_ij h_i h_j Theta_ij < 0 for all memberships: named relaxations."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from math import gcd
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from takagi.lmi.condition.term import LMI, Term
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum
from takagi.lmi.sums.product_premises import polya, product, product_liu_zhang
from takagi.lmi.sums.relaxation_sizes import check_size
from takagi.lmi.sums.rule_pairs import (
    SLACK_SHARE,
    pair_lmis,
    rule_lmi,
    slack_name,
    slack_unknown,
    together,
)
from takagi.lmi.sums.slack_matrices import kim_lee, liu_zhang
from takagi.lmi.sums.summands import Summand
from takagi.models.errors import ModelError, did_you_mean

Relaxation: TypeAlias = Callable[[DoubleSum], RelaxedSum]


def relaxation_named(name: str) -> Relaxation:
    """Return the relaxation; ``"polya-<d>"``, ``"product-<d>"`` for degree d = 0, 1, 2, ...

    It raises ModelError where it does not apply, and where it is too large to be posed.

    Raises
    ------
    ModelError : unknown name; the message lists those that there are.
    """
    text = name if isinstance(name, str) else ""
    match = re.fullmatch(r"(polya|product)-(\d+)", text)
    if text == "auto":
        raise ModelError(
            'relaxation "auto", one after another, is for pdc and observer; here name one: '
            'pdc(model, relaxation="auto").relaxation is the first that has gains, "liu-zhang" '
            'and "polya-2" have them more often'
        )
    if match is None and text not in RELAXATIONS:
        names = [*RELAXATIONS, "polya-<d>", "product-<d>"]
        raise ModelError(
            f"relaxation {name!r} is not known; there are {', '.join(names)}, and of pdc and "
            "observer also auto, which tries one after another"
            + did_you_mean(str(name), [*RELAXATIONS, "polya-1", "polya-2", "product-1"])
        )

    def relaxed(loop: DoubleSum) -> RelaxedSum:
        check_size(name, loop)
        if match is None:
            return RELAXATIONS[name](loop)
        return {"polya": polya, "product": product}[match[1]](loop, int(match[2]))

    return relaxed


def common_gain(loop: DoubleSum) -> RelaxedSum:
    """Theta_i < 0 with one gain for all rules: a robust controller, no schedule.

    If Theta changes with j although the gain does not, this poses all pairs.
    """
    if not loop.by_gain:
        return (), (rule_lmi(loop),)
    return wang_tanaka_griffin(loop)


def wang_tanaka_griffin(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < 0, and Theta_ij + Theta_ji < 0 for all pairs i < j that act together.

    Source: Wang, Tanaka and Griffin (1996), IEEE Trans. Fuzzy Systems 4(1), theorem 3.
    """
    return (), pair_lmis(loop)


def tanaka_wang(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii + (s - 1) Y < 0, Theta_ij + Theta_ji - 2 Y < 0 for i < j, Y > 0.

    Y is a common slack: the sum for a pair may be positive if each rule alone has a margin.
    At most s of the r rules act at a time; s = r where nothing is known.

    Source: Tanaka, Ikeda and Wang (1998), IEEE Trans. Fuzzy Systems 6(2), theorem 2; Tanaka and
    Wang (2001), theorem 9.
    """
    n, eye, s = loop.size, np.eye(loop.size)[None], loop.most_active
    Y = slack_unknown(loop, "Y", n)
    diagonal_slack = Term(
        unknown=Y,
        left=(s - 1.0) * eye,
        right=eye,
        at=None,
        latex=("" if s == 2 else f"{s - 1}", ""),
    )
    less = Term(unknown=Y, left=-2.0 * eye, right=eye, at=None, latex=("-2", ""))
    positive = LMI(
        name=slack_name(loop, "slack"),
        blocks=(n,),
        terms=(Term(unknown=Y, left=eye, right=eye),),
        weight=SLACK_SHARE * loop.weight,
    )
    rule_slack = (diagonal_slack,) if s > 1 else ()
    return (Y,), (*pair_lmis(loop, rule_slack, (less,)), positive)


def tuan(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < 0, and 2/(s - 1) Theta_ii + Theta_ij + Theta_ji < 0 for all i != j.

    No slack unknowns, and never more conservative than all pairs.  At most s of the r rules act
    at a time; s = r where nothing is known.

    Source: Tuan, Apkarian, Narikiyo and Yamamoto (2001), IEEE Trans. Fuzzy Systems 9(2).
    """
    first, second = loop.pairs()
    if not len(first):
        return (), (rule_lmi(loop),)
    i, j = np.concatenate([first, second]), np.concatenate([second, first])
    # In whole numbers, so that no rounding error can invalidate the inequality.
    common = gcd(2, loop.most_active - 1)
    rule_factor, pair_factor = 2 // common, (loop.most_active - 1) // common
    weight = np.ones(len(i))
    pairs = loop.lmi(
        "pair",
        (
            Summand(i, i, rule_factor * weight, names=("i", "i"), factor=_number(rule_factor)),
            Summand(i, j, pair_factor * weight, factor=_number(pair_factor)),
            Summand(j, i, pair_factor * weight, names=("j", "i"), factor=_number(pair_factor)),
        ),
        count=len(i),
        label=lambda item: f"rules {i[item] + 1} and {j[item] + 1}",
        index=rf"i \ne j = 1, \dots, {loop.rules}" + together(loop),
        scale=2.0 ** -round(np.log2(pair_factor)),
    )
    return (), (rule_lmi(loop), pairs)


def _number(value: int) -> str:
    return "" if value == 1 else str(value)


RELAXATIONS: Mapping[str, Relaxation] = MappingProxyType(
    {
        "common-gain": common_gain,
        "wang-tanaka-griffin": wang_tanaka_griffin,
        "tanaka-wang": tanaka_wang,
        "tuan": tuan,
        "kim-lee": kim_lee,
        "liu-zhang": liu_zhang,
        "product": product,
        "product-liu-zhang": product_liu_zhang,
    }
)
