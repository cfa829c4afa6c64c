"""`check --model` compares what the file says: layout and names are nothing, a number is all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, read_text
from takagi.certificates.checker.files.given_files import EARLIER, compare_model
from takagi.certificates.checker.files.model_content import (
    OtherModel,
    _is_formula,
    _is_unit,
    model_content,
)
from takagi.certificates.design.given.kept_model import law_for
from takagi.certificates.document.certificate_file import content_of, dumps
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.cli.main import main
from takagi.models import sector_model
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import PlantFile, load_plant
from takagi.reports.baseline.comparison import changes
from tests.certificates.model_file.rewrites import Rewrite, replaced, reversed_sections
from tests.plant_files import designed_in

Capture = pytest.CaptureFixture[str]
Document = dict[str, Any]
NAME = "plant.toml"
PLANT = """# A cart on a hard spring that rubs.
format = 1
kind = "plant"
name = "rubbing cart"
source = "chosen"

[states]
x = { unit = "m", range = [-0.5, 0.5], description = "place" }
v = { unit = "m/s", range = [-1.0, 1.0] }

[inputs]
F = { unit = "N", range = [-20, 20] }

[parameters]
m = { value = 1.1, unit = "kg", source = "chosen" }
k = { value = 2, unit = "N/m" }

[tables]
rub = { file = "rub.csv", arguments = [{ name = "speed", unit = "m/s" }], unit = "N s/m" }

[equations]
x = "v"
v = "(F - k*x - rub(v)*v)/m"

[design]
decay_rate = 0.5
"""
TABLE = "# speed, friction\n-2, 0.4\n-1, 0.2\n0, 0.1\n1, 0.2\n2, 0.5\n"


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Document]:
    folder = tmp_path_factory.mktemp("cart")
    (folder / "rub.csv").write_text(TABLE, encoding="utf-8")
    design = designed_in(folder, PLANT, NAME)
    return folder, read_text(dumps(design.document), "certificate")


@pytest.fixture
def written(cart: tuple[Path, Document], tmp_path: Path) -> Callable[[Rewrite], Path]:
    def write(rewrite: Rewrite) -> Path:
        (tmp_path / "rub.csv").write_text(TABLE, encoding="utf-8")
        path = tmp_path / NAME
        path.write_bytes(rewrite(PLANT).encode())
        return path

    return write


SAME: dict[str, Rewrite] = {
    "nothing": lambda text: text,
    "a comment": lambda text: text + "# another comment\n",
    "no comment": replaced("# A cart on a hard spring that rubs.\n", ""),
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "BOM": lambda text: "\ufeff" + text,
    "blanks": lambda text: text.replace(" = ", "   =  "),
    "order of sections": reversed_sections,
    "order of keys": replaced('{ value = 2, unit = "N/m" }', '{ unit = "N/m", value = 2 }'),
    "order of states": lambda text: text.replace(
        'x = { unit = "m", range = [-0.5, 0.5], description = "place" }\n', ""
    ).replace("\n[inputs]", 'x = { unit = "m", range = [-0.5, 0.5] }\n\n[inputs]'),
    "1.10 for 1.1": replaced("1.1,", "1.10,"),
    "11e-1 for 1.1": replaced("1.1,", "11e-1,"),
    "2.0 for 2": replaced("value = 2,", "value = 2.0,"),
    "0.50 asked for": replaced("decay_rate = 0.5", "decay_rate = 0.50"),
    "1100 g for 1.1 kg": replaced('1.1, unit = "kg"', '1100, unit = "g"'),
    "a source": replaced("chosen", "guessed"),
    "a description": replaced("place", "way"),
    "the same equation": replaced("(F - k*x - rub(v)*v)/m", "(-k*x + F - rub(v)*v)/m"),
}  # fmt: skip


# Behind a blend with premises of its own; with outputs; in discrete time; with a mass.
BUILT_IN = ("boost_throttle", "quarter_car", "truck_trailer", "tora")


@pytest.mark.parametrize("name", BUILT_IN)
def test_layout_of_a_built_in_plant(name: str, tmp_path: Path) -> None:
    """Sections in reverse, CRLF, byte order mark, another name: the same plant."""
    document, text = built_in(name)
    text = "\ufeff# mine\n" + reversed_sections(text)
    (tmp_path / "mine.txt").write_bytes(text.replace("\n", "\r\n").encode())

    compare_model(document, tmp_path / "mine.txt")


def built_in(name: str) -> tuple[Document, str]:
    (file,) = PlantFile.of(name).files
    data = plant_and_claim(sector_model(load_plant(name), rest="solve inputs"))[0]
    assert data is not None
    document = {"model": data | content_of([file]), "claims": [{"kind": "effort-blend"}]}
    return read_text(json.dumps(document), "document"), file.read_text(encoding="utf-8")


def test_a_unit_that_is_left_out_is_a_dash(tmp_path: Path) -> None:
    document, text = built_in("duffing")
    for old in ("range = [-5", "value = 0.1", "value = 12", 'expression = "x"'):
        text = replaced(old, f'unit = "-", {old}')(text)
    (tmp_path / NAME).write_text(text, encoding="utf-8")

    compare_model(document, tmp_path / NAME)


def test_a_direction_in_quotes_is_another(tmp_path: Path) -> None:
    """The loader refuses it: what is proved is not about such a file."""
    document, text = built_in("boost_throttle")
    (tmp_path / NAME).write_text(replaced("direction = 1", 'direction = "1"')(text))

    with pytest.raises(OtherModel, match="low.direction is text 1 there, 1 in the certificate"):
        compare_model(document, tmp_path / NAME)


@pytest.mark.parametrize("what", SAME)
def test_layout_changes_nothing(
    what: str, cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    words = compare_model(cart[1], written(SAME[what]))

    assert EARLIER not in words


def test_other_names_of_files_change_nothing(
    cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    """Both the file and its table; the table's layout is nothing either."""
    path = written(replaced("rub.csv", "friction.csv"))
    table = "\ufeff" + TABLE.replace("0.4", "0.40").replace("\n", "\r\n") + "# end\r\n"
    (path.parent / "friction.csv").write_bytes(table.encode())
    (path.parent / "rub.csv").unlink()

    compare_model(cart[1], path.rename(path.with_name("cart.txt")))


