"""The turbine file: its figures, and what is said about a malformed one."""

from __future__ import annotations

import re
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from takagi.models import ModelError, built_in_models
from takagi.models.files.csv_table import read_coefficient_table
from takagi.models.files.library import data_folder, resolve_model
from takagi.models.files.units import UNITS
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.turbine.file_figures import frozen_wake_by_tables
from takagi.models.turbine.loader import load_turbine, nrel5mw
from takagi.reports.simulation.laws import default_laws

Edit = Callable[[str, str], Path]


@pytest.fixture
def edited(tmp_path: Path) -> Edit:
    def copy(old: str, new: str) -> Path:
        for name in ("nrel5mw.toml", "nrel5mw_cp.csv", "nrel5mw_ct.csv"):
            shutil.copy(data_folder() / name, tmp_path / name)
        for name in ("nrel5mw.toml", "nrel5mw_cp.csv"):
            text = (tmp_path / name).read_text(encoding="utf-8")
            if old in text:
                (tmp_path / name).write_text(text.replace(old, new, 1), encoding="utf-8")
                return tmp_path / "nrel5mw.toml"
        raise AssertionError(f"{old!r} is in neither file: the test is out of date")

    return copy


def test_figures_in_si() -> None:
    """Figures of Jonkman et al. (2009) and of the OpenFAST 5-MW controller source, converted."""
    turbine = nrel5mw()

    assert turbine.rated_rotor_speed == pytest.approx(1.267109, abs=1e-6)
    assert turbine.rated_rotor_speed * turbine.gear_ratio == pytest.approx(122.9096, abs=1e-4)
    assert turbine.minimum_rotor_speed == pytest.approx(670 / 97 * np.pi / 30)
    assert turbine.inertia == pytest.approx(43_784_725, abs=1)
    assert turbine.rated_power == pytest.approx(5.0e6, rel=1e-6)
    assert turbine.pitch_rate_limit == pytest.approx(np.radians(8))
    assert turbine.pitch_drive_frequency == pytest.approx(2 * np.pi)
    assert turbine.frozen_wake.power_sensitivity[-1] == pytest.approx(-125.3e6)
    assert turbine.reference_controller.region_3_speed == pytest.approx(1161.963 * np.pi / 30)


def test_tower_and_shaft_modes() -> None:
    """Tower 0.324 Hz with 1 % damping, shaft free-free mode 2.22 Hz, from the stored figures."""
    turbine = nrel5mw()
    tower = np.sqrt(turbine.tower_stiffness / turbine.tower_mass)
    geared = turbine.gear_ratio**2 * turbine.generator_inertia
    shaft = np.sqrt(turbine.shaft_stiffness * (1 / turbine.rotor_inertia + 1 / geared))

    assert tower / (2 * np.pi) == pytest.approx(0.324, abs=5e-4)
    assert turbine.tower_damping / (2 * turbine.tower_mass * tower) == pytest.approx(0.01, rel=1e-3)
    assert shaft / (2 * np.pi) == pytest.approx(2.22, abs=0.01)


@pytest.mark.parametrize("name", ["nrel5mw", "iea15mw"])
def test_every_figure_has_unit_and_source(name: str) -> None:
    figures = load_turbine(name).figures

    assert len(figures) > 40
    for path, figure in figures.items():
        assert figure.unit in UNITS, path
        assert len(figure.source) > 10, path
    for kind in ("cp", "ct"):
        text = (data_folder() / f"{name}_{kind}.csv").read_text(encoding="utf-8")
        assert "ROSCO 2.10.6" in text and "licence: Apache-2.0" in text


def test_nrel5mw_is_read_once() -> None:
    assert nrel5mw() is nrel5mw()
    other = load_turbine(data_folder() / "nrel5mw.toml")
    assert other.figures == nrel5mw().figures
    assert "nrel5mw" in dict(built_in_models())


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("radius = { value = 63.0,", "radius = { value = 63.0", r"toml:\d+:\d+: not valid TOML"),
        ("radius = {", "radios = {", r"toml:9: .*rotor.radios.*did you mean 'radius'"),
        ("value = 97.0", 'value = "97"', "drivetrain.gear_ratio.*'97' was given; a finite number"),
        ("value = 97.0", "value = true", "drivetrain.gear_ratio.*True was given"),
        ("value = 97.0", "value = nan", "drivetrain.gear_ratio.*nan"),
        ("value = 97.0", "value = 0.5", "gear_ratio.*expected 1 to 1000 -"),
        ('value = 12.1, unit = "rpm"', 'value = 12.1, unit = "RPM"', "did you mean 'rpm'"),
        ('value = 12.1, unit = "rpm"', 'value = 12.1, unit = "kg"', "does not fit.*'rad/s'"),
        ('value = 8.0, unit = "deg/s"', 'value = 800.0, unit = "rad/s"', "800 rad/s.*check value"),
        ('unit = "rpm", source = "Jonk', 'source = "Jonk', r"rated_speed.*expected \{ value"),
        ('kind = "turbine"', 'kind = "pendulum"', "'pendulum' was given"),
        ("format = 1", "format = 7", "knows format = 1"),
        ("[tower]", "[towr]", "'towr'.*did you mean 'tower'"),
        ("cut_out = { value = 25.0", "cut_out = { value = 2.0", "cut_in.*not below cut_out"),
        ("hub_height = {", "#", r"toml:\d+: field 'rotor.hub_height'.*is missing"),
        ("values = [11.4, 12.0,", "values = [12.0,", "frozen_wake.pitch.*15 values.*wind has 14"),
        ("values = [11.4, 12.0,", "values = [12.0, 11.4,", "must increase"),
        ('power = "nrel5mw_cp.csv"', 'power = "gone.csv"', "gone.csv: no such file"),
        ("value = 871.0", "value = 600.0", "region_2_speed.*must exceed"),
        ("0.006673,", "nan,", r"nrel5mw_cp.csv:9: column 2 is 'nan'"),
        ("0.006673,", "", r"nrel5mw_cp.csv:9: 35 values, but line 8 names 36"),
        ("0.006673,", ",", r"column 2 is ''"),
        ("\n2.5,", "\n1.5,", r"nrel5mw_cp.csv:10: tip-speed ratio 1.5 follows 2"),
        ("ratio,-5,-4,", "ratio,-4,-5,", "pitch angle -5 follows -4"),
        ("# licence: Apache-2.0\n", "", "'# licence: ...' is missing"),
        ("coefficient table 1", "coefficients", "first line must be"),
        ("pitch [deg]", "pitch [grad]", "collective pitch .deg."),
    ],
)
def test_malformed_files(edited: Edit, old: str, new: str, words: str) -> None:
    with pytest.raises(ModelError, match=f"(?s){words}"):
        load_turbine(edited(old, new))


