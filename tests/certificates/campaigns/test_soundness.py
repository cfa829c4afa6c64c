"""No verdict is false on problems whose truth is known; reduced forms of the campaign."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parents[3]
campaign: Any = import_module("soundness")
LOOPS: dict[str, Any] = campaign.LOOPS
CLAIMS: dict[str, Any] = campaign.DIRECT
# Evidence that cannot fit: multipliers are thrown blindly there.
BLIND = {"multipliers against pairs", "single blends against decay"}


@pytest.mark.slow
@pytest.mark.parametrize("name", CLAIMS)
def test_claims_with_closed_forms(name: str) -> None:
    """Best evidence and wrong evidence, on both sides of the limit: true is proved, false never."""
    counts = campaign.family_of_claims(CLAIMS[name], np.random.default_rng(7), 240)

    assert counts["false proved"] == counts["false disproved"] == 0
    if name not in BLIND:
        assert counts["fitting proved"] > 0.2 * counts["fitting"] > 0
        assert counts["number"] > counts["true"]


def test_a_slack_that_is_no_share_of_the_range_would_be_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With the absolute 1e-12 of earlier releases laws of another rest are counted as false."""
    from takagi.certificates.checker.plant import trim

    family = campaign.ANSWERS["laws that rest beside the plant"]
    honest = campaign.family_of_answers(family, np.random.default_rng(4), 100)
    monkeypatch.setattr(trim, "allowed", lambda variable, stated: Fraction(1, 10**12))
    absolute = campaign.family_of_answers(family, np.random.default_rng(4), 100)

    assert honest["false proved"] == 0 < honest["PROVED"] < honest["number"]
    assert absolute["false proved"] > 0


def test_a_false_verdict_would_be_seen() -> None:
    """The count of false verdicts is of the truth, not of what was said: turn the truth round."""

    def turned(rng: np.random.Generator) -> Any:
        return [known._replace(truth=not known.truth) for known in CLAIMS["gain of energy"](rng)]

    counts = campaign.family_of_claims(turned, np.random.default_rng(9), 100)

    assert counts["false proved"] > 0


@pytest.mark.slow
def test_the_campaign_finds_nothing_false(reduced: bool) -> None:
    """As ``make campaigns`` runs it, with another seed; reduced: one in forty."""
    count = "600" if reduced else "24000"
    command = [sys.executable, "benchmarks/soundness.py", "--count", count, "--seed", "2"]

    ran = subprocess.run([*command, "--print-only"], cwd=ROOT, capture_output=True, text=True)

    assert ran.returncode == 0, ran.stdout + ran.stderr


truth: Any = import_module("exact_truth")
reading: Any = import_module("second_reading")
Rows = list[list[Fraction]]
ENTRIES = st.integers(-20, 20).map(lambda k: Fraction(k, 10))


def squares(n: int) -> st.SearchStrategy[Rows]:
    row = st.lists(ENTRIES, min_size=n, max_size=n)
    return st.lists(row, min_size=n, max_size=n)


def rows(*values: tuple[str, ...]) -> Rows:
    return [[Fraction(v) for v in row] for row in values]


@pytest.mark.parametrize(("lam", "expected"), [("9.65685424", True), ("9.65685425", False)])
def test_pair_of_shorten_and_narendra(lam: str, expected: bool) -> None:
    """Shorten & Narendra (2002): one P iff lam < 4 + 4 sqrt(2) = 9.656854249..."""
    A = rows(("-2", "4"), ("-1", "-2"))
    B = rows(("-2", "4"), (str(-1 - Fraction(lam)), "-2"))

    assert truth.pair_has_function(A, B) is expected
    assert truth.rank_one_pair_has_function(A, B) is expected


@pytest.mark.parametrize(("a", "expected"), [("5.828427", True), ("5.828428", False)])
def test_pair_of_dayawansa_and_martin(a: str, expected: bool) -> None:
    inverse = str(1 / Fraction(a))
    A, B = rows(("-1", "-1"), ("1", "-1")), rows(("-1", f"-{a}"), (inverse, "-1"))

    assert truth.pair_has_function(A, B) is expected


@given(st.integers(1, 4).flatmap(squares))
def test_stability_agrees_with_eigenvalues(A: Rows) -> None:
    """Away from the edge floats decide the same, in both times."""
    values = np.linalg.eigvals(np.array(A, dtype=float))
    if abs(values.real.max()) > 1e-3:
        assert truth.is_hurwitz(A) == (values.real.max() < 0)
    if abs(np.abs(values).max() - 1) > 1e-3:
        assert truth.is_schur(A) == (np.abs(values).max() < 1)


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=5))
def test_negative_roots_are_counted_once(roots: list[int]) -> None:
    """Of (s - r_1)(s - r_2)...; repeated roots and 0 included."""
    polynomial = [Fraction(1)]
    for r in roots:
        shifted = [*polynomial, Fraction(0)]
        for i, c in enumerate(polynomial):
            shifted[i + 1] -= r * c
        polynomial = shifted

    assert truth.negative_roots(polynomial) == len({r for r in roots if r < 0})


def test_complex_roots_are_not_counted() -> None:
    """(s^2 + 1)(s + 2) has one negative real root."""
    assert truth.negative_roots([Fraction(c) for c in (1, 2, 1, 2)]) == 1


def test_exponentials_to_fifty_digits() -> None:
    """e^-1 = 0.36787944117144232159552377016146086744581113103176..., from both sides."""
    digits = 36787944117144232159552377016146086744581113103
    assert truth.is_at_most_exp(Fraction(digits, 10**47), Fraction(1))
    assert not truth.is_at_most_exp(Fraction(digits + 1, 10**47), Fraction(1))


@given(st.integers(1, 4).flatmap(squares))
def test_definiteness_by_the_characteristic_polynomial(A: Rows) -> None:
    """A A' is semidefinite, definite iff A is regular; less its trace times I neither."""
    M = reading.matrix(A)
    square = M * M.transpose()
    trace = sum((square[k, k] for k in range(len(A))), reading.rational(0))

    assert reading.is_semidefinite(square)
    assert reading.is_definite(square) == (M.det() != 0)
    assert not reading.is_definite(square - reading.identity(len(A), trace))
    assert reading.is_semidefinite(square - reading.identity(len(A), trace)) == (
        len(A) == 1 or trace == 0
    )
