"""Plant files with mistakes that a first-time user makes: each message says what to change.

Every file here is a plant of some lines with one thing wrong, or with a wish that cannot be had.
"""

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
HEAD = 'format = 1\nkind = "plant"\nunits = "unchecked"\nname = "p"\n'
X, Y = "x = { range = [-1, 1] }", "y = { range = [-1, 1] }"
U, FREE = "u = { range = [-2, 2] }", "u = {}"


def plant(states: str, inputs: str, equations: str, more: str = "") -> str:
    return f"{HEAD}[states]\n{states}\n[inputs]\n{inputs}\n[equations]\n{equations}\n{more}"


REFUSED = {
    "a division by zero at rest": (
        plant(X, U, 'x = "u + 1/x"'),
        ["equation of x", "at rest", "divides by it"],
    ),
    "a division by a state that passes 0": (
        plant(f"{X}\n{Y}", U, 'x = "y"\ny = "x/y + u"'),
        ["has a pole at y = 0", "give y a range on which the equations have a finite value"],
    ),
    "a root of a negative number": (
        plant("h = { unit = \"mm\", range = [-500, 2000], rest = 1000 }", "u = { rest = 1 }",
              'h = "u - sqrt(h)"'),
        ["The equation of h has no value where h is 0 mm or beyond, all else at rest",
         "Let the range of h end before",
         "delta_h is the deviation of h from its rest, 1000 mm"],
    ),
    "a logarithm of zero": (
        plant("h = { range = [0, 2], rest = 1 }", "u = { range = [-4, 4] }", 'h = "u - log(h)"'),
        ["has no value where h is 0 or beyond", "Let the range of h end before"],
    ),
    "a singularity in the box": (
        plant("x = { range = [-1, 3], rest = 1 }", "u = { rest = -1 }", 'x = "u + 1/x"'),
        ["has a pole", "has no value where x is 0 or beyond"],
    ),
    "a tangent beyond a quarter turn": (
        plant('x = { unit = "rad", range = [-2, 2] }', U, 'x = "u + tan(x)"'),
        ["near x in [-1.57", "give x a range on which the equations have a finite value"],
    ),
    "a part that no input moves": (
        plant(f"{X}\n{Y}", U, 'x = "x + u"\ny = "y"'),
        ["1 * y", "let an input stand in an equation that moves what grows there"],
    ),
    "an input that stands in no equation": (
        plant(X, U, 'x = "x"'),
        ["input u stands in no equation", "remove it from [inputs]"],
    ),
    "an input whose range does not hold its rest": (
        plant(X, "u = { range = [1, 3] }", 'x = "x + u"'),
        [":8: field 'inputs.u'", "outside its range [1, 3]", "widen the range"],
    ),
    "an input at the end of its range": (
        plant(X, "u = { range = [0, 3] }", 'x = "x + u"'),
        ["rests at the end of its range [0, 3]", "move the rest, or widen the range"],
    ),
    "a state at the end of its range": (
        plant('x = { unit = "mm", range = [0, 1] }', U, 'x = "x + u"'),
        ["state x rests at 0 mm, the end of its range [0, 1] mm", "widen the range"],
    ),
    "a rest that is none": (
        plant("x = { range = [-1, 3], rest = 1 }", U, 'x = "x^2 + u"'),
        ["equation of x", "at rest (x = 1, u = 0) x' is 1 per second", "--solve-rest"],
    ),
    "starts that reach beyond the range": (
        plant('x = { unit = "cm", range = [-10, 10] }', U, 'x = "x + u"',
              "[design]\ninitial = { x = 50 }"),
        ["initial of x: 50 cm was given, and the range [-10, 10] cm ends 10 cm from rest",
         "give a smaller initial, or a wider range"],
    ),
    "the largest rate without a bound": (
        plant(X, FREE, 'x = "x + u"', '[design]\ndecay_rate = "max"'),
        ["nothing bounds the gains", "give gain_bound (--gain-bound), for instance"],
    ),
    "an unknown relaxation": (
        plant(X, U, 'x = "x + u"', '[design]\nrelaxation = "foo"'),
        ["relaxation 'foo' is not known", "also auto"],
    ),
    "a state without a range": (
        plant("x = {}", FREE, 'x = "x^3 + u"'),
        ["depends on x, for which no range was given", "give each range = [low, high]"],
    ),
    "a number that no float holds": (
        plant("x = { range = [0, 2000], rest = 1 }", FREE, 'x = "u + exp(x) - exp(1)"'),
        ["its range on the box is beyond all floats", "no value where x is 709.8 or beyond",
         "or a number too large. Let the range of x end before"],
    ),
    "a number beyond decimals": (
        plant("x = { range = [-1, 1e99999999999999999999] }", U, 'x = "x + u"'),
        ["plant.toml:6: field 'states.x.range.1'"],
    ),
    "a sine beyond 1": (
        plant("x = { range = [-2, 2] }", U, 'x = "u + asin(x)"'),
        ["The equation of x has no value where x is -1 or beyond"],
    ),
    "a mass that passes 0": (
        plant(f"{X}\n{Y}", U, 'x = "u + y"\ny = "x + u"', '[mass.x]\nx = "1 - 2*y"\n'),
        ["the mass matrix may be singular", "nearest to 0 around y = 0.5", "shrink the ranges"],
    ),
    "the square of an input": (
        plant(X, "u = {}", 'x = "x + u^2"'),
        ["equation of x: u enters nonlinearly (in the term u^2)", "give it a range"],
    ),
    "damping in discrete time": (
        plant(X, U, 'x = "x/2 + u"', "[design]\ndamping = 0.7").replace(
            "[states]", "sample_time = 0.1\n[states]"
        ),
        ["damping and fastest are about poles in continuous time", "give a decay_rate instead"],
    ),
    "a misspelled state": (
        plant(X + "\nangle = { range = [-1, 1] }", U, 'x = "angel + u"\nangle = "x"'),
        [":11: field 'equations.x'", "did you mean 'angle'?"],
    ),
    "a misspelled function": (
        plant(X, U, 'x = "sine(x) + u"'),
        ["'sine' is not a function (did you mean 'sin'"],
    ),
    "a misspelled unit": (
        plant('x = { unit = "Nm", range = [-1, 1] }', U, 'x = "x + u"'),
        [":6: field 'states.x.unit'", "write 'N m'"],
    ),
    "a misspelled key": (
        plant("x = { rnge = [-1, 1] }", U, 'x = "x + u"'),
        [":6: field 'states.x.rnge'", "did you mean 'range'?"],
    ),
    "an equation for nobody": (
        plant(X, U, 'x = "x + u"\nz = "1"'),
        ["field 'equations.z'", "z is not a state; states are x"],
    ),
    "units that do not fit": (
        plant('x = { unit = "m", range = [-1, 1] }', 'u = { unit = "N" }', 'x = "u"').replace(
            "unchecked", "checked"
        ),
        ["u has the unit kg m/s^2, but x' has m/s", "correct the expression or a unit"],
    ),
}  # fmt: skip

