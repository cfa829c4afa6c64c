"""`takagi check --gains --c-source`: the C file is the gain file's export, or it fails."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.files import gain_file
from takagi.certificates.checker.kernel import reader
from takagi.certificates.design.given.turbine_law import effort_sharing_law_from_data
from takagi.cli.main import main
from takagi.models import ModelError
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code import program_reading, targets
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.c import source
from takagi.reports.code.c.comparison import source_differences
from takagi.reports.code.c.expressions import comment
from takagi.reports.code.c.source import export
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import ExportSettings
from tests.certificates.recorded.answers import recorded
from tests.reports.code.compiled import written
from tests.reports.test_gain_file_alone import PLANTS, plant_file
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def design(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("design") / "out"
    with undrawn():
        assert main(["design", "truck_trailer", "--out", str(out), "--effort", "small"]) == 0
    gains = str(out / "gains.json")
    assert main(["export", gains, "--to", "c", "--out", str(out / "c")]) == 0
    return out


def copied(design: Path, folder: Path, what: str = "", by: str = "") -> Path:
    for file in (design / "c").iterdir():
        folder.joinpath(file.name).write_bytes(file.read_bytes())
    path = folder / "truck_with_trailer.c"
    text = path.read_text(encoding="utf-8")
    new, count = re.subn(what, by, text, count=1) if what else (text, 1)
    assert count == 1
    path.write_text(new, encoding="utf-8", newline="")
    return path


def checked(design: Path, source: Path) -> int:
    certificate, gains = str(design / "certificate.json"), str(design / "gains.json")
    return main(["check", certificate, "--gains", gains, "--c-source", str(source)])


def test_what_was_exported_is_what_was_proved(
    design: Path, tmp_path: Path, capsys: Capture
) -> None:
    source = copied(design, tmp_path)
    assert checked(design, source) == 0
    assert re.search(
        r"truck_with_trailer\.c: it is the export of \S+gains\.json", capsys.readouterr().out
    )
    source.write_bytes(source.read_bytes().replace(b"\n", b"\r\n"))
    assert checked(design, source) == 0


def test_a_changed_digit_is_refused_by_name(design: Path, tmp_path: Path, capsys: Capture) -> None:
    number = r"(K_u_q\[2\] = \{\n    -?[0-9.E]+, -?[0-9.]+)"
    assert checked(design, copied(design, tmp_path, number, r"\g<1>7")) == 1
    told = capsys.readouterr().out
    assert "(law.K.*.0.1): it is " in told and "PROVED" in told
    sign = r"(K_u_x3\[2\] = \{\n    )(-?)"
    text = copied(design, tmp_path).read_text(encoding="utf-8")
    found = re.search(sign, text)
    assert found is not None
    by = r"\g<1>" if found[2] else r"\g<1>-"
    assert checked(design, copied(design, tmp_path, sign, by)) == 1
    assert "(law.K.*.0.2): it is " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("what", "by", "told"),
    [
        (r"0\.00028", "0.00029", "0.00029"),
        (r"0\.00028", "0.000280", "0.000280"),
        (r"z1_lower\) / ", "z1_lower) * ", "z1_lower) * "),
        (r"unsigned char rules\[2\] = \{\n    0", "unsigned char rules[2] = {\n    1", "law.rules"),
        (r"#include <math.h>\n", "#include <math.h>\n#define sin cos\n", "'#define sin cos'"),
        (r"0x54414B41u\n\n", "0x54414B41u ", "0x54414B41u "),
        (r"\Z", "\nint other;\n", "'(end of the file)' follows"),
        (r"\}\s*\Z", "", "'}' follows"),
        # What a compiler and a reader of C may see differently.
        (r"(->u = u;)", r"\1 // x\r    outputs->u = 0.0; // y", "outputs->u = 0.0"),
        (r"(->u = u;)", r"\1 // x\f    outputs->u = 0.0; // y", "outputs->u = 0.0"),
        (r"(->u = u;)", r"\1 /* x *\\\n/ outputs->u = 0.0; /* y */", "/* x *"),
        (r"(->u = u;)", r"\1 /* x *??/\n/ outputs->u = 0.0; /* y */", "/* x *??/"),
        (r"UNDECIDED|PROVED", "PROVED everywhere", "PROVED everywhere"),
        (r"/\* law \*/", "/* law\u2028 */", "law"),
        (r"    const", "\tconst", "'\\tconst"),
        (r" \*/\n", " */\r", "*/\\r"),
        (r"\A", "\ufeff", "truck_with_trailer.c, line 1"),
    ],
)
def test_what_differs_is_refused_by_its_line(
    what: str, by: str, told: str, design: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Byte by byte, comments and space too; only CR LF counts as LF."""
    source = copied(design, tmp_path, what, by)
    assert checked(design, source) == 1
    found = capsys.readouterr().out
    assert told in found and f"{source}, line " in found


