"""The wish --settle as a decay rate, and what is refused of it."""

from __future__ import annotations

import math

import pytest

from takagi.cli.options.plant_options import plant_settings
from takagi.models import ModelError
from takagi.models.plant_files.loader import PlantFile

SPRING = PlantFile.of("mass_spring_damper")


@pytest.mark.parametrize("written", ["2s", "2", "2000 ms"])
def test_a_settling_time_is_the_rate_that_leaves_two_percent(written: str) -> None:
    rate = plant_settings(SPRING, {"settle": written}).decay_rate

    assert isinstance(rate, float) and math.isclose(math.exp(-2 * rate), 0.02)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"settle": "0s"}, "a time above 0"),
        ({"settle": "2kg"}, "option --settle 2kg: 'kg' is no unit of time"),
        ({"settle": "soon"}, "a time such as"),
        ({"settle": "2s", "decay_rate": "1"}, "leave one out"),
    ],
)
def test_no_time_is_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        plant_settings(SPRING, given)
