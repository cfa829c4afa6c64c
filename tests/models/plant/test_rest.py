"""Where a plant rests: solved inputs, and what is said where no rest is."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.errors import ModelError
from takagi.models.plant_files.loader import PlantFile
from takagi.models.sector.model import sector_model

SQUARE = """
format = 1
kind = "plant"
units = "unchecked"
[states]
x = {{ range = [0.5, 1.5], rest = 1 }}
[inputs]
u = {{ range = {range} }}
[equations]
x = "{equation}"
[design]
rest = "solve inputs"
"""


def filed(path: Path, text: str) -> PlantFile:
    path.write_text(text, encoding="utf-8")
    return PlantFile.of(path)


@pytest.mark.parametrize("side", ["[0, 4]", "[-4, 2]", "[-1, 4]"])
def test_an_input_s_range_need_not_centre_on_its_solved_rest(tmp_path: Path, side: str) -> None:
    """x' = u - x^2 rests at x = 1 with u = 1: the law has the room about that."""
    file = filed(tmp_path / "square.toml", SQUARE.format(range=side, equation="u - x^2"))
    design = design_plant(file.model, file.settings)

    assert isinstance(design, PlantDesign)
    assert design.proved
    assert design.document["gains"]["trim"] == {"state": [1.0], "input": [1.0]}


def test_a_solved_input_outside_its_range_is_named(tmp_path: Path) -> None:
    file = filed(tmp_path / "far.toml", SQUARE.format(range="[-2, 2]", equation="u - 5*x^2"))
    with pytest.raises(ModelError, match=r"u \[-\] has to be 5 to hold .* outside its range"):
        sector_model(file.model, rest="solve inputs")


TWO = """
format = 1
kind = "plant"
[states]
q = { unit = "m", range = [0.5, 1.5], rest = 1 }
v = { unit = "m/s", range = [-1, 1], rest = 0.5 }
[inputs]
u = { unit = "m/s^2" }
[parameters]
k = { value = 2, unit = "1/s^2" }
p = { value = 1, unit = "m" }
c = { value = 1, unit = "m^2/s^2" }
[equations]
q = "v"
v = "u - k*q"
"""


def test_every_residual_is_listed_with_its_equation_and_unit(tmp_path: Path) -> None:
    file = filed(tmp_path / "two.toml", TWO)
    with pytest.raises(ModelError) as found:
        sector_model(file.model)

    told = str(found.value)
    assert "q' is 0.5 m per second, not 0; v' is -2 m/s per second, not 0" in told


def test_an_equation_without_a_value_at_rest_says_which_part(tmp_path: Path) -> None:
    pole = TWO.replace("u - k*q", "u - c/(q - p)")
    with pytest.raises(ModelError, match=r"q - 1 is 0, and the equation divides by it") as found:
        sector_model(filed(tmp_path / "pole.toml", pole).model)
    assert "zoo" not in str(found.value)

    root = TWO.replace("u - k*q", "u - k*p*sqrt(q/p - 2)")
    with pytest.raises(ModelError, match=r"is negative, and the equation takes its root"):
        sector_model(filed(tmp_path / "root.toml", root).model)
