"""`takagi design`: what it asks for, writes, prints and returns."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import pytest

from takagi.certificates.checker import Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.cli.main import main
from takagi.models import ModelError
from takagi.reports.design_folder import appendix_files, design_files, read_design
from takagi.reports.output import write_folder
from tests.cli.conftest import contents
from tests.undrawn import blank_figures, undrawn

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]
FILES = [
    "certificate.json",
    "design.json",
    "figures/bode.svg",
    "gains.json",
    "model/nrel5mw.toml",
    "model/nrel5mw_cp.csv",
    "model/nrel5mw_ct.csv",
    "report.html",
]


def test_the_folder_holds_what_is_promised(asked: Any, tmp_path: Path, capsys: Capture) -> None:
    """Gains, certificate, report and figures; nothing is left of the way there."""
    assert main(["design", "nrel5mw", "--out", str(tmp_path / "new" / "out")]) == 0

    assert sorted(contents(tmp_path / "new" / "out")) == FILES
    printed = capsys.readouterr().out
    assert printed.startswith("PROVED  NREL 5-MW, effort-sharing law ")
    assert all(name in printed for name in ("gains.json", "certificate.json", "report.html"))
    names = [file.name for file in asked["files"]]
    assert names == ["nrel5mw.toml", "nrel5mw_cp.csv", "nrel5mw_ct.csv"]


def test_without_a_report_a_turbine_is_not_measured(
    asked: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """Its margins and simulated runs take longer than all else that is written; no row has them."""
    monkeypatch.setattr("takagi.reports.simulation.measured_loop._measured_now", None)

    assert main(["design", "nrel5mw", "--out", str(tmp_path), "--no-report", "--json"]) == 0

    drawn = ("figures/bode.svg", "report.html")
    assert sorted(contents(tmp_path)) == [name for name in FILES if name not in drawn]
    rows = {row["name"] for row in json.loads(capsys.readouterr().out)["summary"]}
    assert "rotor speed" in rows and not rows & {"margins", "turbulence", "overspeed"}


def test_the_summary_quotes_the_certificate(
    asked: Any, finished: TurbineDesign, tmp_path: Path, capsys: Capture
) -> None:
    """Winds, overspeed and decay on the terminal are those that the checker states."""
    main(["design", "nrel5mw", "--out", str(tmp_path), "--json"])
    printed = json.loads(capsys.readouterr().out)
    stated = finished.checked.claims[0].text
    shown = [float(text) for text in re.findall(r"-?[0-9]+(?:\.[0-9]+)?(?:e-?[0-9]+)?", stated)]

    assert printed["verdict"] == "PROVED"
    rows = {row["name"]: row for row in printed["summary"]}
    for name in ("rotor speed", "wind limits", "settling"):
        assert rows[name]["claim"] == finished.checked.claims[0].name and rows[name]["proved"]
    numbers = [n for name in ("wind limits", "settling") for n in rows[name]["numbers"]]
    for number in [*numbers, rows["rotor speed"]["numbers"][0]]:
        assert any(number["value"] == pytest.approx(text, rel=1e-2) for text in shown)
    assert sorted(printed["files"]) == [str(tmp_path / name) for name in FILES]


def test_the_summary_names_what_the_verdict_assumes(
    asked: Any, finished: TurbineDesign, tmp_path: Path, capsys: Capture
) -> None:
    """What all claims assume in 20 lines, each claim's own with --all and for a program."""
    main(["design", "nrel5mw", "--out", str(tmp_path / "a")])
    answer = capsys.readouterr().out.split("\n\n", 1)[0]
    main(["design", "nrel5mw", "--out", str(tmp_path / "a"), "--all", "--force"])
    everything = " ".join(capsys.readouterr().out.split())
    main(["design", "nrel5mw", "--out", str(tmp_path / "b"), "--json"])

    assert len(answer.splitlines()) <= 20 and max(map(len, answer.splitlines())) <= 100
    assert "two steps: gains wind by wind" in everything
    words = " ".join(answer.split())
    for claim in finished.checked.claims:
        assert f"assumes: {'; '.join(claim.assumes)}" in everything
    shared = set.intersection(*(set(claim.assumes) for claim in finished.checked.claims))
    assert shared and all(phrase in words for phrase in shared)
    printed = json.loads(capsys.readouterr().out)["claims"]
    assert [claim["assumes"] for claim in printed] == [
        list(claim.assumes) for claim in finished.checked.claims
    ]


