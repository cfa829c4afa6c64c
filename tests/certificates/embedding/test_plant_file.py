"""A certificate's plant against its file: equal as functions, refused where anything differs."""

from __future__ import annotations

import copy
import json
from decimal import Decimal
from fractions import Fraction
from math import pi
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError
from takagi.certificates.checker import read_text
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.files.table_file import compare_table, in_si
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.table import read_table
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import Plant, interpolate_curve, load_model, sector_model
from takagi.models.files.library import built_in_kinds, data_folder
from takagi.models.files.units import parse_unit
from tests.models.library_plants import model_of

PLANTS = sorted(name for name, kind in built_in_kinds().items() if kind == "plant")
FILE = """
format = 1
kind = "plant"
name = "Cart"

[states]
x = { unit = "mm", range = [-500, 500] }
v = { unit = "m/s", range = [-2, 2], rest = 0 }

[inputs]
F = { unit = "kN", range = [-1, 1] }

[parameters]
m = { value = 2.5, unit = "kg" }
k = { value = 3, unit = "N/m" }
h = { value = 4, unit = "N/m^3" }

[equations]
x = "v"
v = "(F - k*x - h*x^3) / m"

[outputs]
place = { expression = "2*x", unit = "m" }
"""


def written(path: Path) -> Any:
    return read_text(json.dumps(plant_data(sector_model(_plant(path)))), "model")


@pytest.fixture
def cart(tmp_path: Path) -> Path:
    path = tmp_path / "cart.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", PLANTS)
def test_every_library_plant_is_its_file_s(name: str) -> None:
    """Nothing is left to say."""
    path = data_folder() / f"{name}.toml"
    model = read_text(json.dumps(plant_data(model_of(name))), "model")

    assert compare_plant(model, path) == ""


def test_another_way_of_writing_is_the_same_plant(cart: Path) -> None:
    """The order of terms, decimals and units that mean the same."""
    model = written(cart)
    same = FILE.replace("(F - k*x - h*x^3) / m", "F/m - x*(k + h*x**2)/m").replace(
        'value = 2.5, unit = "kg"', 'value = 2500.0, unit = "g"'
    )
    cart.write_text(same, encoding="utf-8")

    assert compare_plant(model, cart) == ""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("value = 2.5", "value = 2.51", "parameters.m"),
        ('unit = "kN"', 'unit = "N"', "inputs.F.range"),
        ("range = [-500, 500]", "range = [-500, 501]", "states.x.range"),
        (", range = [-2, 2], rest = 0", "", "states.v.range"),
        ("rest = 0", "rest = 1", "v rests elsewhere"),
        ("h*x^3", "h*x^2", "equations.v"),
        ("- k*x", "+ k*x", "equations.v"),
        ('x = "v"', 'x = "2*v"', "equations.x"),
        ("2*x", "3*x", "outputs.place"),
        ("place =", "put =", "outputs are"),
        ("format = 1", "format = 1\nsample_time = 1", "sample_time is 1 there"),
        ("[outputs]", '[mass]\nv = { v = "m" }\n[outputs]', "mass matrix"),
        ("[outputs]", "[disturbances]\nw = {}\n[outputs]", "disturbances are 'w'"),
        ("k = { value = 3", "q = { value = 3", "parameters are"),
        ('kind = "plant"', 'kind = "turbine"', "no plant file"),
        ("value = 3,", "value = nan,", "parameters.k"),
        ('unit = "kN"', 'unit = "stone"', "is not known"),
        ("x^3", "x^^3", "equations.v"),
        ("[states]", "[states", "not a plant file"),
        ("[equations]", "[[equations]]", "is no section"),
        ("value = 2.5", 'value = "2.5"', "is no number"),
        ('unit = "kg"', "unit = 1", "parameters.m"),
    ],
)
def test_whatever_differs_is_named(cart: Path, old: str, new: str, words: str) -> None:
    """One number, unit, sign, name or section of the file."""
    model = written(cart)
    assert old in FILE
    cart.write_text(FILE.replace(old, new, 1), encoding="utf-8")

    with pytest.raises(CertificateError) as caught:
        compare_plant(model, cart)

    assert words in str(caught.value) and "cart.toml" in str(caught.value)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("parameters", "m"), 2.6),
        (("states", 0, "range"), [-0.5, 0.6]),
        (("equations", 1), "(F - k*x) / m"),
        (("states", 1, "name"), "w"),
        (("outputs", 0, "expression"), "x"),
    ],
)
def test_whatever_is_changed_in_the_certificate_is_seen(
    cart: Path, place: tuple[Any, ...], value: Any
) -> None:
    """The other side: the file is as it was."""
    changed: Any = copy.deepcopy(plant_data(sector_model(_plant(cart))))
    *path, last = place
    inner = changed
    for key in path:
        inner = inner[key]
    assert inner[last] != value
    inner[last] = value

    with pytest.raises(CertificateError):
        compare_plant(read_text(json.dumps(changed), "model"), cart)


