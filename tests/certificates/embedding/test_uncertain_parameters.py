"""Certificates of plants with uncertain parameters: the whole range is proved."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check_document
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant, load_model
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import load_plant
from takagi.reports.loops.plant_motion import uncertain_ends
from takagi.reports.simulation.plant import simulate_plant
from tests.certificates.kinds.claims import Data, resealed, verdicts
from tests.plant_files import written
from tests.plant_rates import plant_rate

# theta'' = (g/l) sin(theta) + (1 + w) u / (m l^2): w is known to the law, m is not.
ARM = """
format = 1
kind = "plant"
name = "arm"

[states]
theta = { unit = "rad", range = [-1, 1] }
omega = { unit = "rad/s", range = [-4, 4] }

[inputs]
u = { unit = "N m" }

[scheduling]
w = { range = [-0.5, 0.5] }

[parameters]
m = "[0.8, 1.2] kg"
l = { value = 1, unit = "m" }
g = { value = 9.81, unit = "m/s^2" }
J = "m*l^2"

[equations]
theta = "omega"
omega = "g/l*sin(theta) + (1 + w)*u/J"

[premises]
inverse = "1/m"
share = "w"
bend = "sin(theta)/theta"
"""


def arm(folder: Path, text: str = ARM) -> tuple[Plant, Path]:
    path = written(folder, text, "arm.toml")
    return load_plant(path), path


@cache
def by_rules() -> PlantDesign:
    """Gains that go with the share, which the law knows, and not with the mass."""

    def gains(model: Any) -> Any:
        names = [p.name for p in model.premises]
        known = [corner[names.index("share")] for corner in model.rules]
        return np.array([[[60.0, 20.0]] if high else [[80.0, 30.0]] for high in known])

    with TemporaryDirectory() as folder:
        plant, path = arm(Path(folder))
        return certify_plant(plant, gains, PlantSettings(), files=[path])


def changed(change: Callable[[Data], None]) -> Data:
    found = copy.deepcopy(dict(by_rules().document))
    found["claims"] = [c for c in found["claims"] if c["kind"] in ("sector-embedding", "decay")]
    change(found)
    return resealed(found)


def mass(document: Data) -> Data:
    found: Data = next(v for v in document["model"]["disturbances"] if v["name"] == "m")
    return found


def test_gains_that_go_with_known_signals_are_proved() -> None:
    document = changed(lambda _: None)

    assert mass(document)["unknown"] is True
    assert verdicts(document) == ["PROVED", "PROVED"]
    words = check_document(document).claims[0].text
    assert "m is an uncertain parameter, constant or moving in any way in the range" in words


def test_the_plant_file_says_which_parameters_are_uncertain(tmp_path: Path) -> None:
    """The same in other words passes; a wider range, a known value or another J do not."""
    model = by_rules().document["model"]
    for old, new in (("", ""), ('"[0.8, 1.2] kg"', '{ range = [800, 1200], unit = "g" }')):
        _, path = arm(tmp_path, ARM.replace(old, new) if old else ARM)
        compare_plant(read(model), path)
    for old, new in (
        ("[0.8, 1.2]", "[0.8, 1.3]"),
        ('"[0.8, 1.2] kg"', '{ value = 1, unit = "kg" }'),
        ('"[0.8, 1.2] kg"', '{ range = [0.8, 1.2], value = 0.9, unit = "kg" }'),
        ("m*l^2", "m*l^2*1.01"),
    ):
        _, path = arm(tmp_path, ARM.replace(old, new))
        with pytest.raises(OtherModel):
            compare_plant(read(model), path)


def read(model: Any) -> Any:
    from takagi.certificates.checker import read_text
    from takagi.certificates.document.certificate_file import dumps

    return read_text(dumps({"model": model}), "model")["model"]


def test_a_known_signal_in_the_file_is_no_uncertain_one(tmp_path: Path) -> None:
    """A certificate that makes the share unknown besides is not the file's."""
    model = copy.deepcopy(by_rules().document["model"])
    next(v for v in model["disturbances"] if v["name"] == "w")["unknown"] = True
    _, path = arm(tmp_path)
    with pytest.raises(OtherModel, match="uncertain parameters"):
        compare_plant(read(model), path)


@cache
def spring() -> PlantDesign:
    plant = load_model("two_mass_spring")
    assert isinstance(plant, Plant)
    found = design_plant(plant)
    assert isinstance(found, PlantDesign)
    return found


@pytest.mark.slow
def test_the_benchmark_of_wie_and_bernstein_is_proved() -> None:
    """One gain for 0.5 <= k <= 2 N/m, which is the range that the benchmark asks for."""
    design = spring()

    assert design.proved
    assert len({tuple(K.ravel()) for K in np.asarray(design.gains)}) == 1
    program = design.document["controller"]["states"]
    assert [state["name"] for state in program] == ["x1", "x2", "v1", "v2"]


@pytest.mark.slow
def test_simulations_run_at_the_ends_of_the_range() -> None:
    found = simulate_plant(spring(), duration=100)
    ends = [motion for motion in found.motions if "k = " in motion.name]

    assert len(ends) == 2 * (len(found.motions) - len(ends))
    for motion in found.motions:
        assert motion.whole
        assert np.abs(motion.state[-1]).max() < 0.02 * np.abs(motion.state).max()


def test_a_rate_at_an_end_is_that_of_the_value() -> None:
    plant = load_model("two_mass_spring")
    assert isinstance(plant, Plant)
    ends = uncertain_ends(plant)
    x, u = np.array([0.4, -0.2, 0.0, 0.0]), np.zeros(1)

    assert [float(end["k"]) for end in ends] == [0.5, 2.0]
    for end in ends:
        pull = float(end["k"]) * 0.6
        assert plant_rate(plant, end)(x, u) == pytest.approx([0, 0, -pull, pull])
    assert plant_rate(plant)(x, u) == pytest.approx([0, 0, -0.6, 0.6])