def test_all_that_is_missing_is_named_at_once(edited: Edit) -> None:
    path = edited("[rotor]", "[rotor]")
    gone = ("rotor.inertia", "generator.rated_torque", "tower.mass", "tower.stiffness")
    text = path.read_text(encoding="utf-8")
    for field in (*gone, "wake.time_share"):
        key = field.partition(".")[2]
        section, rest = text.split(f"[{field.partition('.')[0]}]\n", 1)
        text = f"{section}[{field.partition('.')[0]}]\n" + re.sub(
            rf"^{key} = .*\n", "", rest, count=1, flags=re.MULTILINE
        )
    path.write_text(text, encoding="utf-8")

    with pytest.raises(ModelError, match="is missing, and 4 more; add") as caught:
        load_turbine(path)

    asked = tomllib.loads("[" + str(caught.value).partition("add\n[")[2].replace("<number>", "1"))
    assert {f"{name}.{key}" for name, part in asked.items() for key in part} == {
        *gone,
        "wake.time_share",
    }
    assert asked["generator"]["rated_torque"]["unit"] == "N m"
    assert "mass * (2 pi frequency)^2" in str(caught.value)


@pytest.fixture
def bare(edited: Edit) -> Path:
    path = edited("[rotor]", "[rotor]")
    text = path.read_text(encoding="utf-8")
    for section in ("baseline", "frozen_wake"):
        text = re.sub(rf"^\[{section}\]\n.*?(?=^\[|^# )", "", text, flags=re.DOTALL | re.MULTILINE)
    path.write_text(text, encoding="utf-8")
    return path


def test_the_references_controller_is_not_needed(bare: Path) -> None:
    turbine = load_turbine(bare)

    assert turbine.baseline is None and default_laws(turbine) == ("coherent", "paper")
    with pytest.raises(ModelError, match=r"\[baseline\]"):
        BaselineLaw(turbine)


def test_a_frozen_wake_that_nobody_states_is_computed(bare: Path) -> None:
    """Near the published column, which was not used; the IEA 15-MW turbine's stated one too."""
    computed, published = load_turbine(bare).frozen_wake, nrel5mw().frozen_wake
    iea = load_turbine("iea15mw")
    table = read_coefficient_table(data_folder() / "iea15mw_ct.csv")

    assert computed.wind[0] == 11.5 and computed.wind[-1] == 25
    assert "computed" in computed.source
    for found, known in (
        (computed, published),
        (frozen_wake_by_tables(iea, table), iea.frozen_wake),
    ):
        ours = np.interp(known.wind, found.wind, found.power_sensitivity)
        assert ours == pytest.approx(np.array(known.power_sensitivity), rel=0.1)
        assert ours[2:] == pytest.approx(np.array(known.power_sensitivity)[2:], rel=0.045)


def test_a_column_that_begins_above_rated_wind_is_refused(edited: Edit) -> None:
    path = edited("[rotor]", "[rotor]")
    text = path.read_text(encoding="utf-8")
    for first in ("11.4, 12.0, ", "0.0, 3.83, ", "-28.24, -43.73, "):
        text = text.replace(f"[{first}", "[")
    path.write_text(text, encoding="utf-8")

    with pytest.raises(ModelError, match=r"begins at 13 m/s; rated wind is 11.45 m/s.*leave"):
        load_turbine(path)


def test_pitch_in_rad_and_torque_in_kilo(edited: Edit) -> None:
    path = edited('value = 43093.55, unit = "N m"', 'value = 43.09355, unit = "kN m"')

    assert load_turbine(path).rated_torque == pytest.approx(nrel5mw().rated_torque, rel=1e-12)


def test_unknown_models_are_named_with_near_names(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="'nrel5m' is not known .did you mean 'nrel5mw'"):
        resolve_model("nrel5m")
    with pytest.raises(ModelError, match=r"gone\.toml: no such file"):
        resolve_model(tmp_path / "gone.toml")
    with pytest.raises(ModelError, match="is a folder"):
        load_turbine(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelError, match="not UTF-8"):
        load_turbine(binary)