# The first line of what is told where there are no gains.
NONE = {
    "a rate that cannot be had": (
        plant(X, U, 'x = "x + u"', "[design]\ndecay_rate = 1e8"),
        ["decay rate of 1e+08 1/s", "What to change: lower the rate (--decay-rate"],
    ),
    "a rate in the unit of the file": (
        plant('x = { unit = "mol/L", range = [-1, 1] }', 'u = { unit = "mol/(L min)" }',
              'x = "x*a + u"',
              '[parameters]\na = { value = 1, unit = "1/min" }\n[design]\ndecay_rate = 0.01\n'
              "gain_bound = 0.001").replace("unchecked", "checked"),
        ["decay rate of 0.6 1/min", "raise gain_bound"],
    ),
    "poles that are asked to be slower than the decay": (
        plant(f"{X}\n{Y}", FREE, 'x = "y"\ny = "-100*x + u"',
              "[design]\nfastest = 0.1\ndecay_rate = 1"),
        ["fastest = 0.1 1/s, the largest size of the poles", "raise it (--fastest)"],
    ),
    "a bound on the gains that is too small": (
        plant(X, FREE, 'x = "x + u"', "[design]\ngain_bound = 0.5"),
        ["Most in the way is gain_bound = 0.5, on every gain. What to change: raise it"],
    ),
    "an input whose effect changes its sign": (
        plant(X, "u = { range = [-5, 5] }", 'x = "x + x*u"'),
        ["where z1 = x is about 0, no input moves a part of the plant", "ranges that leave such"],
    ),
    "an input too small for the starts": (
        plant(X, "u = { range = [-0.5, 0.5] }", 'x = "x + u"', "[design]\ninitial = { x = 0.9 }"),
        ["Most in the way is that the set must hold all initial states", "(--initial)"],
    ),
}  # fmt: skip


def designed(text: str, folder: Path) -> int:
    path = folder / "plant.toml"
    path.write_text(text, encoding="utf-8")
    return main(["design", str(path), "--out", str(folder / "out")])


@pytest.mark.parametrize("wrong", REFUSED)
def test_a_wrong_file_is_refused_with_place_reason_and_cure(
    wrong: str, tmp_path: Path, capsys: Capture
) -> None:
    """Status 2, one message, nothing written."""
    text, words = REFUSED[wrong]

    assert designed(text, tmp_path) == 2
    message = capsys.readouterr().err
    assert message.startswith("Error: ") and "Traceback" not in message and "Warning" not in message
    for part in words:
        assert part in message, message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("wish", NONE)
