"""Peaks under bounded disturbance: exact thresholds, a simulation, and claims that are false."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.requests import Peak
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import TSModel
from tests.certificates.kinds.claims import model_data, said_of, verdict_of, verdicts

Data = dict[str, Any]


def line() -> tuple[Data, Data]:
    """Return x' = -2 x + w, y = x: |y| <= sup |w| / 2, reached at last by w = 1, and a claim."""
    model = model_data([[[-2]]], E=[[[1]]], C=[[[1]]])
    claim = {"name": "line", "kind": "peak", "disturbance": "disturbances", "disturbance_norm": 1}
    return model, claim | {"gain": 0.5, "P": [[1]], "level": 0.25, "multiplier": 2}


def sampled() -> tuple[Data, Data]:
    """Return x+ = x/2 + w, y = x: |y| <= 2 sup |w|, reached at last by w = 1, and a claim."""
    model = model_data([[[0.5]]], E=[[[1]]], C=[[[1]]], sample_time=0.1)
    claim = {"name": "line", "kind": "peak", "disturbance": "disturbances", "disturbance_norm": 1}
    return model, claim | {"gain": 2, "P": [[1]], "level": 4, "multiplier": 0.5}


@pytest.mark.parametrize("case", [line, sampled])
def test_peak_at_its_exact_value_and_below(case: Any) -> None:
    """1/a and 1/(1 - a): the bound is reached, so it is proved itself, and nothing less is."""
    model, claim = case()
    less = 1 - 1e-12

    assert verdict_of(model, None, claim) == "PROVED"
    for key in ("gain", "level"):
        mutant = claim | {key: claim[key] * less}
        assert verdict_of(model, None, mutant) == "UNDECIDED"
    more = claim | {"disturbance_norm": 1 + 1e-12}
    assert verdict_of(model, None, more) == "UNDECIDED"


@pytest.mark.parametrize("case", [line, sampled])
def test_other_multipliers_show_less(case: Any) -> None:
    model, claim = case()

    for factor in (0.9, 1.1):
        mutant = claim | {"multiplier": claim["multiplier"] * factor}
        assert verdict_of(model, None, mutant) == "UNDECIDED"


def test_larger_disturbances_make_larger_sets() -> None:
    """Everything scales: w three times as large, the level nine times, the gain the same."""
    model, claim = line()

    assert verdict_of(model, None, claim | {"disturbance_norm": 3, "level": 2.25}) == "PROVED"


def test_disturbances_together_are_a_ball() -> None:
    """|w1 + w2| <= sqrt(2) for |w|_2 <= 1: x^2 <= 2 / 4, at the limit itself."""
    model, claim = line()
    two = model | {"E": [[[1, 1]]]}
    claim |= {"level": 0.5, "gain": 0.70711}

    assert verdict_of(two, None, claim) == "PROVED"
    assert verdict_of(two, None, claim | {"level": 0.4999}) == "UNDECIDED"
    assert verdict_of(two, None, claim | {"gain": 0.7071}) == "UNDECIDED"


def test_feedthrough_takes_its_share() -> None:
    """y = x + w of x' = -2 x + w peaks at 3/2: c / (1 - t) + 1 / t is 9/4 at least, at t = 2/3."""
    model, claim = line()
    through = claim | {"output": {"C": [[[1]]], "F": [[[1]]]}, "gain": 1.5}
    third = 0.666666666666

    assert verdict_of(model, None, through | {"gain": 1.5000001, "share": third}) == "PROVED"
    assert verdict_of(model, None, through | {"gain": 1.4999999, "share": third}) == "UNDECIDED"
    assert verdict_of(model, None, through | {"gain": 1.5000001}) == "UNDECIDED"


def test_feedthrough_to_one_output_of_three() -> None:
    """Beside it a second state, which is another output, and an output that is always zero."""
    model = model_data([[[-2, 0], [0, -2]]], E=[[[1], [0]]])
    output = {"C": [[[1, 0], [0, 1], [0, 0]]], "F": [[[1], [0], [0]]]}
    claim = line()[1] | {"P": [[1, 0], [0, 1]], "output": output, "share": 0.666666666666}

    assert verdict_of(model, None, claim | {"gain": 1.5000001}) == "PROVED"
    assert verdict_of(model, None, claim | {"gain": 1.4999999}) == "UNDECIDED"


