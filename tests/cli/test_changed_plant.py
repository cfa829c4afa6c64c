"""Old gains on a plant that has changed since: proved, or not, with the file's own model."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from takagi.certificates.checker import CertificateError, check, check_document
from takagi.cli.main import main
from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file
from tests.certificates.kinds.claims import resealed
from tests.cli.cubic import CUBIC
from tests.plant_files import designed_in, written

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


KEPT, ANY = "the premises of their file were kept", "every vertex is taken with every gain"
LIFT = PENDULUM.replace("[equations]", '[premises]\nlift = "9.81*sin(angle)/angle"\n[equations]')
SMALLER = PENDULUM.replace("[-1, 1]", "[-0.9, 0.9]")
SIGNAL = "range = [-2, 2] }\n[scheduling]\nw = { range = [1, 2], rest = 1 }"


def certified(folder: Path, text: str, gains: Path) -> int:
    plant = written(folder, text)
    return main(["certify", str(plant), "--gains", str(gains), "--out", str(folder / "c.json")])


@pytest.mark.parametrize(
    ("text", "way"),
    [
        (PENDULUM.replace("mass = { value = 1,", "mass = { value = 1.1,"), ""),
        (PENDULUM.replace("+ torque", "- 0.1*rate + torque"), ""),
        (PENDULUM.replace("range = [-2, 2] }", SIGNAL), ""),
        # A term |rate| has no place in the old premises: the law gets weights of its own.
        (DRAG, ANY),
        # Premises of its own are 9.81 sin(angle)/angle: it is written in the old sin(angle)/angle.
        (LIFT, KEPT),
        (SMALLER, KEPT),
    ],
)
def test_old_gains_are_proved_on_a_changed_plant(
    text: str, way: str, gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The law is the file's; model and premises are the new plant's; the way is printed."""
    assert certified(tmp_path, text, gains) == 0

    said = " ".join(capsys.readouterr().out.split())
    assert [words in said for words in (KEPT, ANY)] == [words == way for words in (KEPT, ANY)]
    assert ("are not kept: " in said) == (way == ANY)
    document = json.loads((tmp_path / "c.json").read_text("utf-8"))
    law = json.loads(gains.read_text("utf-8"))["law"]
    assert document["gains"]["K"] == law["K"]
    assert check(tmp_path / "c.json", model=tmp_path / "plant.toml").verdict.name == "PROVED"
    assert document["model"]["equations"] and document["claims"][0]["kind"] == "sector-embedding"
    assert way != KEPT or document["model"]["embedding"]["premises"] == law["premises"]


@pytest.mark.parametrize(
    ("text", "status", "words"),
    [
        # sin(angle)/angle leaves its bounds: what is proved holds for any weights.
        (PENDULUM.replace("[-1, 1]", "[-1.2, 1.2]"), 0, ["the given bounds", "leave out"]),
        (PENDULUM.replace("9.81*sin", "981*sin"), 1,
         ["these gains do not hold the new plant near its rest; design gains anew"]),
        (f"{PENDULUM}\n[design]\ndecay_rate = 50\n", 1,
         ["the plant's file asks for a decay rate of 50 1/s; with these gains",
          "1/s is proved on the whole box: ask for less in [design], or design gains anew"]),
        # All that does not fit, in one message.
        (PENDULUM.replace("angle = {", "angel = {").replace("sin(angle)", "sin(angel)")
         .replace('angle = "rate"', 'angel = "rate"\nload = "-load"')
         .replace("[inputs]", "load = {}\n\n[inputs]").replace('unit = "N m" }', 'unit = "N" }'), 2,
         ["the gains need the state angle, which the plant does not have (did you mean 'angel'?)",
          "the plant has the state load, for which there are no gains",
          "is not the model's", "input torque is in N m there and in N here"]),
    ],
)  # fmt: skip
def test_what_old_gains_do_not_have_is_said(
    text: str, status: int, words: list[str], gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    assert certified(tmp_path, text, gains) == status
    said = " ".join("".join(capsys.readouterr()).split())
    assert [one for one in words if one not in said] == [] and "Traceback" not in said


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
    gains, again = tmp_path / "gains.json", tmp_path / "g.json"

    def certified(text: str, file: Path = gains) -> int:
        plant, out = written(tmp_path, text), tmp_path / "c.json"
        given = ["certify", str(plant), "--gains", str(file), "--out", str(out)]
        return main([*given, "--gains-out", str(again)])

    designed_in(tmp_path, BALLAST)
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
    certified(tmp_path, DRAG, gains)
    document = json.loads((tmp_path / "c.json").read_text("utf-8"))
    law = document["gains"]
    second = {**law["premises"][0], "name": "z2"}
    law |= {"premises": [*law["premises"], second], "rules": [[0, 0], [1, 1]]}

    with pytest.raises(CertificateError, match="not the corners of its 2 premises"):
        check_document(resealed(document))


def test_the_largest_box_in_which_old_gains_hold_is_found(tmp_path: Path, capsys: Capture) -> None:
    """(1 + x^2 - k) x with k = 1.5 decays on |x| < sqrt(1/2): 22/32 holds, 23/32 does not."""
    content = plant_gain_file(designed_in(tmp_path, CUBIC.replace("[-1, 1]", "[-0.5, 0.5]")))
    content["law"] |= {"K": [[[1.5]]] * 2}

    assert certified(tmp_path, CUBIC, written(tmp_path, dump_gains(content), "gains.json")) == 1
    said = capsys.readouterr().out
    assert "0.688 times as wide about rest: x in [-0.6875, 0.6875]" in said


def test_a_law_with_weights_of_its_own_keeps_its_limits(tmp_path: Path) -> None:
    """With a range of the input; this ended in an error, for the search took one gain a rule."""
    limit = ('torque = { unit = "N m" }', 'torque = { unit = "N m", range = [-40, 40] }')
    designed_in(tmp_path, PENDULUM.replace(*limit))

    assert certified(tmp_path, DRAG.replace(*limit), tmp_path / "gains.json") == 0
    claims = json.loads((tmp_path / "c.json").read_text("utf-8"))["claims"]
    assert [c["input_limits"] for c in claims if c["kind"] == "input-limits"] == [[40.0]]


def test_old_gains_are_simulated_where_their_premises_are_kept(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """On a smaller range they are; a drag asks for another premise, and it is said."""
    options = ["--gains", str(gains), "--start", "angle=0.5"]

    assert main(["simulate", str(written(tmp_path, SMALLER)), *options]) == 0
    assert main(["simulate", str(written(tmp_path, DRAG)), *options]) == 2
    said = capsys.readouterr().err
    assert "the law cannot be simulated on this plant" in said and "are not kept: " in said
