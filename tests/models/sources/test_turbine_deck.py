"""Turbines from ROSCO's files and OpenFAST's decks, by the verb that writes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from takagi.certificates.checker import Verdict, check
from takagi.cli.main import main
from takagi.models import Turbine, load_model
from tests.models.sources.deck import (
    BENDING,
    CONE,
    DENSITY,
    DISCON,
    ELASTODYN,
    HEIGHT,
    HUB,
    HUB_MASS,
    NACELLE,
    SERVODYN,
    TIP,
    TOWER_DENSITY,
    table_text,
    written_deck,
)

Capture = pytest.CaptureFixture[str]


def turbine_of(folder: Path, *options: str) -> Turbine:
    out = folder / "small.toml"
    assert main(["new", str(out), *options]) == 0
    turbine = load_model(out)
    assert isinstance(turbine, Turbine)
    return turbine


def test_the_figures_are_those_of_the_deck(tmp_path: Path) -> None:
    turbine = turbine_of(tmp_path, "--from-openfast", str(written_deck(tmp_path)))

    assert (turbine.rotor_radius, turbine.gear_ratio, turbine.air_density) == (63.0, 97.0, 1.225)
    assert turbine.hub_height == pytest.approx(90.0, abs=1e-3)  # Jonkman et al. (2009)
    assert turbine.generator_efficiency == pytest.approx(0.944)
    assert turbine.rated_rotor_speed == pytest.approx(12.1 * np.pi / 30, rel=1e-4)
    assert turbine.rated_power == pytest.approx(5e6, rel=1e-5)
    assert (turbine.cut_in, turbine.cut_out) == (3.0, 25.0)
    assert turbine.shaft_stiffness == 8.67637e8 and turbine.generator_inertia == 534.116
    assert turbine.baseline is None and "computed from the tables" in turbine.frozen_wake.source


def test_inertia_and_tower_by_hand(tmp_path: Path) -> None:
    """Uniform blades: 3 m (R^3 - r^3)/3 cos^2.  Uniform tower with phi = x^2: integrals by hand."""
    turbine = turbine_of(tmp_path, "--from-openfast", str(written_deck(tmp_path)))
    m = 1.05 * DENSITY
    blades = m * (TIP**3 - HUB**3) * np.cos(np.radians(CONE)) ** 2
    top = HUB_MASS + NACELLE + 3 * m * (TIP - HUB)
    mu, H, g = TOWER_DENSITY, HEIGHT, 9.80665
    mass = top + mu * H / 5
    stiffness = 4 * BENDING / H**3 - g * (4 * top / (3 * H) + mu / 3)

    assert turbine.rotor_inertia == pytest.approx(blades + 115926, rel=1e-4)
    assert turbine.tower_mass == pytest.approx(mass, rel=1e-5)
    assert turbine.tower_stiffness == pytest.approx(stiffness, rel=1e-5)
    assert turbine.tower_damping == pytest.approx(0.02 * np.sqrt(stiffness * mass), rel=1e-5)


def test_the_tables_are_those_of_the_file(tmp_path: Path) -> None:
    turbine = turbine_of(tmp_path, "--from-openfast", str(written_deck(tmp_path)))
    built_in = load_model("nrel5mw")
    assert isinstance(built_in, Turbine)

    for ratio, pitch in [(7.5, 0.0), (4.0, 0.3), (10.0, 0.1)]:
        assert turbine.power(ratio, pitch) == pytest.approx(built_in.power(ratio, pitch), abs=1e-6)
        assert turbine.thrust(ratio, pitch) == pytest.approx(
            built_in.thrust(ratio, pitch), abs=1e-6
        )


def test_a_tuning_file_leads_to_the_deck(tmp_path: Path) -> None:
    """What the tuning file states is taken before what the deck would give."""
    written_deck(tmp_path)
    turbine = turbine_of(tmp_path, "--from-rosco", str(tmp_path / "tuning.yaml"))
    source = turbine.figures["rotor.inertia"].source

    assert turbine.rotor_inertia == 38677040.613 and source == "rotor_inertia of tuning.yaml"
    assert turbine.cut_in == 3.0
    assert turbine.figures["tower.mass"].source.startswith("first fore-aft mode by tower.dat")


def test_what_no_file_has_is_assumed_and_said(tmp_path: Path, capsys: Capture) -> None:
    turbine = turbine_of(tmp_path, "--from-openfast", str(written_deck(tmp_path)))

    assert "pitch.time_constant = 0.2 s, assumed: no pitch drive" in capsys.readouterr().out
    assert turbine.figures["pitch.time_constant"].source.startswith("assumed: ")


def test_the_pitch_drive_of_the_controller_s_file(tmp_path: Path) -> None:
    drive = "2 ! PA_Mode - mode\n3.14 ! PA_CornerFreq - [rad/s]\n0.707 ! PA_Damping - [-]\n"
    deck = written_deck(tmp_path, discon=DISCON + drive)
    turbine = turbine_of(tmp_path, "--from-openfast", str(deck))

    assert turbine.pitch_time_constant == pytest.approx(2 * 0.707 / 3.14)
    assert (turbine.pitch_drive_frequency, turbine.pitch_drive_damping) == (3.14, 0.707)


def test_a_fine_pitch_that_sheds_no_torque_is_raised(tmp_path: Path, capsys: Capture) -> None:
    """With less torque it is reached before rated speed, unless pitch lowers power."""
    early = DISCON.replace("4.30935e+04", "3.30000e+04")
    turbine = turbine_of(tmp_path, "--from-openfast", str(written_deck(tmp_path, discon=early)))

    assert turbine.pitch_min > 0
    assert "deg; with 0 rad (PC_FinePit of DISCON.IN) the rotor does not" in capsys.readouterr().out


def test_a_figure_may_be_given(tmp_path: Path) -> None:
    deck = str(written_deck(tmp_path))
    turbine = turbine_of(tmp_path, "--from-openfast", deck, "--figure", "operation.cut_out = 22m/s")

    assert turbine.cut_out == 22.0


def test_a_table_may_be_given(tmp_path: Path) -> None:
    deck = written_deck(tmp_path, table="")
    (tmp_path / "elsewhere.txt").write_text(table_text(), encoding="utf-8")
    table = str(tmp_path / "elsewhere.txt")

    assert turbine_of(tmp_path, "--from-openfast", str(deck), "--table", table).power is not None


@pytest.mark.parametrize(
    ("texts", "options", "told"),
    [
        ({"table": ""}, [], "no Cp_Ct_Cq table is named by"),
        ({"elastodyn": ""}, [], "named and not there: elasto.dat)"),
        ({"fst": ""}, [], "has no .fst file; give the folder of one, or the file itself"),
        ({"tower": ""}, [], "tower.mass"),
        ({"table": "# Power coefficient\n1 2\n"}, [], "has no '# pitch angle'"),
        ({"table": table_text().replace("11.4", "eleven")}, [], "numbers are needed there"),
        ({"discon": "", "servodyn": SERVODYN}, [], "no file has rotor.rated_speed"),
        ({}, ["--figure", "pitch.least = 1 deg"], "did you mean"),
        ({}, ["--figure", "pitch.minimum = 1 kg"], "pitch.minimum"),
        ({}, ["--table", "nowhere.txt"], "nowhere.txt: no such file"),
        (
            {"elastodyn": ELASTODYN.replace("87.6   TowerHt", "-87.6   TowerHt")},
            [],
            "field 'rotor.hub_height'",
        ),
    ],
)
def test_what_is_missing_or_wrong_is_told(
    texts: dict[str, str], options: list[str], told: str, tmp_path: Path, capsys: Capture
) -> None:
    deck = written_deck(tmp_path, **texts)
    out = tmp_path / "small.toml"

    assert main(["new", str(out), "--from-openfast", str(deck), *options]) == 2
    assert told in capsys.readouterr().err
    assert not out.exists()


def test_several_decks_in_a_folder_are_listed(tmp_path: Path, capsys: Capture) -> None:
    deck = written_deck(tmp_path)
    (deck / "other.fst").write_text("", encoding="utf-8")

    assert main(["new", str(tmp_path / "a.toml"), "--from-openfast", str(deck)]) == 2
    assert "2 files .fst (other.fst, small.fst); name one" in capsys.readouterr().err


@pytest.mark.slow
def test_a_turbine_from_a_deck_is_designed_and_proved(tmp_path: Path) -> None:
    turbine_of(tmp_path, "--from-openfast", str(written_deck(tmp_path)))
    out = tmp_path / "out"

    assert main(["design", str(tmp_path / "small.toml"), "--out", str(out), "--no-report"]) == 0
    checked = check(out / "certificate.json", model=tmp_path / "small.toml")
    assert checked.verdict is Verdict.PROVED