def test_next_commands_can_be_typed_as_printed(asked: Any, tmp_path: Path, capsys: Capture) -> None:
    """The check that is suggested exists, and accepts what was written with both companions."""
    main(["design", "nrel5mw", "--out", str(tmp_path)])
    lines = capsys.readouterr().out.splitlines()
    command = next(line.split() for line in lines if line.strip().startswith("takagi check"))

    assert main([*command[1:], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["verdict"], told["messages"]) == ("PROVED", [])


def test_options_reach_the_design(asked: Any, tmp_path: Path) -> None:
    """Each option sets its own field; inertia stays the decimals that were written."""
    options = ["--overlap", "0.02", "--speed-setpoint", "11.5 rpm", "--bandwidth", "0.5"]
    options += ["--inertia", "0.8", "1.3", "--equilibrium-wake"]

    main(["design", "nrel5mw", "--out", str(tmp_path), *options])

    settings = asked["settings"]
    assert settings.overlap == 0.02 and settings.effort.bandwidth == 0.5
    assert settings.speed_setpoint == pytest.approx(11.5 * pi / 30)
    assert settings.uncertainty.inertia.lower == Fraction(4, 5)
    assert settings.effort.inertia == (0.8, 1.3)
    assert not settings.uncertainty.frozen_wake

    options = ["--law", "paper", "--speed-overlap", "0.1", "--torque-overlap", "1500"]
    main(["design", "nrel5mw", "--out", str(tmp_path / "paper"), *options])

    settings = asked["settings"]
    assert (settings.law, settings.speed_overlap, settings.torque_overlap) == ("paper", 0.1, 1500)


def test_the_loop_that_runs_is_looked_at_before_the_design(
    asked: Any, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the settings of the design: a note is told and kept, an unstable loop is an answer."""
    looked = []

    def noted(turbine: Any, settings: Any, tell: Any) -> tuple[str, ...]:
        tell("trying --bandwidth 0.3")
        looked.append((turbine, settings))
        return ("small margins: at 11 m/s",)

    place = "takagi.reports.margins.running_stability.require_stable"
    monkeypatch.setattr(place, noted)
    assert main(["design", "nrel5mw", "--out", str(tmp_path / "a"), "--bandwidth", "0.5"]) == 0
    told = capsys.readouterr()
    assert looked == [(asked["turbine"], asked["settings"])]
    assert "note: small margins: at 11 m/s\n" in told.err
    assert "small margins: at 11 m/s" in told.out

    def unstable(*_: Any) -> None:
        raise ModelError("at 11 m/s it grows")

    monkeypatch.setattr(place, unstable)
    assert main(["design", "nrel5mw", "--out", str(tmp_path / "b")]) == 1
    assert "stability of the loop that runs: at 11 m/s it grows" in capsys.readouterr().err
    assert not (tmp_path / "b").exists()


def test_what_is_not_proved_is_written_and_returns_one(
    asked: Any, finished: TurbineDesign, tmp_path: Path, capsys: Capture, monkeypatch: Any
) -> None:
    """An UNDECIDED certificate lists what fails; it is kept, and the status says so."""
    claim = Claim("loop", Verdict.UNDECIDED, "wind 11.4 to 11.5 m/s: a corner fails")
    undecided = replace(finished, checked=concluded([claim, *finished.checked.claims[1:]], []))
    monkeypatch.setattr(
        "takagi.certificates.design.turbine.design.design_turbine", lambda *_, **__: undecided
    )

    assert main(["design", "nrel5mw", "--out", str(tmp_path)]) == 1

    printed = capsys.readouterr().out
    assert printed.startswith("UNDECIDED") and "wind 11.4 to 11.5 m/s" in printed
    assert sorted(contents(tmp_path)) == FILES


def test_a_second_design_replaces_the_first_and_leaves_the_rest(asked: Any, tmp_path: Path) -> None:
    """Files of the user's own in the folder stay."""
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "gains.json").write_text("old")

    main(["design", "nrel5mw", "--out", str(tmp_path), "--force"])

    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert "law" in json.loads((tmp_path / "gains.json").read_text())


def test_the_synthesis_that_is_asked_for_reaches_the_design(asked: Any, tmp_path: Path) -> None:
    """Two steps are the default; --one-step and --objective set their fields."""
    from takagi.lmi.turbine.one_step.design_point import OBJECTIVES

    for options, synthesis, objective in (
        ((), "two-step", None),
        (("--one-step",), "one-step", "balanced"),
        (("--two-step",), "two-step", None),
        (("--objective", "decay"), "one-step", "decay"),
    ):
        main(["design", "nrel5mw", "--out", str(tmp_path), "--force", *options])
        assert asked["settings"].synthesis == synthesis
        assert objective is None or asked["settings"].objective == OBJECTIVES[objective]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("designed") / "out"
    assert main(["design", "lorenz", "--out", str(out)]) == 0
    return out


@pytest.fixture
def never(monkeypatch: pytest.MonkeyPatch) -> None:
    from takagi.certificates.design.plant import design

    monkeypatch.setattr(design, "design_plant", None)


def test_pages_of_a_read_design_have_the_same_bytes(
    folder: Path, never: None, tmp_path: Path
) -> None:
    """Report, figures and appendix; the gain file and the certificate stay as they are."""
    before = contents(folder)

    assert main(["report", str(folder)]) == 0
    assert contents(folder) == before

    design = read_design(folder)
    assert design.proved
    with undrawn():
        again = contents(write_folder(tmp_path / "again", design_files(design)))
    drawn = {"report.html", "figures/phase.svg"}
    assert again.keys() > drawn
    assert all(again[name] == before[name] for name in again.keys() - drawn)
    with blank_figures():
        assert main(["appendix", str(folder), "--out", str(tmp_path)]) == 0
        written = (tmp_path / "appendix-body.tex").read_text(encoding="utf-8")
        assert written == appendix_files(design)["appendix-body.tex"]


def test_the_other_verbs_read_the_folder_too(
    folder: Path, never: None, tmp_path: Path, capsys: Capture
) -> None:
    """Its certificate with gains and model, its law to run and to export; status 0."""
    capsys.readouterr()
    assert main(["check", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["messages"] == []
    junit, markdown = tmp_path / "junit.xml", tmp_path / "summary.md"
    assert main(["check", str(folder), "--junit", str(junit), "--summary", str(markdown)]) == 0
    rests = {p.get("name"): p.get("value") for p in ElementTree.parse(junit).iter("property")}
    assert str(rests["input: rests on"]).startswith("proved: ")
    assert "not proved" in str(rests["margins: rests on"])
    assert "| gains | " in markdown.read_text() and "| in gains.json |" in markdown.read_text()
    assert main(["simulate", str(folder), "--duration", "0.1"]) == 0
    for target in ("c", "st", "mat"):
        assert main(["export", str(folder), "--to", target, "--out", str(tmp_path / target)]) == 0
        page = (tmp_path / target / "README.md").read_text(encoding="utf-8")
        assert "continuous time" in page and "x -30 to 30" in page and "inputs within" in page
    assert main(["export", str(folder), "--coq", str(tmp_path / "proof.v")]) in (0, 1)
    page_file = tmp_path / "page.html"
    assert main(["compare", str(folder), str(folder), "--html", str(page_file)]) == 0
    assert "Lorenz system" in page_file.read_text(encoding="utf-8")


def test_missing_tex_is_named_with_its_cure(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """The files are written all the same."""
    monkeypatch.setattr("takagi.cli.verbs.appendix.which", lambda _: None)

    with blank_figures():
        assert main(["appendix", str(folder), "--out", str(tmp_path)]) == 0
    assert "apt install texlive" in capsys.readouterr().out
    assert (tmp_path / "appendix.bib").is_file()


def test_a_design_is_replaced_with_force_only(
    undrawn: None, cubic: Path, tmp_path: Path, capsys: Capture
) -> None:
    out = tmp_path / "out"
    assert main(["design", str(cubic), "--out", str(out)]) == 0
    before = (out / "design.json").read_bytes()

    assert main(["design", str(cubic), "--out", str(out), "--decay-rate", "3"]) == 2
    assert "--force" in capsys.readouterr().err
    assert (out / "design.json").read_bytes() == before
    assert main(["design", str(cubic), "--out", str(out), "--decay-rate", "3", "--force"]) == 0
    assert (out / "design.json").read_bytes() != before


def test_without_a_report_a_folder_is_a_design_too(
    never_drawn: None, cubic: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The other verbs read it, and no page about an earlier law stays beside it."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.html").write_text("earlier")

    assert main(["design", str(cubic), "--out", str(out), "--no-report"]) == 0
    assert "report.html" not in capsys.readouterr().out
    names = {"certificate.json", "design.json", "gains.json", f"model/{cubic.name}"}
    assert set(contents(out)) == names
    assert main(["check", str(out)]) == 0


def test_an_interrupted_drawing_leaves_law_and_proof(
    cubic: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """And the answer was printed before; the report is made later."""
    out = tmp_path / "out"

    def interrupted(*_: object, **__: object) -> None:
        assert capsys.readouterr().out.startswith("PROVED")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("takagi.reports.design_folder.report_files", interrupted)
        assert main(["design", str(cubic), "--out", str(out)]) == 130
    assert {"certificate.json", "design.json", "gains.json"} <= set(contents(out))
    assert read_design(out).proved


@pytest.fixture
def never_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("takagi.reports.design_folder.report_files", None)


def _without(name: str) -> Callable[[Path], None]:
    return lambda place: (place / name).unlink()


def _changed(name: str, old: str, new: str) -> Callable[[Path], None]:
    def spoil(place: Path) -> None:
        text = (place / name).read_text(encoding="utf-8")
        assert old in text
        (place / name).write_text(text.replace(old, new), encoding="utf-8")

    return spoil


def test_gains_of_the_record_are_the_proved_ones(folder: Path, tmp_path: Path) -> None:
    """Else the page would show gains and margins that nobody proved."""
    place = tmp_path / "out"
    shutil.copytree(folder, place)
    record = json.loads((place / "design.json").read_text(encoding="utf-8"))
    record["design"]["members"]["gains"]["array"][0] = 99.0
    (place / "design.json").write_text(json.dumps(record), encoding="utf-8")

    with pytest.raises(ModelError, match="gains are not the certificate's"):
        read_design(place)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (shutil.rmtree, "no such folder"),
        (_without("design.json"), "design.json is missing"),
        (_without("gains.json"), "gains.json is missing"),
        (_without("model/lorenz.toml"), "lorenz.toml is missing"),
        (_changed("model/lorenz.toml", "28", "29"), "lorenz.toml"),
        (_changed("design.json", '"relaxation"', '"of_old"'), "--force"),
        (_changed("design.json", "takagi.lmi.answer:Answer", "subprocess:Popen"), "no record"),
        (_changed("design.json", '{"derived":"checked"}', '{"tuple":[]}'), "'checked' of its own"),
        (_changed("design.json", '"gains":{"array":[', '"gains":{"array":[9e9,'), "design.json"),
        (_changed("design.json", '"model":"model/', '"model":"../'), "outside of model/"),
        (_changed("design.json", "{", "[{"), "is damaged"),
    ],
)
def test_a_folder_that_is_no_whole_design_is_one_sentence(
    folder: Path, spoil: Callable[[Path], None], words: str, tmp_path: Path, capsys: Capture
) -> None:
    """Status 2, what is wrong, and nothing written."""
    place = tmp_path / "out"
    shutil.copytree(folder, place)
    spoil(place)
    capsys.readouterr()

    assert main(["report", str(place), "--out", str(tmp_path / "new")]) == 2
    message = capsys.readouterr().err
    assert words in message and message.count("\n") == 1 and "internal error" not in message
    assert not (tmp_path / "new").exists()