OTHER: dict[str, tuple[Rewrite, str]] = {
    "a parameter": (replaced("1.1,", "1.2,"), "parameters.m.value is 1.2 there, 1.1 in"),
    "its last digit": (replaced("1.1,", "1.100001,"), "m.value is 1.100001 there, 1.1 in"),
    "another dimension": (replaced('"N/m"', '"N s/m"'), "parameters.k.unit is N s/m there, N/m"),
    "of a state": (replaced('"m", range', '"s", range'), "states.x.unit is s there, m in"),
    "its unit": (replaced('"kg"', '"g"'), "parameters.m.unit is g there, kg in"),
    "a range": (replaced("0.5]", "0.6]"), r"states.x.range[1] is 0.6 there, 0.5 in"),
    "an equation": (
        replaced("- k*x", "+ k*x"),
        "equations.v is (F + k*x - rub(v)*v)/m there, (F -",
    ),
    "a table's unit": (replaced('"N s/m"', '"kN s/m"'), "tables.rub.unit"),
    "an input's range": (replaced("-20,", "-10,"), r"inputs.F.range[0] is -10 there, -20 in"),
    "an option": (replaced("rate = 0.5", "rate = 0.6"), "design.decay_rate is 0.6 there, 0.5 in"),
    "no option": (replaced("decay_rate = 0.5", ""), "design.decay_rate is nothing there, 0.5 in"),
    "a name": (replaced("rubbing", "other"), "name is other cart there, rubbing cart in"),
    "a parameter more": (
        replaced("[tables]", 'g = { value = 9.81, unit = "m/s^2" }\n[tables]'),
        "parameters.g is {",
    ),
    "a dash for nothing": (replaced("[design]", '[design]\nunit = "-"'), "design.unit is - there"),
    "a dash in a table": (replaced("[tables]", '[tables]\nx = "-"'), "tables.x is - there"),
    "a dash beside": (replaced('"rub.csv",', '"rub.csv", x = "-",'), "tables.rub.x is - there"),
    "a text for a number": (
        replaced("rate = 0.5", 'rate = "0.5"'),
        "design.decay_rate is text 0.5 there, 0.5 in",
    ),
    "a text for a format": (replaced("format = 1", 'format = "1"'), "format is text 1 there, 1 in"),
    "a range of a parameter": (
        replaced("value = 2,", "value = 2, range = [1, 3],"),
        'parameters.k.range is ["1","3"] there',
    ),
    "a rest of a parameter": (replaced("value = 2,", "value = 2, rest = 0,"), "parameters.k.rest"),
    "a value of a state": (replaced('"m", r', '"m", value = 0, r'), "states.x.value is 0 there"),
    "a value of an input": (replaced('"N", r', '"N", value = 0, r'), "inputs.F.value is 0 there"),
    "a premise": (replaced("[design]", '[premises]\nz = "x"\n[design]'), "premises is {"),
    "another kind": (replaced('"plant"', '"turbine"'), "kind is turbine there, plant in"),
}


