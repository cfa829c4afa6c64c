"""What the explorer shows of a plant: the command's design, and PROVED for accepted files alone."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import check
from takagi.certificates.design.design import NoDesign
from takagi.cli.main import main
from takagi.cli.options.plant_options import plant_settings
from takagi.models.plant_files.loader import PlantFile
from takagi.reports.explore import plant_cell
from takagi.reports.explore.axes import axes_of, command_of, grid_of, options_at
from takagi.reports.explore.books import cache_folder
from takagi.reports.explore.plant_cell import made_cell, read_checked

PENDULUM = """
format = 1
kind = "plant"
name = "Pendulum"
units = "unchecked"
[states]
theta = { unit = "deg", range = [-60, 60] }
omega = { unit = "rad/s", range = [-4, 4] }
[inputs]
tau = { unit = "N m", range = [-20, 20] }
[equations]
theta = "omega"
omega = "19.62*sin(theta) + 2*tau"
"""


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> PlantFile:
    path = tmp_path_factory.mktemp("plant") / "pendulum.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    return PlantFile.of(path)


@pytest.fixture(scope="module")
def first(pendulum: PlantFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cache") / "first"
    assert cell_of(pendulum, folder)["proved"]
    return folder


def cell_of(source: PlantFile, folder: Path, **options: Any) -> dict[str, Any]:
    return made_cell(source, options, folder, plant_settings, lambda _: None)


def test_a_position_is_the_design_of_its_command(
    pendulum: PlantFile, first: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    axes = axes_of(pendulum, read_checked(first, pendulum, pendulum.settings))
    assert [axis.name for axis in axes] == ["settle", "limit", "starts"]
    steps = (7, 5, 3)
    cell = cell_of(pendulum, tmp_path / "cell", **options_at(axes, steps))

    words = shlex.split(command_of(pendulum, options_at(axes, steps), steps))
    assert words[:2] == ["takagi", "design"]
    assert {"--settle", "--input-limit", "--initial"} <= set(words)
    monkeypatch.chdir(tmp_path)
    assert main([*words[1:], "--no-report"]) == (0 if cell["proved"] else 1)

    made = json.loads((tmp_path / words[-1] / "certificate.json").read_text(encoding="utf-8"))
    shown = [[float(value) for value in row] for row in cell["gains"]["rows"]]
    assert shown == [row for rule in made["gains"]["K"] for row in rule]
    assert check(tmp_path / "cell" / "certificate.json").verdict.name == "PROVED"


def test_a_kept_design_is_checked_again_and_not_made_again(
    pendulum: PlantFile, first: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plant_cell, "_designed", lambda *_: pytest.fail("it was kept"))

    cell = cell_of(pendulum, first)

    assert cell["proved"] and not cell["new"]


def damage_gains(folder: Path) -> None:
    for name in ("gains.json", "certificate.json", "design.json"):
        path = folder / name
        document = json.loads(path.read_text(encoding="utf-8"))
        text = json.dumps(document).replace("[[[", "[[[1", 1)
        path.write_text(text, encoding="utf-8")


def cut_certificate(folder: Path) -> None:
    (folder / "certificate.json").write_text("{}", encoding="utf-8")


def state_verdict(folder: Path) -> None:
    """Claim a set ten times as large, for which the old function proves nothing."""
    path = folder / "certificate.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    for claim in document["claims"]:
        if "level" in claim:
            claim["level"] = float(claim["level"]) * 100
    path.write_text(json.dumps(document), encoding="utf-8")


def leave_part(folder: Path) -> None:
    (folder / "design.json").unlink()


@pytest.mark.parametrize("damage", [damage_gains, cut_certificate, state_verdict, leave_part])
def test_a_changed_folder_is_never_shown_as_proved(
    pendulum: PlantFile, first: Path, tmp_path: Path, damage: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "first"
    shutil.copytree(first, folder)
    damage(folder)
    monkeypatch.setattr(plant_cell, "_designed", lambda *_: NoDesign("made anew"))

    cell = cell_of(pendulum, folder)

    assert cell["new"] or not cell["proved"]
    assert "none" in cell or not cell["proved"]


def test_a_design_for_other_requirements_is_not_taken(
    pendulum: PlantFile, first: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plant_cell, "_designed", lambda *_: NoDesign("made anew"))
    for place in ("one", "two"):
        shutil.copytree(first, tmp_path / place)
    assert cell_of(pendulum, tmp_path / "one", settle="3s")["none"] == "made anew"

    other = tmp_path / "pendulum.toml"
    other.write_text(pendulum.document.path.read_text().replace("19.62", "19.63"), encoding="utf-8")
    assert cell_of(PlantFile.of(other), tmp_path / "two")["none"] == "made anew"


def test_an_open_claim_makes_a_candidate(
    pendulum: PlantFile, first: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from takagi.certificates.design.plant.result import PlantDesign

    design = read_checked(first, pendulum, pendulum.settings)
    monkeypatch.setattr(PlantDesign, "proved", property(lambda _: False))
    monkeypatch.setattr(PlantDesign, "verdict_words", property(lambda _: "UNDECIDED"))

    cell = plant_cell.shown(design)

    assert not cell["proved"]
    assert cell["verdict"] == "UNDECIDED: a candidate"
    assert not any(plane["proved"] for plane in cell["planes"])


def test_no_design_is_an_answer_without_numbers(pendulum: PlantFile, tmp_path: Path) -> None:
    """The second time it is read; a refusal of the options is an answer too."""
    options = {"input_limit": ["tau=1"], "initial": ["theta=50"]}
    first, second = (cell_of(pendulum, tmp_path / "none", **options) for _ in range(2))

    assert "no gains" in first["none"]
    assert set(first) == {"none", "new", "seconds"}
    assert (second["none"], second["new"]) == (first["none"], False)
    assert cell_of(pendulum, tmp_path / "none", settle="3s")["proved"]
    assert "--settle" in cell_of(pendulum, tmp_path / "bad", settle="-1s")["none"]


def test_work_ends_where_it_is_told_to(pendulum: PlantFile, tmp_path: Path) -> None:
    """What ``tell`` raises passes, and leaves no folder behind."""

    def stop(_: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        made_cell(pendulum, {"settle": "3s"}, tmp_path / "cell", plant_settings, stop)
    assert not (tmp_path / "cell").exists()


def test_the_grid_is_a_part_of_the_positions(pendulum: PlantFile, first: Path) -> None:
    axes = axes_of(pendulum, read_checked(first, pendulum, pendulum.settings))
    grid = grid_of(axes)

    assert grid[0] == (0, 0, 0)
    assert 50 < len(grid) < 200
    assert all(options_at(axes, steps) is not None for steps in grid)
    assert options_at(axes, (0, 0, 0)) == {}


def test_the_cache_has_a_folder_for_each_content_and_place(
    pendulum: PlantFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "pendulum.toml"
    other.write_text(pendulum.document.path.read_text() + "\n", encoding="utf-8")
    assert cache_folder(pendulum, tmp_path) != cache_folder(PlantFile.of(other), tmp_path)

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    assert cache_folder(pendulum, None).parent == tmp_path / "mine" / "takagi" / "explore"
