"""The norm that is asked of a design: rows, units and scale, and limits beside white noise."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.norm_wish import NormWish, norm_wish
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import sector_model
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import Plant
from takagi.models.plant_files.loader import load_plant

PENDULUM = """
format = 1
kind = "plant"

[states]
theta = { unit = "deg", range = [-60, 60] }
omega = { unit = "rad/s", range = [-4, 4] }

[inputs]
tau = { unit = "N m", range = [-20, 20] }

[disturbances]
gust = { unit = "kN m", range = [-0.001, 0.001] }
shake = { unit = "rad/s" }

[equations]
theta = "omega + shake"
omega = "(9.81*tau0*sin(theta) + tau + gust) / J"

[parameters]
J = { value = 0.5, unit = "kg m^2" }
tau0 = { value = 1, unit = "N m" }
"""


def plant(folder: Path) -> Plant:
    path = folder / "pendulum.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    return load_plant(path)


def wish(folder: Path, **asked: object) -> NormWish:
    subject = plant(folder)
    settings = PlantSettings(**asked)  # type: ignore[arg-type]
    found = norm_wish(subject, sector_model(subject), settings)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("asked", "label"),
    [
        ({"objective": "hinf", "performance": ("theta",), "disturbances": ("gust",)},
         "energy gain from gust to theta [deg/(kN m)]"),
        ({"objective": "h2", "performance": ("theta",), "disturbances": ("shake",)},
         "response to white noise from shake to theta [deg/(rad/s s^0.5)]"),
        ({"objective": "peak", "performance": ("theta", "tau"), "disturbances": ("gust",)},
         "peak gain from gust to theta, tau [(deg, N m)/(kN m)]"),
        ({"objective": "hinf"},
         "energy gain from gust, shake to states over their ranges [1/(N m, rad/s)]"),
    ],
)  # fmt: skip
def test_the_label_says_the_units(asked: dict[str, object], label: str, tmp_path: Path) -> None:
    """Those of the file; of disturbances in several units those of SI."""
    assert wish(tmp_path, **asked).label == label


def test_rows_are_in_the_units_of_the_file(tmp_path: Path) -> None:
    """A degree is pi / 180 rad, and w is counted in kN m: its thousand N m stand in z."""
    asked = wish(tmp_path, objective="hinf", performance=("theta", "tau"), disturbances=("gust",))

    np.testing.assert_allclose(asked.C[0], np.diag([1000 * 180 / np.pi, 0.0]), rtol=1e-9)
    np.testing.assert_allclose(asked.D[0], [[0], [1000]], rtol=1e-12)
    assert asked.size == pytest.approx(1.0) and asked.sources == (0,)


def test_states_are_weighed_by_their_ranges(tmp_path: Path) -> None:
    asked = wish(tmp_path, objective="hinf")

    np.testing.assert_allclose(asked.C[0], np.diag([3 / np.pi, 1 / 4]), rtol=1e-9)
    assert not asked.D.any() and asked.sources == (0, 1)


@pytest.mark.slow
def test_white_noise_and_limits_go_together(tmp_path: Path) -> None:
    """The set that keeps the input within 20 N m holds all corners of the initial box."""
    initial = {"theta": 0.3, "omega": 0.5}
    asked = PlantSettings(
        objective="h2", performance=("theta",), disturbances=("gust",), initial=initial
    )
    plain = PlantSettings(initial=initial)

    designs = [design_plant(plant(tmp_path), settings) for settings in (asked, plain)]

    with_norm = designs[0]
    assert isinstance(with_norm, PlantDesign) and with_norm.proved
    claims = {c["kind"]: c for c in json.loads(json.dumps(with_norm.document["claims"]))}
    P, level = np.array(claims["input-limits"]["P"]), claims["input-limits"]["level"]
    for signs in ((1, 1), (1, -1)):
        corner = np.array(signs) * [0.3, 0.5]
        assert corner @ P @ corner <= level
    assert "output" in claims["h2-norm"]
