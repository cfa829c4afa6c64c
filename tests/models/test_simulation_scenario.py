"""Laws side by side: the paper's winds do what the paper says, results come in order."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.models import ModelError, WindObserver
from takagi.models.simulation import (
    BaselineLaw,
    published_scenario,
    published_winds,
    transition_scenario,
    transition_winds,
)
from takagi.models.turbine import nrel5mw, rated_wind


def test_paper_winds_lie_as_the_paper_says() -> None:
    """Schulte (2024): the highest mostly above rated with intervals below, the lowest below."""
    turbine = nrel5mw()
    above = [float(np.mean(w.speed > rated_wind(turbine))) for w in published_winds(turbine)]

    assert above[0] == 0.0
    assert 0.1 < above[1] < 0.9
    assert 0.6 < above[2] < 0.95


def test_transition_winds_cross_rated() -> None:
    """Each of the four passes rated wind."""
    turbine = nrel5mw()
    rated = rated_wind(turbine)
    for wind in transition_winds(turbine):
        assert wind.speed.min() < rated < wind.speed.max(), wind.name


def test_paper_scenario_runs_every_law_in_every_wind() -> None:
    """Two laws, three winds, observer in the loop; rows in order, progress up to 1."""
    turbine = nrel5mw()
    laws = {
        "power": BaselineLaw(turbine),
        "torque": BaselineLaw(turbine, region_3="constant-torque"),
    }
    seen: list[float] = []
    winds = published_winds(turbine, duration=20.0)
    results = published_scenario(
        turbine, laws, observer=WindObserver(turbine, 2.0, 5.0), winds=winds, progress=seen.append
    )
    rows = [result.row() for result in results]

    assert [(row["law"], row["wind"]) for row in rows] == [
        (label, wind.name) for label in laws for wind in winds
    ]
    powers = [float(row["mean electrical power [kW]"]) for row in rows]
    assert powers[0] < powers[1] < powers[2] <= 1.1 * turbine.rated_power / 1e3
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)


@pytest.mark.slow
def test_two_processes_give_the_same_as_one() -> None:
    """Same numbers, same order, and the arrays come back locked."""
    turbine = nrel5mw()
    winds = published_winds(turbine, duration=5.0)
    laws = {"baseline": BaselineLaw(turbine)}
    here, there = (
        published_scenario(turbine, laws, observer=None, winds=winds, processes=count)
        for count in (1, 2)
    )

    assert [result.metrics for result in here] == [result.metrics for result in there]
    assert not there[0].history.pitch.flags.writeable


@pytest.mark.slow
def test_transition_scenario_shows_the_loops_apart() -> None:
    """The reference overspeeds on the step up and on the gust, and not on the step down."""
    turbine = nrel5mw()
    results = transition_scenario(turbine, {"baseline": BaselineLaw(turbine)}, observer=None)
    overspeed = [result.metrics.overspeed for result in results]

    assert overspeed[0] > 3.0
    assert overspeed[1] < 1.0
    assert overspeed[2] > 3.0


def test_misuse_is_told() -> None:
    """No law, no process."""
    with pytest.raises(ModelError, match="no law"):
        published_scenario(nrel5mw(), {}, observer=None)
    with pytest.raises(ModelError, match="0 processes"):
        published_scenario(nrel5mw(), {"b": BaselineLaw(nrel5mw())}, observer=None, processes=0)
