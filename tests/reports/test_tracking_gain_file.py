"""The gain file of a law that follows a reference, run by the controller of docs/gain-file.md."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant, load_model
from takagi.models.plant.design_settings import PlantSettings
from takagi.reports.simulation.plant import simulate_plant
from tests.reports.test_gain_file_alone import controller, written

K = np.array([[[40.0, 4.0, 1.5, 30.0]]])
STEP = 0.001


@cache
def servo() -> PlantDesign:
    plant = load_model("dc_servo")
    assert isinstance(plant, Plant)
    return certify_plant(plant, K, PlantSettings())


@cache
def run(target: float, end: float) -> Any:
    """The motor by small steps of Euler under the controller: time, states and voltage."""
    with TemporaryDirectory() as folder:
        law = controller(written(dict(servo().document), Path(folder)))
    x, rows = np.zeros(3), []
    for k in range(int(end / STEP)):
        sent = law.sample(STEP, theta=x[0], omega=x[1], i=x[2], target=target)
        V = sent["V"]
        rows.append([k * STEP, *x, V])
        rate = [x[1], (0.01 * x[2] - 0.1 * x[1]) / 0.01, (V - x[2] - 0.01 * x[1]) / 0.5]
        x = x + STEP * np.array(rate)
    return np.array(rows)


def test_the_controller_follows_as_the_simulation_does() -> None:
    """Theta after a jump to 0.2 rad, every half second, to a thousandth of the jump's size."""
    found = run(0.2, 5.0)
    motion = next(
        m
        for m in simulate_plant(
            servo(), starts=[], references=[{"target": 0.2}], duration=5.0
        ).motions
    )
    for time in np.arange(0.5, 5.0, 0.5):
        own = np.interp(time, found[:, 0], found[:, 1])
        assert own == pytest.approx(np.interp(time, motion.time, motion.state[:, 0]), abs=1e-3)
    assert found[-1, 1] == pytest.approx(0.2, abs=1e-2)


@pytest.mark.slow
def test_the_integral_stands_still_while_the_command_is_held() -> None:
    """A jump of 12 rad holds the voltage at 12 V; theta arrives without a turn too much."""
    found = run(12.0, 25.0)

    assert np.abs(found[:, 4]).max() == 12.0
    assert found[-1, 1] == pytest.approx(12.0, abs=0.05)
    assert found[:, 1].max() < 12.0 * 1.25


def test_the_law_in_the_file_says_what_follows_what() -> None:
    law = servo().document["gains"]

    assert law["references"] == [
        {"reference": "target", "integral": "target_integral", "follow": "theta"}
    ]
    assert len(law["K"]) == 1
    assert "premises" not in law
