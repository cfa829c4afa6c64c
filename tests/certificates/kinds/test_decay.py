"""Decay with one quadratic function, continuous and discrete, and why there is none."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.checker.arithmetic.exponential import exp_above, exp_below
from takagi.certificates.requests import Decay
from takagi.models import ModelError, TSModel
from tests.certificates.kinds.claims import law_data, model_data, said_of, verdict_of

Data = dict[str, Any]


def pair(a: float) -> list[list[list[float]]]:
    """Return Dayawansa and Martin's pair; the second vertex is scaled by a > 0, as V' is too."""
    return [[[-1, -1], [1, -1]], [[-a, -a * a], [1, -a]]]


def closed() -> tuple[Data, Data, Data]:
    """Return two rules with their own gains, whose cross terms matter, and a claim that holds."""
    model = model_data([[[0, 1], [1, 0]], [[0, 1], [2, 0]]], B=[[[0], [1]], [[0], [1.1]]])
    claim = {"name": "loop", "kind": "decay", "P": [[3, 1], [1, 2]], "decay_rate": 0.2}
    return model, law_data([[[3, 2]], [[4, 2]]]), claim


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


def test_no_faster_decay_of_a_sampled_line() -> None:
    """The same limit for the exact no, by multipliers and by one blend alone."""
    model, _ = sampled()
    no = {"name": "line", "kind": "no-common-decay"}
    kinds = ({"multipliers": [{"blend": 0, "factor": [[1]]}]}, {"blend": 0, "P": [[-1]]})

    for evidence in kinds:
        claim = no | evidence
        for above in (0.693147180559946, 0.7):
            assert verdict_of(model, None, claim | {"decay_rate": above}) == "DISPROVED"
        for below in (0, 0.5, 0.693147180559945):
            assert verdict_of(model, None, claim | {"decay_rate": below}) == "UNDECIDED"


@pytest.mark.parametrize(
    ("a", "verdict"),
    [
        (5.828427, Verdict.PROVED),
        (5.828428, Verdict.DISPROVED),
        (0.1715729, Verdict.PROVED),
        (0.1715728, Verdict.DISPROVED),
    ],
)
def test_a_pair_is_decided_at_its_thresholds(a: float, verdict: Verdict) -> None:
    """Dayawansa & Martin (1999): one P serves iff 3 - sqrt(8) < a < 3 + sqrt(8) = 5.8284271..."""
    root = float(np.sqrt(a))
    decay = {"name": "pair", "kind": "decay", "P": [[1, 0], [0, a]], "decay_rate": 0}
    sign = 1 if a > 1 else -1
    listed = [
        {"blend": 0, "factor": [[sign * root], [1]]},
        {"blend": 1, "factor": [[-sign], [1 / root]]},
    ]
    no = {"name": "pair", "kind": "no-common-decay", "decay_rate": 0, "multipliers": listed}
    claim = decay if verdict is Verdict.PROVED else no

    assert verdict_of(model_data(pair(a)), None, claim) == verdict.name
    other = no if verdict is Verdict.PROVED else decay
    assert verdict_of(model_data(pair(a)), None, other) == "UNDECIDED"


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


def test_an_unsymmetric_matrix_shows_nothing() -> None:
    """-(PG + G'P') > 0 holds for it though G is stable: neither a proof nor a disproof."""
    model = model_data([[[-1, 0], [0, -1]]])
    P = [[1, 0.1], [0, 1]]
    decay = {"name": "x", "kind": "decay", "decay_rate": 0, "P": P}
    no = {"name": "x", "kind": "no-common-decay", "decay_rate": 0, "blend": 0, "P": P}

    assert verdict_of(model, None, decay) == "UNDECIDED"
    assert verdict_of(model, None, no) == "UNDECIDED"


@pytest.mark.parametrize(
    ("where", "change"),
    [
        ("claim", {"P": [[3, 1], [0, 2]]}),
        ("claim", {"P": [[3, 3], [3, 2]]}),
        ("claim", {"P": [[-3, -1], [-1, -2]]}),
        ("claim", {"P": [[0, 0], [0, 0]]}),
        ("claim", {"decay_rate": 2}),
        ("claim", {"decay_rate": -1}),
        ("gains", {"K": [[[3, 2]], [[-4, 2]]]}),
        ("gains", {"K": [[[3, 2]], [[400, 2]]]}),
        ("gains", {"K": [[[0, 0]]]}),
        ("model", {"B": [[[0], [1]], [[0], [-1]]]}),
        ("model", {"A": [[[0, 1], [1, 0]], [[0, 1], [20, 0]]]}),
    ],
    ids=str,
)
def test_what_is_false_is_not_proved(where: str, change: Data) -> None:
    """Each change makes the claim false, or its P no witness: never PROVED."""
    model, gains, claim = closed()
    assert verdict_of(model, gains, claim) == "PROVED"

    parts = {"model": model, "gains": gains, "claim": claim}
    parts[where] = parts[where] | change
    assert verdict_of(parts["model"], parts["gains"], parts["claim"]) == "UNDECIDED"


@pytest.mark.parametrize(
    ("where", "change"),
    [
        ("claim", {"P": [[1]]}),
        ("claim", {"P": None}),
        ("claim", {"decay_rate": "0.1"}),
        ("gains", {"K": [[[3, 2, 1]]]}),
        ("gains", {"K": []}),
        ("gains", {"sample_time": 1}),
        ("gains", {"state_names": ["x2 [-]", "x1 [-]"]}),
        ("gains", {"state_names": [1, 2]}),
        ("model", {"A": [[[0, 1]]]}),
        ("model", {"A": [[[0, 1], [1, 0]]] * 3}),
        ("model", {"B": [[[0]]]}),
        ("model", {"sample_time": 0}),
        ("model", {"sample_time": -1}),
        ("model", {"state_names": ["a"]}),
        ("model", {"state_names": ["a", "a"]}),
        ("model", {"rules": [[0], [0]]}),
        ("model", {"rules": [[0], [2]]}),
        ("model", {"rules": [[0]]}),
        ("model", {"box": {"x1 [-]": [1, -1]}}),
        ("model", {"box": []}),
        ("model", {"kind": "sampled"}),
    ],
    ids=lambda change: str(change)[:40],
)
def test_what_does_not_fit_is_refused(where: str, change: Data) -> None:
    """Sizes, types and names that fit no loop raise CertificateError, nothing else."""
    model, gains, claim = closed()
    parts = {"model": model, "gains": gains, "claim": claim}
    parts[where] = parts[where] | change

    with pytest.raises(CertificateError):
        said_of(**parts)


def test_a_law_with_weights_of_its_own_is_checked_pair_by_pair() -> None:
    """G_12 = 1 is unstable, its mean with G_21 = -3 is not: the law's weights decide."""
    model = model_data([[[0]], [[2]]], B=[[[1]], [[1.5]]])
    gains = law_data([[[1]], [[2]]])
    claim = {"name": "x", "kind": "decay", "decay_rate": 0, "P": [[1]]}
    own = [{"name": "z", "lower": 0, "upper": 1, "unit": "-"}]
    model["A"][1] = [[2.4]]

    assert verdict_of(model, gains, claim) == "PROVED"
    assert verdict_of(model, gains | {"premises": own}, claim) == "UNDECIDED"
    assert verdict_of(model | {"premises": own}, gains, claim) == "UNDECIDED"
    both = model | {"premises": own}, gains | {"premises": own}
    assert verdict_of(*both, claim) == "PROVED"
    wider = [own[0] | {"upper": 1.1}]
    assert verdict_of(both[0], gains | {"premises": wider}, claim) == "UNDECIDED"


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


