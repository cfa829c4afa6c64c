"""Sufficient LMIs for sum_ij h_i h_j Theta_ij < 0 whatever the memberships: named relaxations."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from itertools import combinations_with_replacement
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from takagi.lmi.synthesis.double_sum import DoubleSum, Summand, selections
from takagi.lmi.term import LMI, Indices, Term, Unknown
from takagi.lmi.unknown import triangle
from takagi.models.errors import ModelError, did_you_mean

__all__ = ["RELAXATIONS", "Relaxation", "relaxation_named"]

Posed: TypeAlias = tuple[tuple[Unknown, ...], tuple[LMI, ...]]
Relaxation: TypeAlias = Callable[[DoubleSum], Posed]


def relaxation_named(name: str) -> Relaxation:
    """Return the relaxation; ``"polya-<d>"`` for degree d = 0, 1, 2, ...

    Raises
    ------
    ModelError : unknown name; the message lists those that there are.
    """
    if isinstance(name, str) and (found := re.fullmatch(r"polya-(\d+)", name)):
        degree = int(found[1])
        return lambda loop: polya(loop, degree)
    if name not in RELAXATIONS:
        known = [*RELAXATIONS, "polya-<d>"]
        raise ModelError(
            f"relaxation {name!r} is not known; there are {', '.join(known)}"
            + did_you_mean(str(name), [*RELAXATIONS, "polya-1", "polya-2"])
        )
    return RELAXATIONS[name]


def common_gain(loop: DoubleSum) -> Posed:
    """Theta_i < 0 with one gain for all rules: a robust controller, no schedule."""
    return (), (_rules(loop),)


def wang_tanaka_griffin(loop: DoubleSum) -> Posed:
    """Theta_ii < 0, and Theta_ij + Theta_ji < 0 for all pairs i < j.

    Source: Wang, Tanaka and Griffin (1996), IEEE Trans. Fuzzy Systems 4(1), theorem 3.
    """
    return (), _pairwise(loop)


def tanaka_wang(loop: DoubleSum) -> Posed:
    """Theta_ii + (r - 1) Y < 0, Theta_ij + Theta_ji - 2 Y < 0 for i < j, Y > 0.

    A common slack: rules that act together may be worse in the sum, if each alone is better.

    Source: Tanaka, Ikeda and Wang (1998), IEEE Trans. Fuzzy Systems 6(2), theorem 2; Tanaka and
    Wang (2001), theorem 9, with all r rules active.
    """
    n, one = loop.size, np.eye(loop.size)[None]
    Y = _slack(loop, "Y", n)
    more = Term(
        unknown=Y,
        left=(loop.rules - 1.0) * one,
        right=one,
        at=None,
        latex=("" if loop.rules == 2 else f"{loop.rules - 1}", ""),
    )
    less = Term(unknown=Y, left=-2.0 * one, right=one, at=None, latex=("-2", ""))
    positive = LMI(
        name=_named(loop, "slack"),
        blocks=(n,),
        terms=(Term(unknown=Y, left=one, right=one),),
        weight=loop.weight,
    )
    return (Y,), (*_pairwise(loop, (more,), (less,)), positive)


def tuan(loop: DoubleSum) -> Posed:
    """Theta_ii < 0, and 2/(r - 1) Theta_ii + Theta_ij + Theta_ji < 0 for all i != j.

    No slack unknowns, and never more conservative than all pairs.

    Source: Tuan, Apkarian, Narikiyo and Yamamoto (2001), IEEE Trans. Fuzzy Systems 9(2).
    """
    r = loop.rules
    if r == 1:
        return (), (_rules(loop),)
    i, j = np.nonzero(~np.eye(r, dtype=bool))
    one = np.ones(len(i))
    own = Summand(i, i, 2.0 / (r - 1) * one, names=("i", "i"), factor=rf"\tfrac{{2}}{{{r - 1}}}")
    pairs = loop.lmi(
        "pair",
        (own, Summand(i, j, one), Summand(j, i, one, names=("j", "i"))),
        count=len(i),
        labels=_pair_labels(i, j),
        index=rf"i \ne j = 1, \dots, {r}",
    )
    return (), (_rules(loop), pairs)


def kim_lee(loop: DoubleSum) -> Posed:
    """Theta_ii < X_ii, Theta_ij + Theta_ji < 2 X_ij for i < j, [X_ij] < 0, each X_ij symmetric.

    Source: Kim and Lee (2000), IEEE Trans. Fuzzy Systems 8(5), theorem 3.
    """
    r, n = loop.rules, loop.size
    one = np.eye(n)[None]
    X = _slack(loop, "X", n, count=triangle(r))
    i, j = np.triu_indices(r)
    place = np.zeros((r, r), dtype=np.intp)
    place[i, j] = np.arange(len(i))
    own = Term(
        unknown=X,
        left=-one,
        right=one,
        at=None,
        members=np.diag(place),
        latex=("-", ""),
        symbol=f"{X.symbol}_{{ii}}",
    )
    cross = Term(
        unknown=X,
        left=-2.0 * one,
        right=one,
        at=None,
        members=place[np.triu_indices(r, 1)],
        latex=("-2", ""),
        symbol=f"{X.symbol}_{{ij}}",
    )
    pairs = _pairwise(loop, (own,), (cross,) if r > 1 else ())
    return (X,), (*pairs, _whole_of_blocks(loop, X, place))


def _whole_of_blocks(loop: DoubleSum, X: Unknown, place: Indices) -> LMI:
    """Return [X_ij] < 0, block (i, j) and its mirror image being member place[i, j] of X."""
    r, n = loop.rules, loop.size
    E = selections(r, n)
    Et = E.transpose(0, 2, 1)
    a, b = np.triu_indices(r, 1)
    own = Term(
        unknown=X,
        left=E,
        right=Et,
        items=np.zeros(r, dtype=np.intp),
        members=np.diag(place),
        latex=(r"\sum_i E_i", r"E_i^\top"),
        symbol=f"{X.symbol}_{{ii}}",
    )
    cross = Term(
        unknown=X,
        left=E[a],
        right=Et[b],
        items=np.zeros(len(a), dtype=np.intp),
        members=place[a, b],
        plus_transpose=True,
        latex=(r"\sum_{i<j} E_i", r"E_j^\top"),
        symbol=f"{X.symbol}_{{ij}}",
    )
    terms = (own, cross) if len(a) else (own,)
    return LMI(
        name=_named(loop, "slack"), blocks=(r * n,), terms=terms, sign=-1, weight=loop.weight
    )


def liu_zhang(loop: DoubleSum) -> Posed:
    """Theta_ii < X_ii, Theta_ij + Theta_ji < X_ij + X_ij' for i < j, X = [X_ij] < 0.

    As Kim and Lee's, but the blocks off the diagonal need not be symmetric.

    Source: Liu and Zhang (2003), Automatica 39(9), theorem 2.
    """
    r, n = loop.rules, loop.size
    X = _slack(loop, "X", r * n)
    E = selections(r, n)
    Et = E.transpose(0, 2, 1)
    own = Term(unknown=X, left=-Et, right=E, at=None, latex=(r"-E_i^\top", "E_i"))
    a, b = np.triu_indices(r, 1)
    cross = Term(
        unknown=X,
        left=-Et[a],
        right=E[b],
        at=None,
        plus_transpose=True,
        latex=(r"-E_i^\top", "E_j"),
    )
    all_of_it = np.eye(r * n)[None]
    whole = LMI(
        name=_named(loop, "slack"),
        blocks=(r * n,),
        terms=(Term(unknown=X, left=all_of_it, right=all_of_it),),
        sign=-1,
        weight=loop.weight,
    )
    return (X,), (*_pairwise(loop, (own,), (cross,) if len(a) else ()), whole)


def polya(loop: DoubleSum, degree: int) -> Posed:
    """Every coefficient of (h_1 + ... + h_r)^d sum_ij h_i h_j Theta_ij is negative definite.

    Degree 0 is all pairs; necessary and sufficient as d grows, with (r + d + 1 choose d + 2)
    LMIs.

    Source: Sala and Arino (2007), Fuzzy Sets and Systems 158(24), theorem 5.
    """
    r = loop.rules
    multisets = np.array(list(combinations_with_replacement(range(r), degree + 2)))
    powers = (multisets[:, :, None] == np.arange(r)).sum(axis=1)
    item, i, j, weight = _polya_weights(powers, degree)
    labels = tuple(
        " ".join(f"h{k + 1}" for k in chosen) if degree < 3 else f"powers {tuple(map(int, power))}"
        for chosen, power in zip(multisets, powers, strict=True)
    )
    summand = Summand(i, j, weight, item, factor=r"\sum_{i,j} c^{k}_{ij} ")
    lmi = loop.lmi(
        "product of memberships",
        (summand,),
        count=len(powers),
        labels=labels,
        index=rf"|k| = {degree + 2}",
    )
    return (), (lmi,)


def _polya_weights(
    powers: Indices, degree: int
) -> tuple[Indices, Indices, Indices, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """Return item, i, j and d! / prod_l (k_l - [l = i] - [l = j])! where that is defined."""
    r = powers.shape[1]
    unit = np.eye(r, dtype=np.intp)
    left = powers[:, None, None, :] - unit[:, None, :] - unit[None, :, :]
    item, i, j = np.nonzero((left >= 0).all(axis=3))
    factorials = np.cumprod(np.concatenate([[1.0], np.arange(1.0, degree + 3.0)]))
    weight = factorials[degree] / factorials[left[item, i, j]].prod(axis=1)
    # Divided by the number of orderings of the product, so that all items are of one size.
    orderings = factorials[degree + 2] / factorials[powers].prod(axis=1)
    return item, i, j, weight / orderings[item]


def _slack(loop: DoubleSum, name: str, size: int, count: int = 1) -> Unknown:
    """Return a symmetric slack unknown of its own for each double sum of a condition."""
    return Unknown(_named(loop, name), size, size, symmetric=True, count=count, latex=name)


def _named(loop: DoubleSum, name: str) -> str:
    return f"{loop.name}, {name}" if loop.name else name


def _rules(loop: DoubleSum, slack: tuple[Term, ...] = ()) -> LMI:
    r = loop.rules
    i = np.arange(r)
    return loop.lmi(
        "rule",
        (Summand(i, i, np.ones(r), names=("i", "i")),),
        slack,
        count=r,
        labels=tuple(f"rule {k + 1} of {r}" for k in range(r)),
        index=rf"i = 1, \dots, {r}",
    )


def _pairwise(
    loop: DoubleSum, own: tuple[Term, ...] = (), cross: tuple[Term, ...] = ()
) -> tuple[LMI, ...]:
    """Return Theta_ii + own < 0 and Theta_ij + Theta_ji + cross < 0 for i < j."""
    i, j = np.triu_indices(loop.rules, 1)
    if not len(i):
        return (_rules(loop, own),)
    one = np.ones(len(i))
    pairs = loop.lmi(
        "pair",
        (Summand(i, j, one), Summand(j, i, one, names=("j", "i"))),
        cross,
        count=len(i),
        labels=_pair_labels(i, j),
        index=rf"1 \le i < j \le {loop.rules}",
    )
    return _rules(loop, own), pairs


def _pair_labels(i: Indices, j: Indices) -> tuple[str, ...]:
    return tuple(f"rules {a + 1} and {b + 1}" for a, b in zip(i.tolist(), j.tolist(), strict=True))


RELAXATIONS: Mapping[str, Relaxation] = MappingProxyType(
    {
        "common-gain": common_gain,
        "wang-tanaka-griffin": wang_tanaka_griffin,
        "tanaka-wang": tanaka_wang,
        "tuan": tuan,
        "kim-lee": kim_lee,
        "liu-zhang": liu_zhang,
    }
)
