"""A plant at 1500 rpm, from its file to every export: the rest is 50 pi rad/s, no decimal."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.cli.main import main
from tests.solved_rest_plants import FAN
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The design, beside its file."""
    found = tmp_path_factory.mktemp("fan")
    (found / "fan.toml").write_text(FAN, encoding="utf-8")
    with undrawn():
        assert main(["design", str(found / "fan.toml"), "--out", str(found / "build")]) == 0
    return found


def test_the_certificate_is_about_this_file_and_these_gains(folder: Path) -> None:
    build = folder / "build"
    files = ["--model", str(folder / "fan.toml"), "--gains", str(build / "gains.json")]

    again = str(folder / "again.json")
    assert main(["check", str(build / "certificate.json"), *files, "--cross"]) == 0
    assert main(["certify", str(folder / "fan.toml"), *files[2:], "--out", again]) == 0


CHANGES = {
    "": [("k = { value = 0.8", "k = { value = 0.82")],
    "the premises of their file were kept": [("[100, 220]", "[110, 210]"), ("= 2,", "= 2.1,")],
    "every vertex is taken with every gain": [("P = { value = 500", "P = { value = 520")],
}


@pytest.mark.parametrize("way", CHANGES)
def test_old_gains_are_proved_about_a_rest_that_a_parameter_moves(
    way: str, folder: Path, tmp_path: Path, capsys: Capture
) -> None:
    """By either way; the file that is proved is written, and the old one is not taken for it."""
    text = FAN
    for old, new in CHANGES[way]:
        assert old in text
        text = text.replace(old, new)
    plant, out, new_gains = tmp_path / "fan.toml", tmp_path / "c.json", tmp_path / "g.json"
    plant.write_text(text, encoding="utf-8")
    gains, asked = folder / "build/gains.json", ["--model", str(plant)]

    given = ["certify", str(plant), "--gains", str(gains), "--out", str(out)]
    assert main([*given, "--gains-out", str(new_gains)]) == 0
    said = capsys.readouterr().out
    assert way in said and "the rest has moved" in said
    assert main(["check", str(out), *asked, "--gains", str(new_gains), "--cross"]) == 0
    laws = [json.loads(one.read_text("utf-8"))["law"] for one in (gains, new_gains)]
    assert laws[0]["K"] == laws[1]["K"] and laws[0]["trim"] != laws[1]["trim"]
    assert main(["check", str(out), *asked, "--gains", str(gains)]) == 1
    assert main(["simulate", str(plant), "--gains", str(gains)]) == 2
    assert "the rest has moved" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["c", "st", "csv", "mat"])
def test_the_law_is_exported_with_the_decimals_at_rest(folder: Path, kind: str) -> None:
    out = folder / kind
    assert main(["export", str(folder / "build/gains.json"), "--to", kind, "--out", str(out)]) == 0

    texts = [f.read_text(encoding="utf-8") for f in out.iterdir() if f.suffix != ".mat"]
    assert any("157.0796326794896" in text for text in texts)


def test_the_loop_settles_at_the_plant_s_own_rest(folder: Path) -> None:
    """The plant with its own numbers under the filed law, by another integrator."""
    gains = json.loads((folder / "build/gains.json").read_text(encoding="utf-8"))["law"]
    (premise,) = gains["premises"]
    trim, K = gains["trim"], np.array(gains["K"])
    speed = 50 * math.pi
    drag = 500 / speed**3

    def rates(_: float, x: np.ndarray) -> list[float]:
        z = drag * (x[0] - speed) + 2 * drag * speed
        high = (float(premise["upper"]) - z) / (float(premise["upper"]) - float(premise["lower"]))
        gain = high * K[0] + (1 - high) * K[1]
        (u,) = trim["input"] - gain @ (x - trim["state"])
        return [(0.8 * x[1] - drag * x[0] ** 2) / 0.02, (u - 2 * x[1] - 0.8 * x[0]) / 0.05]

    end = solve_ivp(rates, (0, 3), [speed - 10, 5.0], rtol=1e-10, atol=1e-12).y[:, -1]
    assert end == pytest.approx([speed, 500 / speed / 0.8], rel=1e-8)
