"""Figures in the units of a plant's file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from takagi.models import Plant
from takagi.models.plant.plant import file_unit, rate_in_file_units, time_in_file_units
from takagi.models.plant_files.loader import load_plant

TEXT = """
format = 1
kind = "plant"
[states]
a = {{ unit = "deg", range = [-60, 60] }}
[inputs]
u = {{ unit = "{unit}", range = [-1, 1] }}
[parameters]
k = {{ value = 1, unit = "{per}" }}
[equations]
a = "{right}"
"""


def plant(folder: Path, unit: str = "rad/s", per: str = "-", right: str = "k*u") -> Plant:
    path = folder / "plant.toml"
    path.write_text(TEXT.format(unit=unit, per=per, right=right), encoding="utf-8")
    return load_plant(path)


def test_a_file_s_unit_is_kept_for_words_and_no_part_of_equality(tmp_path: Path) -> None:
    degrees = plant(tmp_path)
    size, unit = file_unit(degrees.states[0])
    assert unit == "deg" and np.isclose(size, np.pi / 180)
    path = tmp_path / "plant.toml"
    text = path.read_text(encoding="utf-8").replace('unit = "-"', 'unit = "%"')
    path.write_text(text.replace("value = 1,", "value = 100,"), encoding="utf-8")
    assert load_plant(path) == degrees


@pytest.mark.parametrize(
    ("unit", "per", "seconds", "shown"),
    [
        ("rad/s", "-", 0.02, (0.02, "s")),
        ("rad/ms", "-", 0.02, (20.0, "ms")),
        ("rad/ms", "-", 2.0, (2.0, "s")),
        ("rad/s", "1/min", 90.0, (1.5, "min")),
        ("rad/min", "1/h", 90.0, (1.5, "min")),
        ("rad/min", "1/h", 7200.0, (2.0, "h")),
        ("rad/s", "1/h", 90.0, (90.0, "s")),
        ("rpm", "-", 90.0, (90.0, "s")),
    ],
)
def test_times_are_in_the_largest_unit_of_the_file_that_fits(
    tmp_path: Path, unit: str, per: str, seconds: float, shown: tuple[float, str]
) -> None:
    found = plant(tmp_path, unit, per, "u" if per == "-" else "u + 0*k*a")
    number, name = time_in_file_units(found, seconds)
    assert np.isclose(number, shown[0]) and name == shown[1]
    rate, unit = rate_in_file_units(found, 1 / seconds)
    assert np.isclose(rate, 1 / shown[0]) and unit == f"1/{shown[1]}"


def test_no_decay_is_no_time(tmp_path: Path) -> None:
    assert rate_in_file_units(plant(tmp_path), 0.0) == (0.0, "1/s")
