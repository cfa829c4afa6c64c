"""Campaigns: none of the certified bounds is exceeded inside, and a wrong one is found."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from takagi.certificates.campaign import (
    BOUNDS,
    PLAYERS,
    Campaign,
    beyond_of,
    breaks_of,
    run_campaign,
)
from takagi.models import ModelError


@pytest.fixture(scope="module")
def campaign(built: Any) -> Campaign:
    """Four hundred runs of six seconds, inside."""
    return run_campaign(built.document, runs=400, duration=6.0, seed=1)


def test_no_run_exceeds_a_certified_bound(campaign: Campaign) -> None:
    """Every player, every bound; starts on the boundary; the decays where the wind is constant."""
    records = campaign.records

    assert campaign.violations == 0
    assert np.isinf(records.lost_at).all()
    assert set(records.player) == set(range(len(PLAYERS)))
    assert campaign.largest("set") > 0.999999
    calm = records.player == list(PLAYERS).index("calm")
    for name in ("decay", "common decay"):
        row = records.share[BOUNDS.index(name)]
        assert not np.isnan(row[calm]).any()
        assert np.isnan(row[~calm]).all()
        assert 0.3 < campaign.largest(name) <= 1


def test_steps_half_as_long_change_nothing(campaign: Campaign) -> None:
    """The tolerance is ten times what the steps' length makes."""
    assert not campaign.coarse
    assert 0 < campaign.records.halving.max() < campaign.tolerance / 5


@pytest.mark.slow
def test_same_seed_same_runs(built: Any) -> None:
    """And another seed others."""
    first, same, other = (
        run_campaign(built.document, runs=30, duration=0.2, seed=seed) for seed in (5, 5, 6)
    )
    assert np.array_equal(first.records.share, same.records.share, equal_nan=True)
    assert not np.array_equal(first.records.start_wind, other.records.start_wind)


def _small(built: Any, change: Any) -> Campaign:
    document = deepcopy(built.document)
    change(document["claims"][0])
    return run_campaign(document, runs=200, duration=1.0, seed=2)


@pytest.mark.parametrize(
    ("bound", "change"),
    [
        ("speed error", lambda claim: claim["peaks"].update(speed_error=0.036)),
        pytest.param(
            "effort lag",
            lambda claim: claim["peaks"].update(effort_lag=0.0075),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "speed signal",
            lambda claim: claim["peaks"].update(speed_signal=0.026),
            marks=pytest.mark.slow,
        ),
        ("integral", lambda claim: claim["peaks"].update(integral=0.026)),
        pytest.param(
            "rotor speed",
            lambda claim: claim["peaks"].update(speed_error=0.03),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "common decay",
            lambda claim: claim["settling"].update(decay_rate=0.2),
            marks=pytest.mark.slow,
        ),
        ("decay", lambda claim: [cell.update(decay_rate=1.0) for cell in claim["cells"]]),
    ],
)
def test_a_bound_made_too_small_is_found_exceeded(built: Any, bound: str, change: Any) -> None:
    """A few percent off a peak, a decay that no loop of the family has."""
    found = _small(built, change)

    assert found.violations > 0
    assert bound in {b.bound for b in breaks_of(found)}


@pytest.mark.slow
def test_a_set_that_is_not_invariant_is_left(built: Any) -> None:
    """P with its coupling of speed and integral turned round: still an ellipsoid, not kept."""

    def turned(claim: dict[str, Any]) -> None:
        P = np.array(claim["P"])
        P[0, 2], P[2, 0] = -P[0, 2], -P[2, 0]
        inverse = np.linalg.inv(P)
        rows = {"speed_error": (1, 0, 0), "effort_lag": (0, 1, 0), "speed_signal": (1, 0, -1),
                "integral": (0, 0, 1)}  # fmt: skip
        claim["P"] = P.tolist()
        claim["peaks"] = {
            name: 1.01 * float(np.sqrt(np.array(h) @ inverse @ np.array(h)))
            for name, h in rows.items()
        }

    found = _small(built, turned)
    assert found.broken[0].mean() > 0.1


@pytest.mark.slow
def test_beyond_the_class_the_set_is_left(built: Any) -> None:
    """Ten times the wind class breaks bounds; with the class itself nothing does (above)."""
    found = run_campaign(built.document, runs=200, duration=2.0, seed=3, beyond=beyond_of("10"))
    breaks = {b.bound: b for b in breaks_of(found)}

    assert found.broken[0].mean() > 0.2
    assert breaks["set"].earliest > 0
    low, high = breaks["set"].wind
    assert 3 <= low < high <= 25


@pytest.mark.slow
def test_a_start_beyond_the_set_comes_back(built: Any) -> None:
    """V up to 4 in the certified winds: most runs are in the set a few seconds later."""
    found = run_campaign(
        built.document, runs=100, duration=8.0, seed=3, beyond=beyond_of("start=4")
    )

    assert 3.9 < found.records.start_value.max() <= 4
    assert np.mean(found.records.end_value <= 1) > 0.4


@pytest.mark.parametrize(
    "text", ["0", "wind=x", "inertia=2", "inertia=2:1", "torque=3", "start=1:2"]
)
def test_what_lies_beyond_is_asked_for_in_words(text: str) -> None:
    """Anything else is refused, with what is possible."""
    with pytest.raises(ModelError, match=f"--beyond {text}"):
        beyond_of(text)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"runs": 0}, "0 runs"),
        ({"duration": -1.0}, "duration of -1"),
        ({"seed": -1}, "seed -1"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(
    built: Any, options: dict[str, Any], words: str
) -> None:
    """Each names what was given."""
    with pytest.raises(ModelError, match=words):
        run_campaign(built.document, **options)


def test_another_certificate_is_refused(built: Any) -> None:
    """Without a coherent claim, or with a part missing: in words, no traceback."""
    document = deepcopy(built.document)
    del document["gains"]["trim_effort"]
    with pytest.raises(ModelError, match="trim_effort"):
        run_campaign(document)
    with pytest.raises(ModelError, match="coherent-loop"):
        run_campaign({**built.document, "claims": [{"kind": "decay"}]})


@pytest.mark.slow
def test_ten_thousand_runs_exceed_nothing(built: Any, reduced: bool) -> None:
    """A minute each (reduced: 1000 for 20 s)."""
    runs, duration = (1000, 20.0) if reduced else (10_000, 60.0)
    found = run_campaign(built.document, runs=runs, duration=duration, seed=4)

    assert found.violations == 0
    assert not found.coarse