def test_misuse_is_refused() -> None:
    """A negative rate, claims beside a rate, gains of another shape: the error says what to do."""
    model = TSModel([[[-1.0]]], [[[1.0]]])
    with pytest.raises(ModelError, match="a number >= 0"):
        certify(model, decay_rate=-1)
    with pytest.raises(ModelError, match="claims"):
        certify(model, decay_rate=1, claims=[Decay()])
    with pytest.raises(ModelError, match="at least one"):
        certify(model, claims=[])
    with pytest.raises(ModelError, match="shape"):
        certify(model, gains=[[[1, 2]]])


@pytest.mark.parametrize(("d", "verdict"), [(1e-24, "PROVED"), (0, "UNDECIDED")])
def test_stability_of_samples_is_not_rounded(d: float, verdict: str) -> None:
    """z^2 = z - d^2 has a root about 1 - d^2 = 1 - 10^-48: e^0 rounded down would be less."""
    model = model_data([[[1, -d], [d, 0]]], sample_time=1)
    claim = {"name": "x", "kind": "decay", "P": [[1, -d], [-d, 1]], "decay_rate": 0}

    assert verdict_of(model, None, claim) == verdict
    assert verdict_of(model, None, claim | {"decay_rate": 1e-40}) == "UNDECIDED"
