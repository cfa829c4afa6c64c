"""A tank, designed once for all tests of gain files: plant file, gain file, certificate."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plant_files import designed_in

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
    designed_in(folder, TANK, "tank.toml")
    return folder