@pytest.mark.parametrize("text", ["a *\\ int x; \\* b", "a *\n/ b", "*/ b /*", "??/", "// \r b"])
def test_no_name_or_meaning_ends_a_comment(text: str) -> None:
    found = comment(text)
    assert not re.search(r"\*/|/\*|\?\?|\\|[\r\n]", found)


def test_the_header_is_compared_too(design: Path, tmp_path: Path, capsys: Capture) -> None:
    source = copied(design, tmp_path)
    header = source.with_suffix(".h")
    text = header.read_text(encoding="utf-8")
    header.write_text(text.replace("typedef double", "typedef float"), encoding="utf-8")
    assert checked(design, source) == 1
    assert f"{header}, line " in capsys.readouterr().out
    header.unlink()
    assert checked(design, source) == 2
    assert "its header truck_with_trailer.h must be in the same folder" in capsys.readouterr().err


def test_the_gain_file_is_needed(design: Path, tmp_path: Path, capsys: Capture) -> None:
    certificate = str(design / "certificate.json")
    assert main(["check", certificate, "--c-source", str(copied(design, tmp_path))]) == 2
    assert "--c-source needs --gains FILE" in capsys.readouterr().err
    assert checked(design, tmp_path / "absent.c") == 2
    other = tmp_path / "other.c"
    other.write_text("int main(void) { return 0; }\n", encoding="utf-8")
    assert checked(design, other) == 2


@pytest.mark.parametrize("name", PLANTS)
def test_every_plant_s_export_is_its_own(name: str, tmp_path: Path) -> None:
    gains = plant_file(name, tmp_path)
    program = read_controller(gains)
    for settings in (
        ExportSettings(),
        ExportSettings("float", None if program.sample_time else 0.025),
    ):
        folder = tmp_path / settings.precision
        word = written(program, folder, settings)
        assert source_differences(folder / f"{word}.c", gains) == ()


def test_a_rest_with_an_exponent_is_a_number_in_the_example(design: Path) -> None:
    program = read_controller(design / "gains.json")
    first, *others = program.inputs
    small = replace(program, inputs=(replace(first, rest=Decimal("1e-7")), *others))
    example = export(small, ExportSettings()).files["truck_with_trailer_example.c"]

    assert " = 1E-7; /*" in str(example)


Document = dict[str, Any]


def document() -> Document:
    return dict(baseline_program(load_turbine("nrel5mw")).document)


def program_of(content: Document, folder: Path) -> ControllerProgram:
    path = folder / "gains.json"
    path.write_text(json.dumps(content, default=float))
    return read_controller(path)


DAMAGES: dict[str, tuple[Callable[[Document], object], str]] = {
    "no law": (lambda d: d.pop("law"), "'law' is missing"),
    "a program without a name": (lambda d: d.update(programs=[{}]), "'name' is missing"),
    "programs that are a text": (lambda d: d.update(programs="x"), "a part cannot be read"),
    "a program that is a number": (lambda d: d.update(programs=[3]), "cannot be read"),
}


@pytest.mark.parametrize("what", DAMAGES)
def test_a_part_that_is_damaged_is_named(what: str, tmp_path: Path) -> None:
    change, words = DAMAGES[what]
    changed = document()
    change(changed)

    with pytest.raises(ModelError, match=r"gains\.json: the gain file is damaged: ") as refused:
        program_of(changed, tmp_path)

    assert words in str(refused.value)
    assert "give the gains.json that `takagi design` has written" in str(refused.value)
    assert "Error(" not in str(refused.value)


@pytest.mark.parametrize("version", [4, 77])
def test_a_newer_version_is_refused(version: Any, tmp_path: Path) -> None:
    assert program_of(document() | {"version": 3}, tmp_path).name
    with pytest.raises(ModelError, match=rf"version {version}; this takagi reads versions up to 3"):
        program_of(document() | {"version": version}, tmp_path)


def test_the_place_of_theorems_is_looked_at_before_they_are_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    certificate = tmp_path / "certificate.json"
    certificate.write_text("{}")

    def never(document: Document) -> None:
        pytest.fail("the work has begun")

    monkeypatch.setattr("takagi.certificates.coq.coq_export.coq_file", never)
    assert main(["export", str(certificate), "--coq", str(tmp_path)]) == 2
    assert "this is a folder, and a file was expected" in capsys.readouterr().err


TURBINE = Path(__file__).parents[3] / "docs" / "figures" / "nrel5mw-certificate.json"


def with_decimals(value: Any) -> Any:
    """Return a file's content as ``read_controller`` has it."""
    if isinstance(value, dict):
        return {name: with_decimals(one) for name, one in value.items()}
    if isinstance(value, list):
        return [with_decimals(one) for one in value]
    return Decimal(value) if isinstance(value, reader.Number) else value


def file_of(kind: str) -> Document:
    """Return the gain file of a recorded certificate whose claims have this kind."""
    texts = (text for answer, text in recorded(kind) if answer[0] == ["PROVED"])
    return file_from(next(text for text in texts if "controller" in json.loads(text)))


def file_from(written: str) -> Document:
    return dict(with_decimals(gain_file.expected_file(read_text(written, "certificate"))))