def _plant(path: Path) -> Plant:
    found = load_model(path)
    assert isinstance(found, Plant)
    return found


@given(
    st.sampled_from(
        ["deg", "rpm", "kN m", "L/min", "%", "mm", "W/(m^2 K)", "1/h", "t", "-", "g/s^2"]
        + ["N/(h s)", "m/(s min)"]
    ),
    st.decimals(-1000, 1000, places=3),
)
def test_figures_in_si_are_those_of_the_reader_of_plant_files(unit: str, value: Any) -> None:
    """Two lists of units, written apart, agree to the last digit."""
    assert in_si(Fraction(value), unit) == parse_unit(unit).to_si(Fraction(value))


@pytest.mark.parametrize("unit", ["deg", "rpm", "deg/(m s)"])
@pytest.mark.parametrize("size", ["1e-30", "1e-9", "0.0572", "0.0573", "1", "1e6"])
def test_a_figure_has_ten_digits_in_every_unit(unit: str, size: str) -> None:
    """Where pi comes in the decimal is rounded: 1e-9 deg is no 1.7e-11 rad."""
    value = Fraction(size)
    found = in_si(value, unit)
    assert found == parse_unit(unit).to_si(value)
    exact = float(value) * pi / (30 if unit == "rpm" else 180)
    assert float(found) == pytest.approx(exact, rel=1e-9, abs=0)


@pytest.mark.parametrize(("off", "same"), [("0.9e-9", True), ("-0.9e-9", True), ("1.1e-9", False)])
def test_a_table_far_from_0_is_compared_by_its_range(off: str, same: bool, tmp_path: Path) -> None:
    """Values of 300 that differ by 1e-3: a millionth of that, not of 300."""
    values = ["300", "300.0004", "300.001", "300.0002", "300.0003"]
    curve = interpolate_curve(range(5), list(map(float, values)))
    data = {"knots": [curve.knots.tolist()], "coefficients": curve.coefficients.tolist()}
    table = read_table(read_text(json.dumps({"t": data}), "model"), "t", "model")
    values[1] = str(Decimal(values[1]) + Decimal(off))
    path = tmp_path / "t.csv"
    path.write_text("".join(f"{k}, {one}\n" for k, one in enumerate(values)), encoding="utf-8")
    if same:
        compare_table(path, table, ["-", "K"])
        return
    with pytest.raises(OtherModel, match="its value at 1 is"):
        compare_table(path, table, ["-", "K"])


@pytest.mark.parametrize("unit", ["Hz", "Nm", "stone", "m^", "kkg", "", "1", "m/", "/s"])
def test_units_that_are_not_in_the_list_are_refused(unit: str) -> None:
    """Never a guess."""
    with pytest.raises(Refused):
        in_si(Fraction(1), unit)
