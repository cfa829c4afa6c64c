"""`takagi simulate`: what it prints, writes and returns; the design itself is made once."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from takagi.models import Turbine, nrel5mw
from takagi.models.laws.published.law import PublishedLaw
from takagi.reports.simulation import laws
from takagi.reports.simulation.laws import ChosenLaws
from tests.cli.conftest import contents
from tests.undrawn import blank_figures

Capture = pytest.CaptureFixture[str]
QUICK = ("simulate", "nrel5mw", "--law", "baseline", "--duration", "6")


def test_table_stands_on_standard_output(capsys: Capture) -> None:
    """Winds, laws, units; nothing on standard error, which is no terminal here."""
    status = main(QUICK)
    shown = capsys.readouterr()

    assert status == 0
    assert shown.err == ""
    for word in ("turbulent 8 m/s", "turbulent 14 m/s", "reference", "[kWh]", "[MN m]"):
        assert word in shown.out
    assert max(map(len, shown.out.splitlines())) <= 100


def test_a_sampling_too_slow_for_torsion_is_told_first(capsys: Capture) -> None:
    """Six samples in a period of 0.61 s: 0.11 s is too slow, and the advised 0.1 s is not."""
    asked = (*QUICK[:-1], "2", "--wind", "step", "--sample-time")
    assert main([*asked, "110ms"]) == 0
    told = capsys.readouterr().err
    assert told.startswith(
        "note: the law is sampled every 0.11 s, and the torsion mode has a period"
    )
    assert "sample at least every 0.1 s" in told

    assert main([*asked, "100ms"]) == 0
    assert main([*asked, "110ms", "--without", "torsion"]) == 0
    assert capsys.readouterr().err == ""


def test_winds_are_repeated_and_named(tmp_path: Path, capsys: Capture) -> None:
    """A steady wind, one of a class, and a table; --scenario is an earlier name of --wind."""
    table = tmp_path / "measured.csv"
    table.write_text("time,wind\n0,9\n3,9.5\n6,9\n", encoding="utf-8")
    asked = (*QUICK[:-1], "3", "--wind", "15m/s", "--wind", f"{table}", "--json")
    assert main([*asked, "--wind", "turbulent:9:A:3-4", "--scenario", "turbulent:9:A:4"]) == 0
    answer = json.loads(capsys.readouterr().out)

    names = ["steady 15 m/s", str(table), *(f"turbulent 9 m/s, class A, seed {k}" for k in (3, 4))]
    assert [wind["name"] for wind in answer["winds"]] == names
    assert [row["wind"] for row in answer["rows"]] == names
    assert {wind["duration"] for wind in answer["winds"]} == {3.0}
    # At rest in a steady wind nothing moves.
    assert answer["rows"][0]["pitch_travel"] < 0.01


@pytest.mark.slow
def test_same_seed_same_files_another_seed_others(tmp_path: Path, capsys: Capture) -> None:
    """Byte by byte, figures included."""
    for name in ("a", "b"):
        assert main([*QUICK, "--seed", "5", "--out", str(tmp_path / name)]) == 0
    assert "\n  summary.md" in capsys.readouterr().out
    first, same = contents(tmp_path / "a"), contents(tmp_path / "b")
    assert main([*QUICK, "--seed", "6", "--json"]) == 0
    other = json.loads(capsys.readouterr().out)

    assert first == same
    assert set(first) >= {"summary.md", "simulation.csv", "simulation.json"}
    assert json.loads(first["simulation.json"])["rows"] != other["rows"]


def test_json_names_the_files_it_wrote(tmp_path: Path, capsys: Capture) -> None:
    """Paths as given, each of them there; a gust in the wake that needs time."""
    out = tmp_path / "deep" / "folder"
    words = (*QUICK[:-2], "--wind", "gust", "--duration", "15", "--wake", "dynamic")
    with blank_figures():
        status = main([*words, "--json", "--out", str(out)])
    answer = json.loads(capsys.readouterr().out)

    assert status == 0
    assert answer["wake"] == "dynamic"
    assert len(answer["rows"]) == 3
    assert all(Path(name).is_file() for name in answer["files"])
    assert {str(out / name) for name in contents(out)} == set(answer["files"])


def test_parts_of_the_plant_can_be_left_out(capsys: Capture) -> None:
    """The answer names them, and each changes the tower's load."""
    asked = (
        (),
        ("--without", "flap"),
        ("--without", "torsion", "--without", "torque-lag"),
        ("--speed-filter", "4"),
        ("--ripple", "0.01"),
        ("--wake", "equilibrium"),
    )
    answers = []
    for words in asked:
        assert main([*QUICK, *words, "--json"]) == 0
        answers.append(json.loads(capsys.readouterr().out))

    assert answers[2]["without"] == ["torsion", "torque-lag"]
    assert (answers[3]["speed_filter"], answers[4]["ripple"]) == (4.0, 0.01)
    assert len({answer["rows"][2]["tower_del"] for answer in answers}) == len(asked)
    # Below rated wind the wake changes what torque and thrust answer, too.
    assert answers[0]["rows"][0]["energy"] != answers[5]["rows"][0]["energy"]


