"""docs/first-plants.md, followed to the letter: the files, the commands, what they answer."""

from __future__ import annotations

import json
import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.certificates.checker import Verdict, check
from takagi.cli.main import main
from tests.solved_rest_plants import FAN
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]
ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/first-plants.md").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The plants of the page in a folder of their own; reports are tested elsewhere."""
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.plant import page

    for name, text in re.findall(r"`(\w+\.toml)`:\n\n```toml\n(.*?)```", PAGE, flags=re.DOTALL):
        (tmp_path / name).write_text(text, encoding="utf-8")
    drawn = ReportFiles("<!doctype html><title>report</title>", {})
    monkeypatch.setattr(page, "plant_report_files", lambda *_, **__: drawn)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def commands() -> list[list[str]]:
    """Return the commands of the page, in order."""
    lines = re.findall(r"^    takagi (.*)$", PAGE, flags=re.MULTILINE)
    return [shlex.split(line) for line in lines]


@pytest.mark.slow
def test_the_page_s_commands_do_what_it_says(files: Path, capsys: Capture) -> None:
    """All are proved but the last, which has no answer and writes nothing.

    The summary of the first is the page's, the checker proves every folder again, with its gain
    file and its plant file.
    """
    names = ["cruise", "magnet"]
    assert sorted(path.stem for path in files.glob("*.toml")) == names
    first, *proved, hopeless = commands()
    assert main(first) == 0
    assert re.match(summary(), capsys.readouterr().out)
    for command in proved:
        assert main(command) == 0, command
    assert main(hopeless) == 1
    assert not (files / "build/no").exists()
    for name in names:
        out = files / "build" / name
        found = check(
            out / "certificate.json", gains=out / "gains.json", model=files / f"{name}.toml"
        )
        assert found.verdict is Verdict.PROVED
        assert "Takagi-Sugeno model" in found.claims[0].name


def summary() -> str:
    """Return the page's summary as a pattern; three dots stand for anything."""
    shown = re.search(r"```text\n(.*?)```", PAGE, flags=re.DOTALL)
    assert shown is not None
    return re.escape(shown[1].strip()).replace(r"\.\.\.", "(?s:.*?)")


@pytest.mark.slow
def test_a_large_box_leaves_little_of_it_and_the_summary_says_so(
    files: Path, capsys: Capture
) -> None:
    """The magnet's first try, from 5 to 15 mm; the page's box is not called little."""
    text = (files / "magnet.toml").read_text(encoding="utf-8")
    for small, large in (
        ("[8, 12]", "[5, 15]"),
        ("[0.6, 1.4]", "[0.2, 2.5]"),
        ("0.2, 0.2", "0.5, 0.5"),
    ):
        assert small in text
        text = text.replace(small, large)
    (files / "large.toml").write_text(text, encoding="utf-8")

    told = {}
    for name in ("magnet", "large"):
        assert main(["design", f"{name}.toml", "--out", f"build/{name}", "--json"]) == 0
        told[name] = json.loads(capsys.readouterr().out)["starts_alone"]["delta_z [m]"]
    assert main(["design", "large.toml", "--out", "build/again"]) == 0

    assert "little of the ranges" in " ".join(capsys.readouterr().out.split())
    assert told["large"] < 3e-5 < 3e-4 < told["magnet"] < 2e-3


# One exothermic reaction; its rate is that at 350 K.
REACTOR = """\
format = 1
kind = "plant"
name = "Stirred tank reactor"
source = "one exothermic reaction with Arrhenius' law, figures chosen for this page"

[states]
C = { unit = "mol/L", range = [0.2, 0.8], rest = 0.5, description = "concentration" }
T = { unit = "K", range = [330, 370], rest = 350, description = "temperature" }

[inputs]
Tc = { unit = "K", range = [250, 350], rest = 300, description = "temperature of the coolant" }

[parameters]
d = { value = 1, unit = "1/min", source = "chosen: flow over volume" }
Cf = { value = 1, unit = "mol/L", source = "chosen: feed" }
Tf = { value = 350, unit = "K", source = "chosen: feed" }
k = { value = 1, unit = "1/min", source = "chosen: rate at T0" }
T0 = { value = 350, unit = "K", source = "where k was measured" }
E = { value = 8750, unit = "K", source = "chosen: activation energy over R" }
b = { value = 209.2, unit = "K L/mol", source = "chosen: heat of reaction over heat capacity" }
a = { value = 2.092, unit = "1/min", source = "chosen: cooling" }

[equations]
C = "d*(Cf - C) - k*exp(E/T0 - E/T)*C"
T = "d*(Tf - T) + b*k*exp(E/T0 - E/T)*C + a*(Tc - T)"

[design]
decay_rate = 0.03
"""


def test_a_reactor_that_does_not_rest_exactly_is_told_how_to_write_it(
    files: Path, capsys: Capture
) -> None:
    """k0 exp(-E/T) for k exp(E/T0 - E/T): a residual with its unit, and the cure."""
    plain = REACTOR.replace("k*exp(E/T0 - E/T)", "k*exp(-E/T)").replace(
        'value = 1, unit = "1/min", source = "chosen: rate',
        'value = 7.2e10, unit = "1/min", source = "chosen: rate',
    )
    assert plain.count("7.2e10") == 1
    (files / "reactor.toml").write_text(plain, encoding="utf-8")

    assert main(["design", "reactor.toml", "--out", "build"]) == 2
    told = capsys.readouterr().err
    assert "mol/m^3 per second, not 0" in told
    assert "k*exp(b/T0 - b/T)" in told


def test_the_page_s_error_is_what_is_said(files: Path, capsys: Capture) -> None:
    """The unit that is not known, with file, line and field."""
    shown = next(line for line in PAGE.splitlines() if line.startswith("    Error: "))
    path = files / "cruise.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"N"', '"Newton"'), encoding="utf-8")

    assert main(["design", "cruise.toml", "--out", "build"]) == 2
    assert capsys.readouterr().err.startswith(shown.strip().removesuffix("..."))


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
