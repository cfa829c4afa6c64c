"""Decay with one quadratic function, continuous and discrete, and why there is none."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.arithmetic.exponential import exp_above, exp_below
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, model_data, verdict_of


def sampled() -> tuple[Data, Data]:
    """Return x+ = 0.5 x with T = 1 s, which decays at ln 2 = 0.693147180559945... 1/s."""
    claim = {"name": "line", "kind": "decay", "P": [[1]], "decay_rate": 0}
    return model_data([[[0.5]]], sample_time=1), claim


def test_a_sampled_line_decays_at_the_logarithm_of_two() -> None:
    """From both sides, 2e-15 apart: ln 2 = 0.69314718055994530941... (OEIS A002162)."""
    model, claim = sampled()

    for below in (0, 0.5, 0.693147180559945):
        assert verdict_of(model, None, claim | {"decay_rate": below}) == "PROVED"
    for above in (0.693147180559946, 0.7, 5):
        assert verdict_of(model, None, claim | {"decay_rate": above}) == "UNDECIDED"


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_found_rates_are_proved_and_faster_ones_are_not(sample_time: float | None) -> None:
    """A = diag(-1, -2) decays at 1 1/s and no faster, sampled or not: eigenvalues say so."""
    A = np.diag([-1.0, -2.0])
    step = A if sample_time is None else np.diag(np.exp(np.diag(A) * sample_time))
    model = TSModel([step], sample_time=sample_time)

    found = certify(model)
    assert found.verdict is Verdict.PROVED
    assert 0.99 < found.document["claims"][0]["decay_rate"] < 1
    assert certify(model, decay_rate=0.99).verdict is Verdict.PROVED
    assert certify(model, decay_rate=1.01).verdict is Verdict.DISPROVED


@pytest.mark.parametrize("sample_time", [None, 0.01])
def test_a_state_that_decays_by_itself_hides_nothing(sample_time: float | None) -> None:
    """Dayawansa and Martin's pair beyond its threshold, beside a stable state."""
    A = np.zeros((2, 3, 3))
    A[:, :2, :2] = [[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -8.0], [0.125, -1.0]]]
    A[:, 2, 2] = -1.0
    if sample_time is not None:
        A = np.eye(3) + sample_time * A
    model = TSModel(A, sample_time=sample_time)

    assert certify(model, decay_rate=0).verdict is Verdict.DISPROVED


@given(st.fractions(0, 300, max_denominator=10**9))
def test_bounds_of_the_exponential_enclose_it(x: Fraction) -> None:
    """Against 90 digits of Python's decimal module; never farther than 1e-40 apart."""
    low, high = exp_below(x), exp_above(x)
    with localcontext() as context:
        context.prec = 90
        value = Fraction((-Decimal(x.numerator) / Decimal(x.denominator)).exp())

    assert low < value * (1 + Fraction(1, 10**80))
    assert value * (1 - Fraction(1, 10**80)) < high
    assert high - low < Fraction(1, 10**40)


def test_rates_beyond_all_numbers_are_an_answer() -> None:
    """A loop at rest after one step, and a rate that no number of the checker reaches."""
    model = TSModel([[[0.0, 1.0], [0.0, 0.0]]], sample_time=1.0)

    assert certify(model).verdict is Verdict.PROVED
    assert certify(model, decay_rate=1e9).verdict is Verdict.UNDECIDED
    assert certify(TSModel([[[0.5]]], sample_time=1.0), decay_rate=1e9).verdict is (
        Verdict.DISPROVED
    )


def test_an_input_without_effect_changes_nothing() -> None:
    """B = 0 is written, so that gains have something to be gains of."""
    model = TSModel([[[-1.0]]], [[[0.0]]])

    assert certify(model, [[5.0]], decay_rate=0.9).verdict is Verdict.PROVED
    assert certify(model, [[5.0]], decay_rate=1.1).verdict is Verdict.DISPROVED
