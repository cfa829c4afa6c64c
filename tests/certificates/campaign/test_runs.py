"""Campaigns: none of the certified bounds is exceeded inside, and a wrong one is found."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.campaign.motion import BOUNDS
from takagi.certificates.campaign.runs import INSIDE, Campaign, beyond_of, run_campaigns
from takagi.models import ModelError

Run = Callable[..., Campaign]


@pytest.fixture
def campaign(built: Any, tmp_path: Path) -> Run:
    """Run a campaign on the certificate, its claim changed."""

    def run(change: Any = None, beyond: str | None = None, **numbers: Any) -> Campaign:
        document = deepcopy(built.document)
        if change is not None:
            change(document["claims"][0])
        path = tmp_path / "certificate.json"
        path.write_text(json.dumps(document), encoding="utf-8")
        classes = [INSIDE if beyond is None else beyond_of(beyond)]
        numbers = {"runs": 200, "duration": 1.0, "seed": 2, **numbers}
        return run_campaigns(path, tmp_path / "results", classes, workers=1, **numbers)[0]

    return run


def test_no_run_exceeds_a_certified_bound(campaign: Run) -> None:
    """Every bound; peaks are attained by starts; decays where the wind is constant."""
    made = campaign(runs=700, duration=6.0, seed=1)
    largest = np.nanmax(made.share, axis=1)

    assert made.violations == 0
    assert largest[0] > 0.999999
    assert np.all(largest[1:5] > 0.9999)
    assert np.all(largest <= 1)
    assert 0.3 < largest[BOUNDS.index("decay")] <= 1
    assert np.isnan(made.share[-1]).sum() == 700 * 21 // 25
    assert made.events["end_value"].max() < 1


def test_a_run_is_the_same_whatever_is_beside_it(campaign: Run) -> None:
    """With more runs than in one task, and alone; another seed gives others."""
    numbers = ((260, 5), (30, 5), (30, 6))
    many, few, other = (campaign(runs=n, duration=0.2, seed=seed) for n, seed in numbers)

    assert np.array_equal(many.share[:, :30], few.share, equal_nan=True)
    assert not np.array_equal(few.share[0], other.share[0])


@pytest.mark.parametrize(
    ("bound", "change"),
    [
        ("speed error", lambda claim: claim["peaks"].update(speed_error=0.036)),
        ("effort lag", lambda claim: claim["peaks"].update(effort_lag=0.0075)),
        ("speed signal", lambda claim: claim["peaks"].update(speed_signal=0.026)),
        ("integral", lambda claim: claim["peaks"].update(integral=0.026)),
        ("rotor speed", lambda claim: claim["peaks"].update(speed_error=0.03)),
        ("common decay", lambda claim: claim["settling"].update(decay_rate=0.2)),
        ("decay", lambda claim: [cell.update(decay_rate=1.0) for cell in claim["cells"]]),
    ],
)
def test_a_bound_made_too_small_is_found_exceeded(campaign: Run, bound: str, change: Any) -> None:
    """A few percent off a peak, a decay that no loop of the family has."""
    made = campaign(change)

    assert made.violations > 0
    assert made.broken[BOUNDS.index(bound)].any()
    assert (made.events["first"] == BOUNDS.index(bound)).any() or bound == "rotor speed"


def test_a_set_that_is_not_invariant_is_left(campaign: Run) -> None:
    """P with its coupling of speed and integral turned round: still an ellipsoid, not kept."""

    def turned(claim: dict[str, Any]) -> None:
        P = np.array(claim["P"])
        P[0, 2], P[2, 0] = -P[0, 2], -P[2, 0]
        claim["P"] = P.tolist()
        claim["peaks"] = dict.fromkeys(claim["peaks"], 1.0)

    assert campaign(turned).broken[0].mean() > 0.1


def test_beyond_the_class_the_set_is_left_and_starts_come_back(campaign: Run) -> None:
    """Ten times the wind class breaks bounds; from V up to 4 most runs return within seconds."""
    wide = campaign(beyond="10", duration=2.0)
    far = campaign(beyond="start=4", duration=8.0, runs=100)

    assert wide.broken[0].mean() > 0.2
    assert 3.9 < far.share[0].max()
    assert far.broken[0].mean() > 0.7
    # Shown by the inertia that a campaign draws.
    assert campaign(beyond="inertia=0.2:5", duration=4.0).violations > 0
    assert np.mean(far.events["end_value"] <= 1) > 0.4


@pytest.mark.parametrize(
    "text", ["0", "wind=x", "inertia=2", "inertia=2:1", "torque=3", "start=1:2", "start=1", "1e9"]
)
def test_what_lies_beyond_is_asked_for_in_words(text: str) -> None:
    """Anything else is refused, with what is possible."""
    with pytest.raises(ModelError, match=f"--beyond {text}"):
        beyond_of(text)


@pytest.mark.slow
def test_ten_thousand_runs_exceed_nothing(campaign: Run, reduced: bool) -> None:
    """A minute each (reduced: 1000 for 20 s)."""
    runs, duration = (1000, 20.0) if reduced else (10_000, 60.0)

    assert campaign(runs=runs, duration=duration, seed=4).violations == 0
