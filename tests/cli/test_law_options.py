"""Options about laws and settling: each reaches its field by either name, nonsense is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from takagi.certificates.design.turbine.settings import LAWS
from takagi.cli.main import main
from takagi.cli.options.plant_options import plant_settings
from takagi.cli.options.turbine_options import IN_FILES, law_in_files, typed_name
from takagi.cli.options.turbine_settings import design_settings
from takagi.models import ModelError
from takagi.models.plant_files.loader import PlantFile
from takagi.models.turbine.loader import nrel5mw

TURBINE = nrel5mw()


def test_each_option_sets_its_field() -> None:
    """Of the effort-sharing and the published laws; what is not given keeps its default."""
    coherent = design_settings(TURBINE, torque_setpoint="80%", pitch_effectiveness_share=0.8)
    paper = design_settings(
        TURBINE, law="paper", ramp_shape="linear", ramp_placement=0.25, torque_setpoint="40 kNm"
    )

    assert coherent.torque_setpoint == pytest.approx(0.8 * TURBINE.rated_torque)
    assert coherent.effectiveness_share == 0.8
    assert (paper.ramp_shape, paper.ramp_placement) == ("linear", 0.25)
    assert paper.torque_setpoint == 40e3
    plain = design_settings(TURBINE)
    assert plain.torque_setpoint is None and plain.effectiveness_share == 1.0
    assert (plain.ramp_shape, plain.ramp_placement) == ("smooth", 0.0)


def test_the_speed_filter_may_be_none() -> None:
    """0 leaves it out; a corner that hides the speed is refused; both laws have it."""
    assert design_settings(TURBINE).speed_filter == 30.0
    none = design_settings(TURBINE, speed_filter=0.0)
    assert (none.speed_filter, none.torsion_filter) == (0.0, 0.0)
    assert design_settings(TURBINE, speed_filter=0.5).speed_filter == 0.5
    for given in (-1.0, 0.49, float("inf"), float("nan")):
        with pytest.raises(ModelError, match=r"--speed-filter: .* at least 0.5 rad/s"):
            design_settings(TURBINE, speed_filter=given)
    assert design_settings(TURBINE, law="paper", speed_filter=4.0).speed_filter == 4.0


def test_the_torsion_filter_goes_with_a_low_pass() -> None:
    """Unless given it is 0.9 of the turbine's torsion mode; without one the low-pass is slower."""
    plain = design_settings(TURBINE)
    assert (plain.speed_filter, plain.torsion_filter) == (30.0, 9.3)
    none = design_settings(TURBINE, torsion_filter=0.0)
    assert (none.speed_filter, none.torsion_filter) == (8.0, 0.0)
    both = design_settings(TURBINE, torsion_filter=12.0, speed_filter=20.0)
    assert (both.speed_filter, both.torsion_filter) == (20.0, 12.0)
    for given in (-1.0, 1.9, float("inf"), float("nan")):
        with pytest.raises(ModelError, match=r"--torsion-filter: .* at least 2 rad/s"):
            design_settings(TURBINE, torsion_filter=given)
    with pytest.raises(ModelError, match="needs a low-pass behind it"):
        design_settings(TURBINE, torsion_filter=9.0, speed_filter=0.0)


def test_the_wind_filter_is_the_coherent_laws() -> None:
    """It reaches its field; a filter that is none, and one for another law, are refused."""
    assert design_settings(TURBINE, wind_filter=0.3).wind_filter == 0.3
    assert design_settings(TURBINE).wind_filter == 12.0
    for given in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(ModelError, match=r"--wind-filter: .* must be positive"):
            design_settings(TURBINE, wind_filter=given)
    with pytest.raises(ModelError, match="--wind-filter belongs to the effort-sharing law"):
        design_settings(TURBINE, law="paper", wind_filter=1.0)


def test_a_low_torque_goes_with_a_low_speed() -> None:
    """70 % of the torque is too little at full speed, and enough at 11 rpm."""
    with pytest.raises(ModelError, match=r"--torque-setpoint 70%: .*lower the speed set-point"):
        design_settings(TURBINE, torque_setpoint="70%")

    asked = design_settings(TURBINE, torque_setpoint="70%", speed_setpoint="11rpm")
    assert asked.torque_setpoint == pytest.approx(0.7 * TURBINE.rated_torque)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"torque_setpoint": "80"}, "a number with its unit"),
        ({"torque_setpoint": "80 rpm"}, "--torque-setpoint 80 rpm: unit 'rpm'"),
        ({"lowest_torque_setpoint": "60%"}, "--lowest-torque-setpoint 60%: .*raise the torque"),
        ({"lowest_speed_setpoint": "10"}, "--lowest-speed-setpoint 10: .*unit"),
        ({"lowest_speed_setpoint": "9rpm"}, "25 m/s"),
        ({"law": "paper", "lowest_speed_setpoint": "10rpm"}, "effort-sharing"),
        ({"torque_setpoint": "120%"}, "at or below the rated torque"),
        ({"torque_setpoint": "-5%"}, "above 0"),
        ({"pitch_effectiveness_share": 0.0}, "--pitch-effectiveness-share: 0 was given"),
        ({"pitch_effectiveness_share": float("nan")}, "--pitch-effectiveness-share: nan"),
        ({"wind_filter": 0.0}, "--wind-filter: 0 was given"),
        ({"wind_filter": 101.0}, "--wind-filter: 101 was given; .* at most 100 s"),
        ({"ramp_shape": "linear"}, "--ramp-shape belongs to Schulte's law"),
        ({"law": "switched"}, "not continuous: the pitch reference jumps"),
        ({"law": "paper", "ramp_shape": "cubic"}, "smooth or linear"),
        ({"law": "paper", "ramp_placement": 1.5}, "--ramp-placement: 1.5"),
        ({"law": "paper", "pitch_effectiveness_share": 0.6}, "belongs to the effort-sharing law"),
    ],
)
def test_nonsense_is_refused_by_name(options: dict[str, Any], words: str) -> None:
    """The option, what was given, and what is needed."""
    with pytest.raises(ModelError, match=words):
        design_settings(TURBINE, **options)


def test_every_law_of_the_files_has_a_name_to_type() -> None:
    assert set(IN_FILES.values()) == set(LAWS)
    assert [typed_name(law_in_files(name)) for name in IN_FILES] == list(IN_FILES)


@pytest.mark.parametrize("filed", [*LAWS, "baseline"])
def test_names_of_files_may_be_typed_too(filed: str) -> None:
    assert law_in_files(filed) == filed
    assert law_in_files(None) is None


def test_several_laws_are_renamed_one_by_one() -> None:
    assert law_in_files(["published", "baseline", "coherent"]) == ["paper", "baseline", "coherent"]


@pytest.mark.parametrize("name", ["schulte", "published", "paper"])
def test_an_option_of_another_law_is_refused_by_either_name(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command itself translates the name: --overlap belongs to the effort-sharing law."""
    asked = ["design", "nrel5mw", "--law", name, "--overlap", "0.1", "--out", "never-written"]

    assert main(asked) == 2
    assert (
        "--overlap belongs to the effort-sharing law, but --law schulte" in capsys.readouterr().err
    )


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
