"""`takagi check --gains --c-source`: the C file is the gain file's export, or it fails."""

from __future__ import annotations

import re
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import pytest

from takagi.cli.main import main
from takagi.reports.code.c.comparison import source_differences
from takagi.reports.code.c.expressions import comment
from takagi.reports.code.c.source import export
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.targets import ExportSettings
from tests.reports.code.compiled import written
from tests.reports.test_gain_file_alone import PLANTS, plant_file
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def design(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate, its gain file, and a scheduled law in C: the folder where they are."""
    out = tmp_path_factory.mktemp("design") / "out"
    with undrawn():
        assert main(["design", "truck_trailer", "--out", str(out), "--effort", "small"]) == 0
    gains = str(out / "gains.json")
    assert main(["export", gains, "--to", "c", "--out", str(out / "c")]) == 0
    return out


def copied(design: Path, folder: Path, what: str = "", by: str = "") -> Path:
    """Copy the C files of a design, with the first place of a pattern changed in the source."""
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
    """In both types, and with a time that the user chose."""
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
