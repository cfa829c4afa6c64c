"""A finished design's folder: read by the verbs, never designed again, not overwritten."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

from takagi.cli.main import main
from takagi.models import ModelError
from takagi.reports.design_folder import appendix_files, design_files, read_design
from takagi.reports.output import write_folder
from tests.cli.conftest import contents
from tests.undrawn import blank_figures, undrawn

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The design of a plant with a reference, drawn."""
    out = tmp_path_factory.mktemp("designed") / "out"
    assert main(["design", "lorenz", "--out", str(out)]) == 0
    return out


@pytest.fixture
def never(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing may be designed."""
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
    """Status 2 and one sentence; nothing is changed."""
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
    """Nothing may be drawn."""
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
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1 and "internal error" not in said
    assert not (tmp_path / "new").exists()
