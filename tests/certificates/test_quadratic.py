"""Claims about Takagi-Sugeno models: a common quadratic function, and its impossibility."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker import CertificateError, Verdict, check_document
from takagi.certificates.document import certificate_document

Rows = list[list[float]]
# 3 + sqrt(8) and its reciprocal 3 - sqrt(8), to 1e-15.
ROOT_EIGHT = Fraction(isqrt(8 * 10**30), 10**15)
UPPER, LOWER = 3 + ROOT_EIGHT, 3 - ROOT_EIGHT
HAIR = Fraction(1, 10**6)


def verdict(claim: dict[str, Any]) -> Verdict:
    document = certificate_document(
        model={"kind": "takagi-sugeno"}, gains=None, claims=[claim], provenance={}
    )
    return check_document(document).verdict


def pair(a: Fraction) -> list[list[list[Fraction]]]:
    """Return Dayawansa and Martin's planar pair, whose blends are all stable."""
    one = Fraction(1)
    return [[[-one, -one], [one, -one]], [[-one, -a], [1 / a, -one]]]


def scaled(matrices: list[list[list[Fraction]]], a: Fraction) -> list[list[list[int]]]:
    """Return integer multiples: A_i P < 0 keeps its sign under a positive factor per vertex."""
    factor = a.numerator * a.denominator
    return [[[int(entry * factor) for entry in row] for row in M] for M in matrices]


def decay_claim(a: Fraction) -> dict[str, Any]:
    P = [[a.denominator, 0], [0, a.numerator]]
    return {
        "name": "pair",
        "kind": "quadratic-decay",
        "A": scaled(pair(a), a),
        "P": P,
        "decay_rate": 0,
    }


def impossibility_claim(a: Fraction) -> dict[str, Any]:
    """Return the multipliers z_i z_i' with z = (+-t, 1), t near sqrt(a)."""
    t = Fraction(isqrt(int(a * 10**30)), 10**15)
    sign = 1 if a > 1 else -1
    z = [[[sign * t.numerator], [t.denominator]], [[-sign * t.numerator], [t.denominator]]]
    return {
        "name": "pair",
        "kind": "no-common-quadratic",
        "A": scaled(pair(a), a),
        "decay_rate": 0,
        "multiplier_factors": z,
    }


@pytest.mark.parametrize("a", [LOWER + HAIR, Fraction(1), Fraction(3), UPPER - HAIR])
def test_a_common_function_exists_inside_the_thresholds(a: Fraction) -> None:
    """Dayawansa & Martin (1999): one P serves the pair iff 3 - sqrt(8) < a < 3 + sqrt(8).

    P = diag(1, a) does, up to 1e-6 from either threshold.
    """
    a = a.limit_denominator(10**8)

    assert verdict(decay_claim(a)) is Verdict.PROVED
    assert verdict(impossibility_claim(a)) is Verdict.UNDECIDED


@pytest.mark.parametrize("a", [LOWER - HAIR, UPPER + HAIR, Fraction(7), Fraction(1, 50)])
def test_no_common_function_exists_outside_the_thresholds(a: Fraction) -> None:
    """Dayawansa & Martin (1999), from the other side: exact multipliers exclude every P."""
    a = a.limit_denominator(10**8)

    assert verdict(decay_claim(a)) is Verdict.UNDECIDED
    assert verdict(impossibility_claim(a)) is Verdict.DISPROVED


def test_no_decay_rate_beyond_the_slowest_pole() -> None:
    """A = -1 decays at 1 and no faster: from both sides, 1e-12 apart."""
    claim = {"name": "line", "kind": "quadratic-decay", "A": [[[-1]]], "P": [[1]]}
    excluded = {
        "name": "line",
        "kind": "no-common-quadratic",
        "A": [[[-1]]],
        "multiplier_factors": [[[1]]],
    }

    assert verdict(claim | {"decay_rate": 1 - 1e-12}) is Verdict.PROVED
    assert verdict(claim | {"decay_rate": 1}) is Verdict.UNDECIDED
    # V = x^2 is exp(-2 t) V(0): at 1 there is a function, which no strict inequality shows.
    assert verdict(excluded | {"decay_rate": 1}) is Verdict.UNDECIDED
    assert verdict(excluded | {"decay_rate": 1 + 1e-12}) is Verdict.DISPROVED
    assert verdict(excluded | {"decay_rate": 1 - 1e-12}) is Verdict.UNDECIDED
    assert verdict(excluded | {"decay_rate": 1, "multiplier_factors": [[[0]]]}) is Verdict.UNDECIDED


def stable() -> dict[str, Any]:
    """Return two rules with their own gains whose cross terms matter."""
    return {
        "name": "two rules",
        "kind": "quadratic-decay",
        "A": [[[0, 1], [1, 0]], [[0, 1], [2, 0]]],
        "B": [[[0], [1]], [[0], [1]]],
        "K": [[[3, 2]], [[4, 2]]],
        "P": [[3, 1], [1, 2]],
        "decay_rate": 0.2,
    }


@given(st.integers(-40, 40))
def test_powers_of_two_change_nothing(power: int) -> None:
    """V and 2^k V prove the same decay."""
    P = [[entry * 2.0**power for entry in row] for row in stable()["P"]]

    assert verdict(stable() | {"P": P}) is Verdict.PROVED


@pytest.mark.parametrize(
    "change",
    [
        {"P": [[3, 1], [0, 2]]},
        {"P": [[3, 3], [3, 2]]},
        {"P": [[-3, -1], [-1, -2]]},
        {"P": [[0, 0], [0, 0]]},
        {"decay_rate": 2},
        {"decay_rate": -1},
        {"K": [[[3, 2]], [[-4, 2]]]},
        {"K": [[[3, 2]], [[400, 2]]]},
        {"B": [[[0], [1]], [[0], [-1]]]},
        {"A": [[[0, 1], [1, 0]], [[0, 1], [20, 0]]]},
    ],
    ids=str,
)
def test_what_is_false_is_not_proved(change: dict[str, Any]) -> None:
    """Each change makes the claim false, or its P no witness: never PROVED."""
    assert verdict(stable()) is Verdict.PROVED
    assert verdict(stable() | change) is Verdict.UNDECIDED


@pytest.mark.parametrize(
    "change",
    [
        {"P": [[1]]},
        {"P": [[1, 0, 0], [0, 1, 0]]},
        {"P": []},
        {"A": []},
        {"A": [[[0, 1]]]},
        {"A": [[[0, 1], [1, 0]], [[1]]]},
        {"A": "vertices"},
        {"K": [[[3, 2]]]},
        {"K": [[[3]], [[4]]]},
        {"B": [[[0], [1]]]},
        {"B": [[[0]], [[1]]]},
        {"decay_rate": "0.1"},
        {"decay_rate": True},
        {"A": [[[0] * 81] * 81]},
        {"kind": "sampled"},
        {"kind": 1},
        {"name": "two\nlines"},
    ],
    ids=lambda change: str(change)[:40],
)
def test_what_does_not_fit_is_refused(change: dict[str, Any]) -> None:
    """Sizes, types and kinds that fit no claim raise CertificateError, nothing else."""
    with pytest.raises(CertificateError):
        verdict(stable() | change)


def test_missing_parts_are_refused() -> None:
    """Every part that a claim needs is asked for by name."""
    for kind in (stable(), impossibility_claim(Fraction(7))):
        for part in set(kind) - {"K"}:
            claim = {key: value for key, value in kind.items() if key != part}
            with pytest.raises(CertificateError, match=part):
                verdict(claim)