@pytest.mark.slow
def test_projects_and_papers_laws_run_with_the_observer(tmp_path: Path, capsys: Capture) -> None:
    """Across rated wind neither law leaves the tables; the coherent one does not fight itself."""
    names = ("coherent", "paper", "switched")
    given = [word for name in names for word in ("--law", name)]
    status = main(["simulate", "nrel5mw", *given, "--duration", "8", "--out", str(tmp_path)])
    answer = json.loads((tmp_path / "simulation.json").read_text())

    assert status == 0
    assert "effort-sharing" in capsys.readouterr().out
    assert list(answer["laws"]) == list(names)
    assert [row["law"] for row in answer["rows"]] == list(names) * 3
    for row in answer["rows"]:
        assert row["flags"]["tip_speed_ratio_clipped"] == 0
        assert row["overspeed"] < 10
    assert all(row["both_active"] < 1 for row in answer["rows"] if row["law"] == "coherent")
    series = (tmp_path / "series").glob("coherent-turbulent-14*.csv")
    for line in next(series).read_text().splitlines()[1:]:
        wind, estimate = (float(cell) for cell in line.split(",")[1:3])
        assert abs(wind - estimate) < 1.0


def test_the_printed_filter_is_an_option_of_the_simulation(tmp_path: Path, capsys: Capture) -> None:
    """It reaches the law, torque stays within rated, and other laws and names are refused."""
    run = ("simulate", "nrel5mw", "--duration", "8", "--coupling-filter")
    rated, chosen = nrel5mw().rated_torque, laws.chosen_laws
    variants = {
        name: chosen(nrel5mw(), ("paper", "switched"), coupling_filter=name)
        for name in (None, "sector")
    }
    for name, chosen_by_name in variants.items():
        law = chosen_by_name.laws["paper"]
        assert isinstance(law, PublishedLaw) and law.coupling.variant == (name or "saturated")
        # The limit of no overlap is one law: the rated torque limits torque with either filter.
        switched = chosen_by_name.laws["switched"]
        assert isinstance(switched, PublishedLaw) and switched.coupling.variant == "saturated"
        assert (switched.coupling.speed_ramp.width, switched.coupling.torque_overlap) == (0, 0)
        assert switched.full.k_x.tolist() == law.full.k_x.tolist()
        assert chosen_by_name.speed_filters["switched"] == chosen_by_name.speed_filters["paper"]
    with blank_figures():
        assert main([*run, "sector", "--law", "schulte", "--out", str(tmp_path / "out")]) == 0
    torques = []
    for series in (tmp_path / "out" / "series").glob("*.csv"):
        head, *lines = series.read_text().splitlines()
        column = head.split(",").index("generator torque [N m]")
        torques += [float(line.split(",")[column]) for line in lines]
    assert max(torques) == pytest.approx(rated, rel=1e-6)
    capsys.readouterr()
    for words, needed in (
        (("sektor", "--law", "schulte"), "did you mean 'sector'"),
        (("sector", "--law", "reference"), "an option of Schulte's law alone"),
        (("sector", "--law-from", str(tmp_path / "gains.json")), "has a filter of its own"),
    ):
        assert main([*run, *words]) == 2
        assert needed in " ".join(capsys.readouterr().err.split())


def test_divergence_has_its_own_status(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """1, with a dash in the table and the time in a sentence."""
    import numpy as np

    from takagi.models.simulation.baseline import BaselineLaw

    class Wild(BaselineLaw):
        def state_rate(self, state: Any, measurement: Any) -> Any:
            return np.array([np.inf, 0.0])

    def wild(turbine: Turbine, names: Any, **options: Any) -> ChosenLaws:
        return ChosenLaws({"baseline": Wild(turbine)}, None)

    monkeypatch.setattr(laws, "chosen_laws", wild)
    status = main(QUICK)
    shown = capsys.readouterr().out

    assert status == 1
    assert "–" in shown
    assert "before 0.02 s" in shown


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/takagi"])
def test_a_folder_that_cannot_be_written_is_told_first(
    tmp_path: Path, capsys: Capture, place: str
) -> None:
    (tmp_path / "file").write_text("kept")
    status = main([*QUICK, "--out", str(tmp_path / place)])

    assert status == 2
    assert "cannot write" in capsys.readouterr().err
    assert contents(tmp_path) == {"file": b"kept"}