def test_two_disturbances_one_of_them_direct() -> None:
    """y = x + [1, 0] w: |x| <= sqrt(1/2) and |w1| <= 1 add up to no more than their bound."""
    model, claim = line()
    two = model | {"E": [[[1, 1]]]}
    claim |= {"level": 0.5, "output": {"C": [[[1]]], "F": [[[1, 0]]]}, "share": 0.58578644}
    least = 1 + 0.5**0.5

    assert verdict_of(two, None, claim | {"gain": least * (1 + 1e-7)}) == "PROVED"
    assert verdict_of(two, None, claim | {"gain": least * (1 - 1e-7)}) == "UNDECIDED"


def test_set_must_lie_in_the_box() -> None:
    model, claim = line()

    assert verdict_of(model | {"box": {"x1 [-]": [-0.5, 9]}}, None, claim) == "PROVED"
    found = said_of(model | {"box": {"x1 [-]": [-9, 0.4999999]}}, None, claim)
    assert found.verdict is Verdict.UNDECIDED
    assert "x1" in found.text


def test_disturbance_must_lie_in_its_range() -> None:
    model, claim = line()
    named = model | {"disturbance_names": ["w [-]"]}

    assert verdict_of(named | {"box": {"w [-]": [-1, 1]}}, None, claim) == "PROVED"
    for side in ([-0.999, 2], [0.5, 3]):
        found = said_of(named | {"box": {"w [-]": side}}, None, claim)
        assert found.verdict is Verdict.UNDECIDED


@pytest.mark.parametrize(
    "changed",
    [
        {"disturbance_norm": 0},
        {"level": 0},
        {"multiplier": -1},
        {"share": 1.5},
        {"gain": -1},
    ],
)
def test_what_makes_no_sense_is_refused(changed: Data) -> None:
    model, claim = line()

    with pytest.raises(CertificateError):
        said_of(model, None, claim | changed)


def test_more_than_all_is_no_share_of_a_sample() -> None:
    model, claim = sampled()

    with pytest.raises(CertificateError, match="at most 1"):
        said_of(model, None, claim | {"multiplier": 1.01})


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
matrices = st.lists(numbers, min_size=4, max_size=4).map(lambda v: np.reshape(v, (2, 2)))


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(matrices, matrices, st.booleans())
def test_proved_peak_holds_in_simulation(first: Any, second: Any, discrete: bool) -> None:
    """Blends that jump and a disturbance of full size that switches never exceed the bound."""
    step = 0.01
    A = np.array([M * 0.4 if discrete else M - 2.5 * np.eye(2) for M in (first, second)])
    model = TSModel(
        A,
        C=[[[1.0, 0.3]], [[0.7, -0.2]]],
        E=[[[1.0], [0.5]], [[0.8], [-0.5]]],
        sample_time=0.1 if discrete else None,
    )
    attempt = Peak().attempt(ClaimedLoop.of(model))
    assert attempt.proved

    draw = np.random.default_rng(1)
    x, most = np.zeros(2), 0.0
    for _ in range(1000):
        h = draw.dirichlet([0.3, 0.3])
        w = draw.choice([-1.0, 1.0]) * attempt.claim["disturbance_norm"]
        moved = np.einsum("i,ijk,k->j", h, model.A, x) + h @ model.E[:, :, 0] * w
        x = moved if discrete else x + step * moved
        most = max(most, abs(float(h @ model.C[:, 0] @ x)))
    assert most <= attempt.claim["gain"] * attempt.claim["disturbance_norm"] * 1.01


@pytest.mark.parametrize(("gain", "verdict"), [(2, "PROVED"), (1.9999, "UNDECIDED")])
def test_a_disturbance_that_reaches_the_output_directly(gain: float, verdict: str) -> None:
    """x' = -x + w with |w| <= 1 keeps |x| <= 1, so that y = x + w reaches 2."""
    model = model_data([[[-1]]], E=[[[1]]])
    claim = {"name": "p", "kind": "peak", "P": [[1]], "level": 1, "multiplier": 1, "share": 0.5}
    claim |= {"disturbance": "disturbances", "disturbance_norm": 1, "gain": gain}
    claim |= {"output": {"C": [[[1]]], "F": [[[1]]]}}
    document = certificate_document(model=model, gains=None, claims=[claim], provenance={})

    assert verdicts(document) == [verdict]
