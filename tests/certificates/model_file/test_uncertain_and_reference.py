"""`check --model` reads uncertain parameters and references of a plant file as they are meant."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.files.plant_parts import uncertain_in
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.certificate_file import dumps
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models.plant_files.loader import load_plant


@pytest.mark.parametrize(
    ("entry", "unit", "rest"),
    [
        ("[0.8, 1.3] kg", "kg", Fraction(21, 20)),
        (" [ -1e-1 , +.5 ]  m/s ", "m/s", Fraction(1, 5)),
        ("[1, 2]", "-", Fraction(3, 2)),
        ([1, 4], "-", Fraction(5, 2)),
        ({"range": [1, Decimal("1.5")], "unit": "g"}, "g", Fraction(5, 4)),
        ({"range": [1, 2], "value": Decimal("1.25")}, "-", Decimal("1.25")),
        # Ends of the largest size that is read, and no middle beyond it.
        ([Decimal("-1e100"), Decimal("3e100")], "-", Fraction(10**100)),
        ([1, Decimal("1e101")], "-", None),
        ([Decimal("1e101"), 1], "-", None),
        ([1, Decimal("1e-101")], "-", None),
        ([Decimal("NaN"), 1], "-", None),
        ([1, Decimal("Infinity")], "-", None),
        ([True, 2], "-", None),
        ([1, False], "-", None),
        (["1", 2], "-", None),
        ([1, [2]], "-", None),
        ([1, 2, 3], "-", None),
        ([1], "-", None),
        ({"range": "[1, 2]"}, "-", None),
    ],
)
def test_a_range_is_read_with_its_middle(entry: Any, unit: str, rest: Any) -> None:
    """Without a value the rest is the middle; None where the ends are no two usual numbers."""
    found = uncertain_in({"m": entry, "k": 3})

    assert list(found) == ["m"]
    assert (found["m"]["unit"], found["m"]["rest"]) == (unit, rest)


def test_the_ends_of_a_range_are_those_that_are_written() -> None:
    assert uncertain_in({"m": "[0.8, 1.3] kg"})["m"]["range"] == [Decimal("0.8"), Decimal("1.3")]
    assert uncertain_in({"m": [1, 2]})["m"]["range"] == [1, 2]


@pytest.mark.parametrize(
    "entry",
    [
        3,
        Decimal("0.5"),
        "2*k",
        "2 kg",
        "[1, 2",
        "[1, 2, 3] kg",
        {"value": 1},
        {"range": None},
        None,
    ],
)
def test_what_has_no_range_is_not_uncertain(entry: Any) -> None:
    assert uncertain_in({"m": entry}) == {}


FOLLOWED = 'r = { follow = "x", range = [-0.5, 1] }'
PLANT = f"""
format = 1
kind = "plant"
name = "drag"
units = "unchecked"
[states]
x = {{ range = [-2, 2] }}
[inputs]
u = {{ range = [-10, 10] }}
[parameters]
a = {{ range = [0.5, 1.5] }}
[outputs]
twice = {{ expression = "2*x", unit = "-" }}
[equations]
x = "u - a*x"
[reference]
{FOLLOWED}
"""


@cache
def model() -> Any:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "drag.toml"
        path.write_text(PLANT, encoding="utf-8")
        data = plant_data(secant_model(load_plant(path)))
    return read_text(dumps({"model": data}), "model")["model"]


def compared(text: str, folder: Path) -> str:
    path = folder / "drag.toml"
    path.write_text(text, encoding="utf-8")
    return compare_plant(model(), path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("{ range = [0.5, 1.5] }", "[0.5, 1.5]"),
        ("{ range = [0.5, 1.5] }", '"[0.5, 1.5]"'),
        ("{ range = [0.5, 1.5] }", "{ range = [0.5, 1.5], value = 1 }"),
        ("range = [-0.5, 1]", "range = [-0.5, 1.0], rate = 3"),
        ("range = [-0.5, 1]", 'range = [-0.5, 1.0], unit = "-"'),
    ],
)
def test_the_same_in_other_words_passes(old: str, new: str, tmp_path: Path) -> None:
    assert "not the certificate's" not in compared(PLANT.replace(old, new), tmp_path)


REFERENCE = f"[reference]\n{FOLLOWED}\n"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "{ range = [0.5, 1.5] }",
            "{ range = [0.5, 1.6] }",
            r"a.range is \[0.5, 1.6\] there",
        ),
        ("{ range = [0.5, 1.5] }", "{ range = [0.5, 1.5], value = 0.9 }", "a rests elsewhere"),
        ("{ range = [0.5, 1.5] }", "{ range = [true, 1.5] }", "a.rest is no number there"),
        ("{ range = [0.5, 1.5] }", "{ value = 1 }", "parameters are 'a' there, none in"),
        (FOLLOWED, FOLLOWED.replace('"x"', '"twice"'), "equations.r_integral is"),
        (FOLLOWED, FOLLOWED.replace('"x"', '"u"'), "reference.r.follow is no state or output"),
        (FOLLOWED, FOLLOWED.replace('"x"', "5"), "reference.r.follow is no state or output"),
        (FOLLOWED, FOLLOWED.replace("-0.5", "-0.6"), r"disturbances.r.range is \[-0.6, 1\] there"),
        (FOLLOWED, FOLLOWED.replace("r =", "s ="), "references are s there, r in the certificate"),
        (REFERENCE, "", "references are none there, r in the certificate"),
        (FOLLOWED, FOLLOWED + "\n" + FOLLOWED.replace("r =", "a2 ="), "references are a2, r there"),
        (FOLLOWED, "r = 5", r"\[reference\] is no section there"),
        (FOLLOWED, FOLLOWED + "\nq = 5", r"\[reference\] is no section there"),
        ("format = 1", "format = 1\nreference = 5", r"\[reference\] is no section there"),
    ],
)
def test_another_plant_is_refused(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert old in PLANT
    text = PLANT.replace(old, new)
    if "reference = 5" in text:
        text = text.replace(REFERENCE, "")
    with pytest.raises(OtherModel, match=words):
        compared(text, tmp_path)