def test_a_wish_that_cannot_be_had_says_first_what_to_change(
    wish: str, tmp_path: Path, capsys: Capture
) -> None:
    """Status 1; the first line is for the user, what the solver says stands behind it."""
    text, words = NONE[wish]

    assert designed(text, tmp_path) == 1
    message = capsys.readouterr().err
    first = next(line for line in message.splitlines() if line.startswith("Not proved"))
    for part in words:
        assert part in first, message
    assert "multipliers" not in first
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_disturbance_beyond_what_is_withstood_is_told_beside_the_file_s(
    tmp_path: Path, capsys: Capture
) -> None:
    """x' = x + u + w, |u| <= 2 on |x| <= 1: no set is withstood beyond |w| < 2; the file has 3."""
    text = plant(X, U, 'x = "x + u + w"', "[disturbances]\nw = { range = [-3, 3] }")

    assert designed(text, tmp_path) == 0
    message = " ".join(capsys.readouterr().out.split())
    proved = re.search(
        r"w up to ([0-9.]+): ([0-9]+) % of the stated 3 <- less than stated", message
    )
    assert proved is not None and 1.2 <= float(proved[1]) < 2
    assert int(proved[2]) == pytest.approx(float(proved[1]) / 0.03, abs=1)


def test_files_of_another_kind_are_named(tmp_path: Path, capsys: Capture) -> None:
    """A certificate or a gain file where a model is needed, and the other way round."""
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text('{"claims": [], "model": {}}', encoding="utf-8")
    gains.write_text('{"format": "takagi-gains", "certificate": {"claims": []}}', encoding="utf-8")
    out = ["--out", str(tmp_path / "out")]

    assert main(["design", str(certificate), *out]) == 2
    assert "this is a certificate, and a model is needed" in capsys.readouterr().err
    assert main(["design", str(gains), *out]) == 2
    assert "this is a gain file, and a model is needed" in capsys.readouterr().err
    assert main(["certify", "cart_pole", "--gains", str(certificate), *out]) == 2
    assert "this is a certificate, and a gain file is needed" in capsys.readouterr().err
    assert main(["certify", "cart_pole", "--gains", str(gains), *out]) == 2
    assert "this is no gain file, for 'law' is missing" in capsys.readouterr().err


ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/first-plants.md").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.plant import page

    for name, text in re.findall(r"`(\w+\.toml)`:\n\n```toml\n(.*?)```", PAGE, flags=re.DOTALL):
        (tmp_path / name).write_text(text, encoding="utf-8")
    drawn = ReportFiles("<!doctype html><title>report</title>", {})
    monkeypatch.setattr(page, "plant_report_files", lambda *_, **__: drawn)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def commands() -> list[list[str]]:
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

    printed = {}
    for name in ("magnet", "large"):
        assert main(["design", f"{name}.toml", "--out", f"build/{name}", "--json"]) == 0
        printed[name] = json.loads(capsys.readouterr().out)["starts_alone"]["delta_z [m]"]
    assert main(["design", "large.toml", "--out", "build/again"]) == 0

    assert "little of the ranges" in " ".join(capsys.readouterr().out.split())
    assert printed["large"] < 3e-5 < 3e-4 < printed["magnet"] < 2e-3


# One exothermic reaction.
REACTOR = """
format = 1
kind = "plant"
[states]
C = { unit = "mol/L", range = [0.2, 0.8], rest = 0.5 }
T = { unit = "K", range = [330, 370], rest = 350 }
[inputs]
Tc = { unit = "K", range = [250, 350], rest = 300 }
[parameters]
d = { value = 1, unit = "1/min" }
Cf = { value = 1, unit = "mol/L" }
Tf = { value = 350, unit = "K" }
k = { value = 7.2e10, unit = "1/min" }
E = { value = 8750, unit = "K" }
b = { value = 209.2, unit = "K L/mol" }
a = { value = 2.092, unit = "1/min" }
[equations]
C = "d*(Cf - C) - k*exp(-E/T)*C"
T = "d*(Tf - T) + b*k*exp(-E/T)*C + a*(Tc - T)"
"""


def test_a_reactor_that_does_not_rest_exactly_is_told_how_to_write_it(
    files: Path, capsys: Capture
) -> None:
    """k0 exp(-E/T) for k exp(E/T0 - E/T): a residual with its unit, and the cure."""
    (files / "reactor.toml").write_text(REACTOR, encoding="utf-8")

    assert main(["design", "reactor.toml", "--out", "build"]) == 2
    printed = capsys.readouterr().err
    assert "mol/m^3 per second, not 0" in printed
    assert "k*exp(b/T0 - b/T)" in printed


def test_the_page_s_error_is_what_is_said(files: Path, capsys: Capture) -> None:
    """The unit that is not known, with file, line and field."""
    shown = next(line for line in PAGE.splitlines() if line.startswith("    Error: "))
    path = files / "cruise.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"N"', '"Newton"'), encoding="utf-8")

    assert main(["design", "cruise.toml", "--out", "build"]) == 2
    assert capsys.readouterr().err.startswith(shown.strip().removesuffix("..."))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
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
    message = capsys.readouterr().out
    assert way in message and "the rest has moved" in message
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