@pytest.fixture(scope="module")
def turbine() -> Document:
    return file_from(TURBINE.read_text(encoding="utf-8"))


REVERSED: dict[str, tuple[str, Document]] = {
    "law.pitch_min and law.pitch_max": ("law", {"pitch_min": Decimal(2)}),
    "observer.wind_limits.0 and observer.wind_limits.1": (
        "observer",
        {"wind_limits": [Decimal(30), Decimal(1)]},
    ),
    "law.rated_torque": ("law", {"rated_torque": Decimal(-1)}),
    "law.overlap": ("law", {"overlap": Decimal("-0.01")}),
    "law.integral_limit": ("law", {"integral_limit": Decimal("-0.1")}),
    "law.wind": ("law", {"wind": [Decimal(25), Decimal(3)]}),
}


@pytest.mark.parametrize("places", REVERSED)
def test_a_turbines_file_is_refused(turbine: Document, places: str) -> None:
    assert program_reading.controller_program(turbine).kind == "turbine"
    part, change = REVERSED[places]
    changed = {**turbine, part: {**turbine[part], **change}}
    with pytest.raises(ModelError, match=rf"^{re.escape(places)}: the lower limit is .* exchange"):
        program_reading.controller_program(changed)


def test_a_plants_file_is_refused() -> None:
    plant = file_of("tracking")
    assert program_reading.controller_program(plant).kind == "plant"
    changed = deepcopy(plant)
    changed["inputs"][0]["range"].reverse()
    with pytest.raises(
        ModelError, match=r"^inputs\.0\.range\.0 and inputs\.0\.range\.1: the lower"
    ):
        program_reading.controller_program(changed)


@pytest.mark.parametrize("name", ["torque_rate", "pitch_rate"])
def test_a_rate_below_zero_is_refused(turbine: Document, name: str) -> None:
    changed = {**turbine, "limits": {**turbine["limits"], name: Decimal(-1)}}
    with pytest.raises(ModelError, match=f"^limits.{name} is -1; 0 or more is needed"):
        program_reading.controller_program(changed)


def test_equal_limits_hold_one_value(turbine: Document) -> None:
    changed = deepcopy(turbine)
    changed["law"] |= {"pitch_min": Decimal("0.1"), "pitch_max": Decimal("0.1")}
    read = ("measured_speed", "pitch", "wind_guess")
    sent = ProgramRun(program_reading.controller_program(changed)).sample(
        0.01, dict.fromkeys(read, 1.0)
    )
    assert sent["pitch_sent"] == 0.1


def test_the_command_line_says_which_entry(
    turbine: Document, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = deepcopy(turbine)
    changed["law"]["pitch_min"] = Decimal(2)
    path = tmp_path / "gains.json"
    path.write_text(json.dumps(changed, default=float), encoding="utf-8")
    assert main(["export", str(path), "--to", "c", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "law.pitch_min and law.pitch_max: the lower limit is 2 and the upper one 1.5708" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"pitch_min": 2.0}, "limits of pitch from 2 to 1.5708"),
        ({"rated_torque": -1.0}, "limits of torque from 0 to -1"),
        ({"integral_limit": -0.1}, "limits of the integral from 0.1 to -0.1"),
    ],
)
def test_a_law_is_refused(change: dict[str, float], words: str) -> None:
    """So for ``takagi certify --gains`` and ``takagi simulate --gains``, which read the law."""
    data = read_text(TURBINE.read_text(encoding="utf-8"), "certificate")
    law = effort_sharing_law_from_data(data["gains"])
    with pytest.raises(ModelError, match=f"{words} were given; the lower one must not be above"):
        replace(law, **change)  # type: ignore[arg-type]


def with_one_wind_more(turbine: Document, wind: str) -> Document:
    changed = deepcopy(turbine)
    law = changed["law"]
    for row in (one for one in law.values() if isinstance(one, list)):
        row.append(row[-1])
    law["wind"][-1] = Decimal(wind)
    return changed


@pytest.mark.parametrize(
    ("wind", "double", "single"),
    [
        ("25.00001", True, True),
        ("25.0000001", True, False),
        ("25.00000000000001", True, False),
        ("25.000000000000001", False, False),
        ("25", False, False),
    ],
)
def test_nodes_that_are_one_float_are_refused(
    turbine: Document, tmp_path: Path, wind: str, double: bool, single: bool
) -> None:
    """At 25 m/s the program computed 0/0, and sent what it had sent before."""
    changed = with_one_wind_more(turbine, wind)
    if not double:
        with pytest.raises(ModelError, match=r"^law\.wind: nodes 70 and 71 .* type double"):
            program_reading.controller_program(changed)
        return
    program = program_reading.controller_program(changed)
    assert source.c_source(program, targets.ExportSettings("double")).source
    if single:
        assert source.c_source(program, targets.ExportSettings("float")).source
        return
    with pytest.raises(ModelError, match=r"^law\.wind: .* type float.* --precision double"):
        source.c_source(program, targets.ExportSettings("float"))
