"""The section [design] of a plant file: units, names, and what makes no sense."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from takagi.models import ModelError
from takagi.models.files.library import built_in_kinds
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import PlantFile

PLANT = """
format = 1
kind = "plant"

[states]
theta = { unit = "deg", range = [-60, 60] }
omega = { unit = "rpm" }

[inputs]
tau = { unit = "kN m" }

[parameters]
k = { value = 1, unit = "1/(kg m^2)" }

[equations]
theta = "omega"
omega = "k*tau"

[design]
"""


def settings(tmp_path: Path, section: str) -> PlantSettings:
    path = tmp_path / "plant.toml"
    path.write_text(PLANT + section, encoding="utf-8")
    return PlantFile.of(path).settings


def test_numbers_are_in_the_units_of_the_variables(tmp_path: Path) -> None:
    found = settings(
        tmp_path, "initial = { theta = 30, omega = 60 }\ninput_limit = { tau = 0.2 }\n"
    )

    assert found.initial == pytest.approx({"theta": 0.523598775598, "omega": 6.283185307180})
    assert found.input_limit == pytest.approx({"tau": 200.0})


def test_every_field_arrives(tmp_path: Path) -> None:
    found = settings(
        tmp_path,
        'choice = "least-conservative"\nrest = "solve inputs"\ndecay_rate = "max"\n'
        'relaxation = "tuan"\ngain_bound = 5.5\ndamping = 0.7\nfastest = 20\n',
    )

    assert found == PlantSettings(
        choice="least-conservative",
        rest="solve inputs",
        decay_rate="max",
        relaxation="tuan",
        gain_bound=5.5,
        damping=0.7,
        fastest=20.0,
    )


def test_a_file_without_the_section_leaves_every_choice() -> None:
    name = next(name for name, kind in built_in_kinds().items() if name == "duffing")

    assert PlantFile.of(name).settings == PlantSettings()


@pytest.mark.parametrize(
    ("section", "field", "words"),
    [
        ("decay_rat = 1", "design.decay_rat", "did you mean 'decay_rate'"),
        ("decay_rate = -1", "design.decay_rate", "a number >= 0"),
        ('decay_rate = "fast"', "design.decay_rate", 'or "max", is needed'),
        ("damping = 1.5", "design.damping", "below 1"),
        ("gain_bound = 0", "design.gain_bound", "a positive number"),
        ("fastest = true", "design.fastest", "a number is needed"),
        ('choice = "few"', "design.choice", "fewest-rules"),
        ("input_limit = { tua = 1 }", "design.input_limit", "did you mean 'tau'"),
        ("input_limit = { tau = -1 }", "design.input_limit", "a positive number"),
        ("initial = { thta = 1 }", "design.initial", "did you mean 'theta'"),
        ("initial = { tau = 1 }", "design.initial", "tau is no state"),
    ],
)
def test_what_makes_no_sense_is_named_with_its_line(
    tmp_path: Path, section: str, field: str, words: str
) -> None:
    with pytest.raises(ModelError) as caught:
        settings(tmp_path, section + "\n")

    line = PLANT.count("\n") + 1
    assert f"plant.toml:{line}: field {field!r}" in str(caught.value) and words in str(caught.value)


def test_settings_made_in_python_are_checked_alike() -> None:
    with pytest.raises(ModelError, match="choice = 'few' was given"):
        PlantSettings(choice="few")  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="input_limit of u"):
        PlantSettings(input_limit={"u": float("nan")})
    with pytest.raises(ModelError, match="there is no input of that name"):
        PlantSettings(input_limit={"u": 1.0}).require_names(states=("x",), inputs=("v",))


@pytest.mark.parametrize("written", ['"2 min"', '"120 s"', "120", '"120"'])
def test_a_settling_time_is_a_decay_rate(tmp_path: Path, written: str) -> None:
    found = settings(tmp_path, f"settle = {written}\n").decay_rate

    assert isinstance(found, float) and math.isclose(math.exp(-120 * found), 0.02)


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("settle = 2\ndecay_rate = 1\n", "leave one out"),
        ('settle = "soon"\n', "a time above 0"),
        ("settle = 0\n", "a time above 0"),
        ("settle = -1\n", "a time above 0"),
        ('settle = "2 kg"\n', "no unit of time"),
        ('settle = "2 parsec"\n', "parsec"),
        ('effort = "tiny"\n', "effort"),
    ],
)
def test_wishes_that_make_no_sense_have_a_place(tmp_path: Path, section: str, words: str) -> None:
    with pytest.raises(ModelError, match=words) as told:
        settings(tmp_path, section)
    assert "plant.toml" in str(told.value) and "design." in str(told.value)


def test_an_effort_arrives(tmp_path: Path) -> None:
    assert settings(tmp_path, "").effort == "moderate"
    assert settings(tmp_path, 'effort = "small"\n').effort == "small"