@pytest.mark.parametrize("what", OTHER)
def test_another_content_is_refused_by_field_name_with_both_values(
    what: str, cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    rewrite, words = OTHER[what]

    with pytest.raises(OtherModel) as refused:
        compare_model(cart[1], written(rewrite))
    assert words in str(refused.value)


def test_another_number_of_a_table_is_refused(
    cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    """One that is seen in the spline, and one that is below the tolerance of that comparison."""
    path = written(lambda text: text)
    for number, words in (
        ("0.41", "its value at -2 is 0.41 there, 0.4 in the certificate"),
        ("0.40000001", "tables.rub.file is numbers with SHA-256"),
    ):
        (path.parent / "rub.csv").write_text(TABLE.replace("0.4", number), encoding="utf-8")
        with pytest.raises(OtherModel, match=words):
            compare_model(cart[1], path)


UNREADABLE: dict[str, tuple[Rewrite, str]] = {
    "no TOML": (replaced("[states]", "[states"), "not a model file"),
    "no number": (replaced("1.1,", "1.1.1,"), "not a model file"),
    "a table that is not there": (replaced("rub.csv", "gone.csv"), "cannot be read"),
    "a table elsewhere": (replaced("rub.csv", "../rub.csv"), "in its folder"),
    "an absolute path": (replaced("rub.csv", "/etc/passwd"), "in its folder"),
}


@pytest.mark.parametrize("what", UNREADABLE)
def test_what_cannot_be_read_is_no_other_model(
    what: str, cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    rewrite, words = UNREADABLE[what]

    with pytest.raises(CertificateError, match=words) as refused:
        compare_model(cart[1], written(rewrite))
    assert not isinstance(refused.value, OtherModel)


def test_exit_status_0_1_and_2(
    cart: tuple[Path, Document], written: Callable[[Rewrite], Path], capsys: Capture
) -> None:
    check = ["check", str(cart[0] / "c.json"), "--gains", str(cart[0] / "gains.json"), "--model"]

    assert main([*check, str(written(lambda text: "# mine\r\n" + text))]) == 0
    capsys.readouterr()
    assert main([*check, str(written(replaced("1.1,", "1.2,")))]) == 1
    assert "Error: " in (told := capsys.readouterr().err) and "1.2 there, 1.1 in" in told
    assert main([*check, str(written(replaced("[states]", "[states")))]) == 2


def test_layout_leaves_the_certificate_as_it_is(
    cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    """So does the hash of the model in the gain file stay: no law is taken for another plant's."""
    path = written(lambda text: "# mine\r\n" + text.replace("\n", "\r\n"))

    assert content_of([path]) == content_of([cart[0] / NAME])
    stated = json.loads((cart[0] / "gains.json").read_text())["certificate"]["sha256"]["model"]
    assert stated == cart[1]["provenance"]["sha256"]["model"]


def test_a_changed_law_is_refused_whatever_the_comments_say(
    cart: tuple[Path, Document], written: Callable[[Rewrite], Path]
) -> None:
    """Gains with another premise bound, for a file with a comment more: still this very plant."""
    path = written(lambda text: text + "# mine\n")
    content = json.loads((cart[0] / "gains.json").read_text())
    content["law"]["premises"][0]["upper"] += 0.5
    other = path.with_name("gains.json")
    other.write_text(json.dumps(content), encoding="utf-8")
    plant = load_plant(path)

    with pytest.raises(CertificateError, match="premise"):
        law_for(plant, sector_model(plant), other, PlantSettings(), files=PlantFile.of(path).files)


def test_compare_tells_what_only_the_file_says(cart: tuple[Path, Document]) -> None:
    """The name is told once; hashes of bytes are told never."""
    old = cart[1]
    file = {**old["model"]["model_file"], "units": "unchecked"}
    new = {**old, "model": {**old["model"], "model_file": file}}
    new["provenance"] = {**old["provenance"], "files_sha256": {NAME: "0" * 64}}

    assert list(changes(old, old)) == []
    (one,) = changes(old, new)
    assert (one.part, one.place, one.new) == ("model file", "units", "unchecked")


@pytest.mark.parametrize("copy", [1, "x", [], {}, {"states": []}, {"states": {"x": 1}}])
def test_a_damaged_copy_is_refused(copy: Any, cart: tuple[Path, Document]) -> None:
    """Whatever stands in the certificate in the place of the file's content."""
    model = {**cart[1]["model"], "model_file": copy}

    with pytest.raises(OtherModel):
        compare_model({**cart[1], "model": model}, cart[0] / NAME)


def test_no_text_is_taken_for_a_number_or_date(tmp_path: Path) -> None:
    values = ["1", "-0", "0.1", "-1e-07", "1e+22", "inf", "-inf", "nan", "12345678901234567890"]
    values += ["2026-01-01", "2026-01-01 07:32:00+01:00", "07:32:00.5"]
    path = tmp_path / "m.toml"

    def content(written: str) -> str:
        path.write_text(f"a = {written}", encoding="utf-8")
        found = model_content(path)["a"]
        assert isinstance(found, str)
        return found

    bare = [content(value) for value in values]
    quoted = [content(f'"{text}"') for text in bare]
    twice = [content(f'"{text}"') for text in quoted]
    assert quoted == [f"text {text}" for text in bare]
    assert twice == [f"text {text}" for text in quoted]
    assert [content(f'"{text}"') for text in ("-", "x", "1/s", "2*x", "e1")] == [
        *("-", "x", "1/s", "2*x", "e1")
    ]


def test_what_counts_as_content(tmp_path: Path) -> None:
    """Numbers as short decimals, words left out, tables by their numbers."""
    path = tmp_path / "m.toml"
    path.write_text(
        'description = "d"\na = 0.10\nb = 1_000\nc = -0\nd = 1e-1\n[s]\nsource = "s"\nt = true\n'
        "big = 12345678901234567890\nwhen = 2026-01-01\n"
        '[equations]\nsource = "x"\n[coefficients]\np = "t.csv"\n',
        encoding="utf-8",
    )
    (tmp_path / "t.csv").write_text(",1\n2,3", encoding="utf-8")
    first = model_content(path)
    (tmp_path / "t.csv").write_bytes(b"# words\r\n angle , 1.0\r\n2.0,3e0\r\n")

    assert model_content(path) == first
    assert first | {"coefficients": {}} == {
        **{"a": "0.1", "b": "1000", "c": "0", "d": "0.1"},
        "s": {"t": True, "big": "0xab54a98ceb1f0ad2", "when": "2026-01-01"},
        **{"equations": {"source": "x"}, "coefficients": {}},
    }


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        (("states", "x", "unit"), True),
        (("outputs", "y", "unit"), True),
        (("tables", "cp", "unit"), True),
        (("tables", "cp", "arguments", 0, "unit"), True),
        (("blending", "effort", "unit"), True),
        (("blending", "low", "unit"), False),
        (("tables", "cp", "arguments", 0, "name"), False),
        (("equations", "x", "unit"), False),
        (("unit",), False),
    ],
)
def test_a_unit_stands_only_where_a_file_may_leave_it_out(
    path: tuple[str | int, ...], unit: bool
) -> None:
    assert _is_unit(path) is unit


@pytest.mark.parametrize(
    ("path", "formula"),
    [
        (("equations", "x"), True),
        # An output may be called so.
        (("outputs", "unit", "expression"), True),
        (("outputs", "y", "unit"), False),
        (("blending", "low", "effectiveness"), True),
        (("blending", "low", "input"), False),
        (("states", "x", "range"), False),
    ],
)
def test_a_formula_is_told_by_the_last_key(path: tuple[str, ...], formula: bool) -> None:
    assert _is_formula(path) is formula
