"""Decay with one quadratic function and its transients, and what excludes such a function."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.arithmetic.exponential import exp_above, exp_below
from takagi.certificates.requests import Transient
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, law_data, model_data, verdict_of


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
    if sample_time is None:
        assert certify(model, decay_rate=1.0).verdict is Verdict.UNDECIDED
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


ALONE: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0, "P": [[-1]]}


def opposed(s: float) -> tuple[TSModel, list[list[list[float]]]]:
    """Return one state and two rules with G_11 = G_22 = -1 and G_12 + G_21 = s - 2.

    G(h) = -1 + s h_1 h_2: every blend falls exactly where s < 4, the mean of the pair where s < 2.
    """
    K = [[[0.0]], [[s]]]
    return TSModel([[[-1.0]], [[2 * s - 1]]], [[[1.0]], [[2.0]]]), K


@pytest.mark.parametrize("s", [2.1, 3.0, 3.999])
def test_a_loop_whose_blends_all_fall_is_not_disproved(s: float) -> None:
    """V = x^2 falls along every blend, V' <= -(4 - s)/2 V, though the mean of the pair grows."""
    model, K = opposed(s)

    assert certify(model, K, decay_rate=0).verdict is not Verdict.DISPROVED
    assert certify(model, K).verdict is not Verdict.DISPROVED


def test_a_blend_is_decided_at_its_threshold() -> None:
    """At h = (1/2, 1/2), and at (1/3, 2/3), where G = -1 + 2 s / 9."""
    for shares, edge in (([1, 1], 4), ([1, 2], 4.5), ([0.5, 1], 4.5)):
        claim = ALONE | {"blend": [shares]}
        for s, verdict in ((edge + 0.001, "DISPROVED"), (edge - 0.001, "UNDECIDED")):
            model, K = opposed(s)
            data = model_data(model.A.tolist(), B=model.B.tolist())
            assert verdict_of(data, law_data(K), claim) == verdict


def plane() -> tuple[Data, Data]:
    """Return x' = -x in the plane, and a claim with the exact overshoot 2 of P = diag(1, 4)."""
    claim = {"name": "plane", "kind": "transient", "P": [[1, 0], [0, 4]], "decay_rate": 0.999}
    sizes = {"scales": [1, 1], "lower": 1, "overshoot": 2}
    return model_data([[[-1, 0], [0, -1]]]), claim | sizes | {
        "settled_share": 0.02,
        "settling_time": 4.6099,
    }


def test_overshoot_at_its_exact_limit() -> None:
    """kappa^2 is the condition number of P."""
    model, claim = plane()

    assert verdict_of(model, None, claim) == "PROVED"
    for mutant in ({"overshoot": 1.999999}, {"lower": 1.000001}, {"lower": 0.999999}):
        assert verdict_of(model, None, claim | mutant) == "UNDECIDED"


def test_settling_time_from_both_sides() -> None:
    """2 e^(-0.999 t) = 0.02 at t = ln(100) / 0.999 = 4.609779965..."""
    model, claim = plane()

    after = claim | {"settling_time": 4.60977997}
    before = claim | {"settling_time": 4.60977996}
    assert verdict_of(model, None, after) == "PROVED"
    assert verdict_of(model, None, before) == "UNDECIDED"


@pytest.mark.parametrize("discrete", [False, True])
def test_found_bound_holds_in_simulation(discrete: bool) -> None:
    """Blends that jump; the state over its bound stays below one, and has settled in time."""
    A = np.array([[[0.0, 1.0], [-2.0, -1.0]], [[0.0, 1.0], [-3.0, -2.0]]])
    step = 0.05 if discrete else 0.01
    A = np.eye(2) + step * A if discrete else A
    attempt = Transient().attempt(
        ClaimedLoop.of(TSModel(A, sample_time=step if discrete else None))
    )
    assert attempt.proved
    claim = attempt.claim

    draw = np.random.default_rng(4)
    steps = int(np.ceil(claim["settling_time"] / step))
    for _ in range(20):
        x = draw.normal(size=2)
        start = np.linalg.norm(x)
        for k in range(1, steps + 1):
            moved = np.einsum("i,ijk,k->j", draw.dirichlet([0.3, 0.3]), A, x)
            x = moved if discrete else x + step * moved
            bound = claim["overshoot"] * np.exp(-claim["decay_rate"] * k * step)
            assert np.linalg.norm(x) <= bound * start * 1.02
        assert np.linalg.norm(x) <= claim["settled_share"] * start * 1.02


def test_loop_without_decay_is_not_claimed() -> None:
    for step in (None, 0.3):
        attempt = Transient().attempt(ClaimedLoop.of(TSModel([[[1.0]]], sample_time=step)))
        assert attempt.checked.verdict is Verdict.UNDECIDED
