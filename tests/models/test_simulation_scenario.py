"""One law in one wind, and the paper's winds, which do what the paper says."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.models import WindObserver
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.scenario import measure, published_winds
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import step_wind
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import rated_wind


def test_paper_winds_lie_as_the_paper_says() -> None:
    """Schulte (2024): the highest mostly above rated with intervals below, the lowest below."""
    turbine = nrel5mw()
    above = [float(np.mean(w.speed > rated_wind(turbine))) for w in published_winds(turbine)]

    assert above[0] == 0.0
    assert 0.1 < above[1] < 0.9
    assert 0.6 < above[2] < 0.95


def test_a_case_is_measured_from_its_first_wind_on() -> None:
    """More wind gives more power; observer in the loop, progress up to 1."""
    turbine = nrel5mw()
    plant, observer = validation_plant(turbine), WindObserver(turbine, 2.0, 5.0)
    seen: list[float] = []
    law, results = BaselineLaw(turbine), []
    for wind in published_winds(turbine, 20.0):
        history = simulate(plant, law, wind, observer=observer, progress=seen.append)
        results.append(measure(history, turbine))
    powers = [result.mean_power for result in results]

    assert [result.duration for result in results] == pytest.approx([20.0] * 3)
    assert powers[0] < powers[1] < powers[2] <= 1.1 * turbine.rated_power / 1e3
    assert seen[-1] == pytest.approx(1.0)


@pytest.mark.slow
def test_the_reference_overspeeds_on_the_step_up_and_not_on_the_step_down() -> None:
    turbine = nrel5mw()
    plant, law, rated = validation_plant(turbine), BaselineLaw(turbine), rated_wind(turbine)
    winds = [step_wind(rated - sign * 1.5, rated + sign * 1.5, 120) for sign in (1, -1)]
    up, down = (measure(simulate(plant, law, wind), turbine) for wind in winds)

    assert up.overspeed > 3.0
    assert down.overspeed < 1.0
