"""``measured`` in a plant file: what it may name, and what is refused with its place."""

from __future__ import annotations

from pathlib import Path

import pytest
import sympy as sp

from takagi.models import ModelError, Output
from takagi.models.plant_files.loader import load_plant

TEXT = """
format = 1
kind = "plant"
{measured}
[states]
theta = {{ unit = "rad", range = [-1, 1] }}
omega = {{ unit = "rad/s", range = [-4, 4] }}
[inputs]
tau = {{ unit = "rad/s^2" }}
[disturbances]
w = {{ unit = "rad/s^2" }}
[parameters]
l = {{ value = 500, unit = "mm" }}
g = {{ value = 20, unit = "rad/s^2" }}
[equations]
theta = "omega"
omega = "g*sin(theta) + tau + w"
[outputs]
height = {{ expression = "l*cos(theta)", unit = "m" }}
omega = {{ expression = "2*omega", unit = "rad/s" }}
"""


def read(folder: Path, measured: str) -> tuple[tuple[str, ...] | None, dict[str, Output]]:
    """Return what is measured of the plant with this line, and its outputs."""
    path = folder / "pendulum.toml"
    path.write_text(TEXT.format(measured=measured), encoding="utf-8")
    plant = load_plant(path)
    return plant.measured, {y.name: y for y in plant.outputs}


def test_a_state_gets_an_output_of_its_name(tmp_path: Path) -> None:
    measured, outputs = read(tmp_path, 'measured = ["theta"]')

    assert measured == ("theta",)
    assert outputs["theta"] == Output("theta", sp.Symbol("theta", real=True), "rad")
    assert set(outputs) == {"height", "omega", "theta"}


def test_an_output_is_measured_by_its_name(tmp_path: Path) -> None:
    assert read(tmp_path, 'measured = ["height"]')[0] == ("height",)


def test_an_expression_has_a_name_and_a_unit(tmp_path: Path) -> None:
    line = 'measured = ["theta", { name = "place", expression = "l*sin(theta)", unit = "m" }]'
    measured, outputs = read(tmp_path, line)

    theta, length = sp.symbols("theta l", real=True)
    assert measured == ("theta", "place")
    assert outputs["place"] == Output("place", length * sp.sin(theta), "m")


def test_without_it_all_states_are_known(tmp_path: Path) -> None:
    assert read(tmp_path, "")[0] is None


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('["thta"]', "neither an output nor a state .did you mean 'theta'"),
        ("[]", "nothing is measured"),
        ('["theta", "theta"]', "twice"),
        ('"theta"', "a list is needed"),
        ("[3]", "a name in quotes"),
        ('["g"]', "neither an output nor a state"),
        ('["tau"]', "neither an output nor a state"),
        ('["omega"]', "a state and another output"),
        ('[{ name = "theta", unit = "rad" }]', "a unit of its own"),
        ('[{ name = "theta", expression = "theta", unit = "rad" }]', "a meaning already"),
        ('[{ name = "y", expression = "w", unit = "rad/s^2" }]', "comes from outside"),
        ('[{ name = "y", expression = "l*thta", unit = "m" }]', "thta"),
        ('[{ name = "y", expression = "l*theta", unit = "rad" }]', "has the unit"),
        ('[{ name = "y", expression = "l*theta", unit = "mm" }]', "write 'm'"),
        ('[{ name = "y", expresion = "l*theta", unit = "m" }]', "expression"),
    ],
)
def test_what_is_refused_names_place_reason_and_cure(tmp_path: Path, line: str, words: str) -> None:
    with pytest.raises(ModelError, match=words) as error:
        read(tmp_path, f"measured = {line}")

    assert "pendulum.toml" in str(error.value)
    assert "measured" in str(error.value)


def test_a_plant_without_inputs_measures_nothing(tmp_path: Path) -> None:
    path = tmp_path / "free.toml"
    text = TEXT.format(measured='measured = ["theta"]')
    path.write_text(text.replace('[inputs]\ntau = { unit = "rad/s^2" }\n', "").replace("+ tau", ""))
    with pytest.raises(ModelError, match="no input"):
        load_plant(path)
