"""Old gains on a plant that has changed since: proved, or not, with the file's own model."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, check, check_document
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.design.plant.design import certify_filed, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import as_read
from takagi.cli.main import main
from takagi.models.plant_files.loader import PlantFile, load_plant
from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file
from tests.plant_files import designed_in
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]
PENDULUM = """
format = 1
kind = "plant"
name = "pendulum"
units = "unchecked"

[parameters]
mass = { value = 1, unit = "kg" }
drag = { value = 0.2, unit = "N m s^2" }

[states]
angle = { unit = "rad", range = [-1, 1] }
rate = { unit = "rad/s", range = [-2, 2] }

[inputs]
torque = { unit = "N m" }

[equations]
angle = "rate"
rate = "(9.81*sin(angle) + torque)/mass"
"""
DRAG = PENDULUM.replace("torque)/mass", "torque - drag*rate*abs(rate))/mass")


@pytest.fixture(scope="module")
def gains(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("old")
    designed_in(folder, PENDULUM)
    return folder / "gains.json"


CHANGES: dict[str, Callable[[str], str]] = {
    "a parameter": lambda text: text.replace("mass = { value = 1,", "mass = { value = 1.1,"),
    "a linear term": lambda text: text.replace("+ torque", "- 0.1*rate + torque"),
    "a term that asks for a premise": lambda _: DRAG,
    "another form of the same premise": lambda text: text.replace(
        "[equations]", '[premises]\nlift = "9.81*sin(angle)/angle"\n[equations]'
    ),
    "a smaller range": lambda text: text.replace("[-1, 1]", "[-0.9, 0.9]"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_old_gains_are_proved_on_a_changed_plant(
    change: str, gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The law of the certificate is the file's; model and premises are the new plant's.

    Whichever way was taken is printed.
    """
    plant, out = tmp_path / "plant.toml", tmp_path / "c.json"
    plant.write_text(CHANGES[change](PENDULUM), encoding="utf-8")

    assert main(["certify", str(plant), "--gains", str(gains), "--out", str(out)]) == 0

    said = capsys.readouterr().out
    kept = change in ("another form of the same premise", "a smaller range")
    assert ("the premises of their file were kept" in said) == kept
    assert ("every vertex is taken with every gain" in said) == ("asks for" in change)
    document = json.loads(out.read_text("utf-8"))
    assert document["gains"]["K"] == json.loads(gains.read_text("utf-8"))["law"]["K"]
    assert check(out, model=plant).verdict.name == "PROVED"
    assert document["model"]["equations"] and document["claims"][0]["kind"] == "sector-embedding"


def filed(text: str, gains: Path, folder: Path) -> PlantDesign:
    path = folder / "plant.toml"
    path.write_text(text, encoding="utf-8")
    return certify_filed(load_plant(path), gains, files=PlantFile.of(path).files)


def test_the_premises_of_the_file_are_kept(gains: Path, tmp_path: Path) -> None:
    """A plant whose own premise is 9.81 sin(angle)/angle is written in the old sin(angle)/angle."""
    text = CHANGES["another form of the same premise"](PENDULUM)

    found = filed(text, gains, tmp_path)

    assert "the premises of their file were kept" in found.notes and found.proved
    law = json.loads(gains.read_text("utf-8"))["law"]
    assert found.document["model"]["embedding"]["premises"] == law["premises"]
    assert found.law is not None


def test_why_the_premises_are_not_kept_is_said(gains: Path, tmp_path: Path) -> None:
    """A term |rate| has no place in the old premises: the law gets weights of its own."""
    found = filed(DRAG, gains, tmp_path)

    assert found.law is None and found.proved
    assert any("are not kept: " in word for word in found.notes)
    assert any("every vertex is taken with every gain" in word for word in found.notes)


def test_a_range_beyond_the_bounds_of_the_file(gains: Path, tmp_path: Path) -> None:
    """sin(angle)/angle leaves its bounds: said, and what is proved holds for any weights."""
    found = filed(PENDULUM.replace("[-1, 1]", "[-1.2, 1.2]"), gains, tmp_path)

    assert found.law is None
    assert any("the given bounds" in word and "leave out" in word for word in found.notes)


