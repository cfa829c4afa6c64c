"""A tank, designed once for all tests of gain files: plant file, gain file, certificate."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.models.plant_files.loader import PlantFile, load_plant
from takagi.reports.gains_file.envelope import dump_gains
from takagi.reports.gains_file.plant import plant_gain_file

TANK = """
format = 1
kind = "plant"
name = "tank"

[states]
h = { unit = "m", range = [0.5, 1.5], rest = 1, description = "level" }

[inputs]
q = { unit = "kg/s", range = [0, 5], rest = 2, description = "feed" }

[equations]
h = "a*q - b*h^2 + c*(h - h0)"

[parameters]
a = { value = 0.5, unit = "m/kg" }
b = { value = 1, unit = "1/(m s)" }
c = { value = 0.1, unit = "1/s" }
h0 = { value = 1, unit = "m" }
"""


@pytest.fixture(scope="package")
def tank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plant whose state and input rest off 0, designed: plant file, gain file, certificate."""
    folder = tmp_path_factory.mktemp("tank")
    (folder / "tank.toml").write_text(TANK, encoding="utf-8")
    plant = load_plant(folder / "tank.toml")
    found = design_plant(plant, files=PlantFile.of(folder / "tank.toml").files)
    assert isinstance(found, PlantDesign) and found.proved
    (folder / "c.json").write_text(dumps(found.document), encoding="utf-8")
    (folder / "gains.json").write_text(dump_gains(plant_gain_file(found)), encoding="utf-8")
    return folder
