"""`takagi design`, `check` and `simulate` for a plant with two actuators behind a blend."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

import pytest

from takagi.cli.main import main
from tests.models.blending.plants import ROOM
from tests.undrawn import blank_figures

Capture = pytest.CaptureFixture[str]
pytestmark = pytest.mark.usefixtures("proved_once")


class Sections(HTMLParser):
    """Anchors of a page's sections, and the text of one."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "section":
            self.anchors.append(dict(attrs).get("id") or "")

    def handle_data(self, data: str) -> None:
        if self.anchors and self.anchors[-1] == "blend":
            self.words.append(data)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("room")
    text = ROOM.replace(", error = 0.1", "").replace(", error = 0.2", "")
    (place / "room.toml").write_text(text, encoding="utf-8")
    words = ["design", str(place / "room.toml"), "--out", str(place / "out")]
    with blank_figures():
        assert main([*words, "--decay-rate", "0.2"]) == 0
    return place


def test_the_design_is_proved_and_checked_with_its_files(folder: Path, capsys: Capture) -> None:
    out, model = folder / "out", str(folder / "room.toml")
    files = ["--gains", str(out / "gains.json"), "--model", model]

    assert main(["check", str(out / "certificate.json"), *files]) == 0
    assert (
        "Room behind its blend, with both actuators within their limits" in capsys.readouterr().out
    )


def test_a_certificate_is_compared_with_itself(folder: Path, capsys: Capture) -> None:
    """The share's range has ends that no decimal is, 1/24: they stand there as texts."""
    certificate = folder / "out" / "certificate.json"
    model = json.loads(certificate.read_text(encoding="utf-8"))["model"]
    ranges = {signal["name"]: signal["range"] for signal in model["disturbances"]}
    assert "/" in str(ranges["share"])

    assert main(["compare", str(certificate), str(certificate)]) == 0
    assert "nothing got worse" in capsys.readouterr().out


def test_a_turbine_does_not_read_its_gains(folder: Path, capsys: Capture) -> None:
    gains = str(folder / "out" / "gains.json")

    assert main(["simulate", "nrel5mw", "--law-from", gains]) == 2
    assert f"{gains}: the law is 'pdc', not a wind turbine's" in capsys.readouterr().err


def test_the_gain_file_has_the_whole_law(folder: Path) -> None:
    gains = json.loads((folder / "out" / "gains.json").read_text(encoding="utf-8"))
    blend = gains["law"]["blending"]

    assert [signal["name"] for signal in gains["inputs"]] == ["effort_rate"]
    assert blend["overlap"] == 0.5
    assert (blend["low"]["input"], blend["low"]["direction"]) == ("cooling", -1)
    assert (blend["high"]["effectiveness"], blend["high"]["range"]) == ("x + 2", [0, 3])
    assert "(s + overlap)^2/(4 overlap)" in gains["formulas"]["ramp"]


def test_the_report_shows_both_actuators(folder: Path) -> None:
    out = folder / "out"
    page = Sections()
    page.feed((out / "report.html").read_text(encoding="utf-8"))

    assert "blend" in page.anchors
    words = " ".join(" ".join(page.words).split())
    assert "The law commands one effort" in words
    assert "cooling takes what lies below, heating what lies above" in words
    assert (out / "figures" / "hand-over.svg").is_file()


def test_a_motion_goes_through_the_hand_over(folder: Path, capsys: Capture) -> None:
    """From a warm room cooling acts first; both stay within their limits."""
    gains = ["--gains", str(folder / "out" / "gains.json")]
    start = ["--start", "x=0.1,effort=0.5", "--duration", "30"]

    assert main(["simulate", str(folder / "room.toml"), *gains, *start, "--json"]) == 0
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    assert run["settled_after"] is not None
    for name, most in (("cooling", 1.5), ("heating", 3.0)):
        low, high = run["actuators"][name]
        assert 0 <= low < high <= most
    assert run["actuators"]["cooling"][1] > 0.125 / 2  # more than at rest


def test_the_program_of_a_blend_keeps_the_effort_and_holds_both_actuators(
    folder: Path, capsys: Capture
) -> None:
    """With shorter samples its run comes nearer to the one in continuous time, as T does."""
    gains = ["--gains", str(folder / "out" / "gains.json")]
    start = ["--start", "x=0.3,effort=-0.4", "--duration", "2", "--json"]
    ends = []
    for step in ([], ["--sample-time", "40ms"], ["--sample-time", "10ms"]):
        capsys.readouterr()
        assert main(["simulate", str(folder / "room.toml"), *gains, *start, *step]) == 0
        ends.append(json.loads(capsys.readouterr().out)["runs"][0]["end"])

    for name in ("x", "effort"):
        exact, coarse, fine = (end[name] for end in ends)
        assert 0 < abs(fine - exact) < abs(coarse - exact) / 2


def test_the_effort_has_no_noise(folder: Path, capsys: Capture) -> None:
    """The law keeps it; nothing measures it."""
    gains = ["--gains", str(folder / "out" / "gains.json")]

    assert main(["simulate", str(folder / "room.toml"), *gains, "--noise", "effort=0.1"]) == 2
    assert "noise on effort: it is not measured" in capsys.readouterr().err