def test_gains_that_do_not_bear_the_change_have_status_one(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """A mass of a hundredth turns damping into drive: not proved, and no traceback."""
    plant, out = tmp_path / "plant.toml", tmp_path / "c.json"
    plant.write_text(PENDULUM.replace("9.81*sin", "981*sin"), encoding="utf-8")

    assert main(["certify", str(plant), "--gains", str(gains), "--out", str(out)]) == 1
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("angle = {", "theta = {"),
        ("range = [-2, 2] }", "range = [-2, 2] }\n[scheduling]\nw = { range = [1, 2], rest = 1 }"),
    ],
)
def test_another_plant_is_refused_with_what_is_not_its_own(
    old: str, new: str, gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Other states are another plant; a signal that no premise uses is none."""
    text = PENDULUM.replace(old, new)
    if "theta" in new:
        text = text.replace('angle = "rate"', 'theta = "rate"').replace("sin(angle)", "sin(theta)")
    plant, out = tmp_path / "plant.toml", tmp_path / "c.json"
    plant.write_text(text, encoding="utf-8")

    status = main(["certify", str(plant), "--gains", str(gains), "--out", str(out)])

    said: Any = capsys.readouterr().err
    assert "Traceback" not in said
    assert status == (2 if "theta" in new else 0)
    assert "theta" not in new or "is not the model's" in said


BALLAST = (
    PENDULUM.replace('units = "unchecked"', 'units = "unchecked"\nmeasured = ["angle"]')
    .replace("+ torque", "+ torque - ballast")
    .replace("[parameters]", '[parameters]\nballast = { value = 1, unit = "N m" }')
    .replace('torque = { unit = "N m" }', 'torque = { unit = "N m", rest = "solve" }')
)


@pytest.mark.slow
def test_a_law_of_outputs_is_proved_in_the_premises_of_its_file(
    tmp_path: Path, capsys: Capture
) -> None:
    """Also where a rest has moved; beyond the bounds of the file the reason is said."""
    plant, out = tmp_path / "plant.toml", tmp_path / "build"
    gains, again = out / "gains.json", tmp_path / "g.json"

    def certified(text: str, file: Path = gains) -> int:
        plant.write_text(text, encoding="utf-8")
        given = ["certify", str(plant), "--gains", str(file), "--out", str(tmp_path / "c.json")]
        return main([*given, "--gains-out", str(again)])

    plant.write_text(BALLAST, encoding="utf-8")
    with undrawn():
        assert main(["design", str(plant), "--out", str(out)]) == 0
    moved = BALLAST.replace("ballast = { value = 1,", "ballast = { value = 1.2,")
    assert certified(moved) == 0
    assert main(["check", str(tmp_path / "c.json"), "--gains", str(again)]) == 0
    assert certified(moved.replace("[-1, 1]", "[-0.9, 0.9]")) == 0
    assert "the premises of their file were kept" in capsys.readouterr().out
    assert certified(moved.replace("[-1, 1]", "[-1.1, 1.1]")) == 2
    assert "leave out values that it attains" in capsys.readouterr().err
    assert certified(BALLAST.replace("+ torque", "- torque")) == 1
    content = json.loads(gains.read_text("utf-8"))
    content["law"]["trim"]["input"] = [2.0]
    (tmp_path / "forged.json").write_text(json.dumps(content), encoding="utf-8")
    assert certified(BALLAST, tmp_path / "forged.json") == 2


def test_rules_that_leave_out_a_corner_are_refused(gains: Path, tmp_path: Path) -> None:
    """Weights of a law's own that do not sum to one: no proof for any weights is about them."""
    found = filed(DRAG, gains, tmp_path)
    document = json.loads(json.dumps(found.document))
    law = document["gains"]
    second = {**law["premises"][0], "name": "z2"}
    law |= {"premises": [*law["premises"], second], "rules": [[0, 0], [1, 1]]}
    for part in ("gains",):
        document["provenance"]["sha256"][part] = digest(as_read(document[part]))

    with pytest.raises(CertificateError, match="not the corners of its 2 premises"):
        check_document(document)


def test_all_that_does_not_fit_is_listed(gains: Path, tmp_path: Path, capsys: Capture) -> None:
    """A state of another name, one more state, and an input of another unit, in one message."""
    text = (
        PENDULUM.replace("angle = {", "angel = {")
        .replace('angle = "rate"', 'angel = "rate"\nload = "-load"')
        .replace("sin(angle)", "sin(angel)")
        .replace("[inputs]", "load = {}\n\n[inputs]")
        .replace('unit = "N m" }', 'unit = "N" }')
    )
    plant = tmp_path / "plant.toml"
    plant.write_text(text, encoding="utf-8")

    assert main(["certify", str(plant), "--gains", str(gains), "--out", str(tmp_path / "c")]) == 2
    said = capsys.readouterr().err
    for words in (
        "the gains need the state angle, which the plant does not have (did you mean 'angel'?)",
        "the plant has the state load, for which there are no gains",
        "input torque is in N m there and in N here",
    ):
        assert words in said


def test_the_largest_box_in_which_old_gains_hold_is_found(tmp_path: Path, capsys: Capture) -> None:
    """(1 + x^2 - k) x with k = 1.5 decays on |x| < sqrt(1/2): 22/32 holds, 23/32 does not."""
    from tests.cli.cubic import CUBIC

    small, plant = tmp_path / "small.toml", tmp_path / "plant.toml"
    small.write_text(CUBIC.replace("[-1, 1]", "[-0.5, 0.5]"), encoding="utf-8")
    plant.write_text(CUBIC, encoding="utf-8")
    found = design_plant(load_plant(small), files=PlantFile.of(small).files)
    assert isinstance(found, PlantDesign)
    content = plant_gain_file(found)
    content["law"] |= {"K": [[[1.5]]] * 2}
    gains = tmp_path / "gains.json"
    gains.write_text(dump_gains(content), encoding="utf-8")

    assert main(["certify", str(plant), "--gains", str(gains), "--out", str(tmp_path / "c")]) == 1
    said = capsys.readouterr().out
    assert "0.688 times as wide about rest: x in [-0.6875, 0.6875]" in said


def test_gains_that_hold_nowhere_are_said_to(gains: Path, tmp_path: Path, capsys: Capture) -> None:
    """A hundred times the weight: unstable at rest."""
    plant = tmp_path / "plant.toml"
    plant.write_text(PENDULUM.replace("9.81*sin", "981*sin"), encoding="utf-8")

    assert main(["certify", str(plant), "--gains", str(gains), "--out", str(tmp_path / "c")]) == 1
    said = capsys.readouterr().out
    assert "these gains do not hold the new plant near its rest; design gains anew" in said


def test_a_rate_that_old_gains_do_not_have(gains: Path, tmp_path: Path, capsys: Capture) -> None:
    """What the plant's file asks for, and what is proved instead, in one sentence."""
    plant = tmp_path / "plant.toml"
    plant.write_text(f"{PENDULUM}\n[design]\ndecay_rate = 50\n", encoding="utf-8")

    assert main(["certify", str(plant), "--gains", str(gains), "--out", str(tmp_path / "c")]) == 1
    said = capsys.readouterr().out
    assert "the plant's file asks for a decay rate of 50 1/s; with these gains" in said
    assert "1/s is proved on the whole box: ask for less in [design], or design gains anew" in said


def test_a_law_with_weights_of_its_own_keeps_its_limits(tmp_path: Path) -> None:
    """With a range of the input; this ended in an error, for the search took one gain a rule."""
    limited = PENDULUM.replace(
        'torque = { unit = "N m" }', 'torque = { unit = "N m", range = [-40, 40] }'
    )
    old, plant = tmp_path / "old.toml", tmp_path / "plant.toml"
    old.write_text(limited, encoding="utf-8")
    plant.write_text(limited.replace("torque)/mass", "torque - drag*rate*abs(rate))/mass"), "utf-8")
    found = design_plant(load_plant(old), files=PlantFile.of(old).files)
    assert isinstance(found, PlantDesign)
    gains = tmp_path / "gains.json"
    gains.write_text(dump_gains(plant_gain_file(found)), encoding="utf-8")

    proved = certify_filed(load_plant(plant), gains, files=PlantFile.of(plant).files)

    assert proved.law is None and proved.proved
    (claim,) = (c for c in proved.document["claims"] if c["kind"] == "input-limits")
    assert claim["input_limits"] == [40.0]


def test_old_gains_are_simulated_where_their_premises_are_kept(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """On a smaller range they are; a drag asks for another premise, and it is said."""
    plant = tmp_path / "plant.toml"
    options = ["--gains", str(gains), "--start", "angle=0.5"]

    plant.write_text(CHANGES["a smaller range"](PENDULUM), encoding="utf-8")
    assert main(["simulate", str(plant), *options]) == 0
    plant.write_text(DRAG, encoding="utf-8")
    assert main(["simulate", str(plant), *options]) == 2
    said = capsys.readouterr().err
    assert "the law cannot be simulated on this plant" in said and "are not kept: " in said
