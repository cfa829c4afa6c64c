"""Units as text, and that equations fit by them."""

from __future__ import annotations

from fractions import Fraction
from math import pi
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from takagi.certificates.checker.files.table_file import in_si
from takagi.models import (
    Interval,
    ModelError,
    Output,
    Parameter,
    Plant,
    Variable,
    interpolate_curve,
    table_function,
)
from takagi.models.files.units import UNITS, parse_unit
from takagi.models.plant.plant import file_unit, rate_in_file_units, time_in_file_units
from takagi.models.plant_files.loader import load_plant
from tests.plant_files import filed_plant

X, V, F, M, K, L = sp.symbols("x v F m k L", real=True)


@pytest.mark.parametrize("text", sorted(set(UNITS) - {"Hz"}))
def test_a_turbine_file_converts_the_same_units_by_the_same_factors(text: str) -> None:
    """Two tables written at different times; Hz, which may mean two things, is refused here."""
    si, factor = UNITS[text]
    found = parse_unit(text)

    assert float(found.factor) * pi**found.pi_power == pytest.approx(factor)
    assert parse_unit(si).dimension == found.dimension
    assert parse_unit(found.si).is_si


@pytest.mark.parametrize(
    ("text", "si", "dimension"),
    [
        ("N m", "N m", "kg m^2/s^2"),
        ("W/(m^2 K)", "W/(m^2 K)", "kg/(s^3 K)"),
        ("1/s", "1/s", "1/s"),
        ("rpm/s", "rad/s^2", "1/s^2"),
        ("mm", "m", "m"),
        ("%", "-", "-"),
        ("V", "V", "kg m^2/(s^3 A)"),
        ("N*m", "N*m", "kg m^2/s^2"),
        ("cm^2.5/s", "m^2.5/s", "m^2.5/s"),
        ("s/m^(1/3)", "s/m^(1/3)", "s/m^(1/3)"),
        ("L/(min bar^0.5)", "m^3/(s Pa^0.5)", "m^3.5/kg^0.5"),
    ],
)
def test_a_unit_has_dimensions_and_a_name_in_si(text: str, si: str, dimension: str) -> None:
    found = parse_unit(text)

    assert (found.si, str(found.dimension)) == (si, dimension)


@pytest.mark.parametrize(
    ("product", "unit"),
    [("A s", "C"), ("V A", "W"), ("V/A", "Ohm"), ("A/V", "S"), ("C/V", "F"), ("V s", "Wb")]
    + [("Wb/A", "H"), ("Wb/m^2", "T"), ("N m", "J"), ("J/s", "W"), ("N/m^2", "Pa"), ("F Ohm", "s")],
)
def test_derived_units_hang_together(product: str, unit: str) -> None:
    """BIPM, The International System of Units, 9th ed. (2019), table 4."""
    assert parse_unit(product).dimension == parse_unit(unit).dimension


@pytest.mark.parametrize(
    "text",
    ["cm^2.5/s", "s/cm^(1/3)", "L/(min bar^0.5)", "m^0.5/cm^0.5", "rpm/min^0.5", "kPa^-0.5", "mm"],
)
def test_the_checker_converts_a_root_to_the_same_decimal(text: str) -> None:
    """Exactly where the root is a fraction, as of 100 cm in 1 m; else to 15 digits."""
    for value in (Fraction("15.3"), Fraction("-2e-9"), Fraction(0)):
        assert in_si(value, text) == parse_unit(text).to_si(value)
    assert in_si(Fraction(15), "cm^2.5/s") == Fraction("0.00015")


def test_conversion_is_exact_and_to_twelve_decimals_with_pi() -> None:
    assert parse_unit("mm").to_si(Fraction(1, 3)) == Fraction(1, 3000)
    assert parse_unit("deg").to_si(Fraction(180)) == Fraction("3.141592653590")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Nm", "write 'N m'"),
        ("rads", "did you mean 'rad'"),
        ("Hz", "write '1/s' or 'rad/s'"),
        ("kg/m s", "brackets"),
        ("L/s/m", "brackets"),
        ("m2", "did you mean 'm^2'"),
        ("°C", "temperatures are in K"),
        ("1", "'-'"),
        ("", "'-'"),
        ("m^99", "power 99"),
        ("m^0.0", "power 0"),
        ("m^(1/0)", "not known"),
        ("m^1:2", "not known"),
        ("deg^0.5", "with rad"),
        ("m^s", "not known"),
        ("9**9**9", "not known"),
    ],
)
def test_a_unit_that_is_not_known_is_refused_with_a_cure(text: str, words: str) -> None:
    with pytest.raises(ModelError, match=words.replace("^", r"\^")):
        parse_unit(text)


def spring(**changes: object) -> Plant:
    """x' = v, m v' = F - k x, with every unit stated."""
    given: dict[str, object] = {
        "equations": (V, F - K * X),
        "states": (
            Variable(X, "m", Interval.of(-1, 1)),
            Variable(V, "m/s", Interval.of(-1, 1)),
        ),
        "inputs": (Variable(F, "N"),),
        "mass": sp.diag(1, M),
        "outputs": (Output("y", X, "m"),),
        "parameters": (
            Parameter(M, Fraction(2), "kg"),
            Parameter(K, Fraction(3), "N/m"),
            Parameter(L, Fraction(3), "m"),
        ),
        "units": "checked",
    }
    return Plant(**(given | changes))  # type: ignore[arg-type]


def friction() -> object:
    curve = interpolate_curve([-2, -1, 0, 1, 2], [-2, -1.5, 0, 1.5, 2])
    return table_function("friction", curve, unit="N", argument_units=("m/s",))


@pytest.mark.parametrize(
    "force",
    [
        F - K * X,
        F - K * X * sp.sin(X / L),
        F - K * L * (X / L) ** 3,
        F - K * sp.sqrt(X**2 + L**2),
        sp.Integer(0),
        3 * F - 2 * X - V / 4,  # a row of a matrix, whose numbers have the units that fit
        F - friction()(V),  # type: ignore[operator]
        F - friction()(V).diff(V) * V,  # type: ignore[operator]
        F * sp.exp(-X / L) + sp.Abs(F),
    ],
)
def test_equations_that_fit_are_accepted(force: sp.Expr) -> None:
    assert spring(equations=(V, force)).units == "checked"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"equations": (V, F - X)}, r"equation of v: .*F has the unit kg m/s\^2.*x has m"),
        ({"equations": (X, F)}, "equation of x: x has the unit m, but"),
        (
            {"equations": (V, F * sp.sin(X))},
            "equation of v: the argument of sin, x, has the unit m",
        ),
        ({"equations": (V, F + 1)}, "equation of v: "),
        ({"equations": (V, 2 * F + 3 * sp.sin(X / L))}, "equation of v: .* are added"),
        ({"equations": (V, F * 2**X)}, "the exponent of 2, x, has the unit m"),
        ({"equations": (V, K * X**sp.pi)}, "must be a rational number"),
        ({"equations": (V, F - friction()(X))}, "argument 1 of the table friction, x, has"),  # type: ignore[operator]
        ({"equations": (V, F * sp.gamma(X / L))}, "gamma .* has no unit rule"),
        ({"mass": sp.diag(1, 1)}, "equation of v: .* the left side has"),
        ({"mass": sp.Matrix([[1, 0], [M, M]])}, "mass row of v: .* are added"),
        ({"mass": None}, "equation of v: .* v' has m/s\\^2"),
        ({"outputs": (Output("y", X, "rad"),)}, "output y: x has the unit m, but 'rad'"),
        ({"premises": {sp.Symbol("z1", real=True): X + V}}, "premise z1: "),
        ({"inputs": (Variable(F, "kN"),)}, "variable F: the unit 'kN' is not SI"),
        ({"sample_time": 0.1}, "equation of x: .* the left side has m"),
        ({"units": "maybe"}, "'maybe' was given"),
    ],
)
def test_equations_that_do_not_fit_name_the_place_and_both_units(
    change: dict[str, object], words: str
) -> None:
    with pytest.raises(ModelError, match=words):
        spring(**change)


def test_unchecked_units_are_not_looked_at() -> None:
    assert spring(equations=(X, F - X), units="unchecked").units == "unchecked"


TEXT = """
format = 1
kind = "plant"
[states]
a = {{ unit = "deg", range = [-60, 60] }}
[inputs]
u = {{ unit = "{unit}", range = [-1, 1] }}
[parameters]
k = {{ value = 1, unit = "{per}" }}
[equations]
a = "{right}"
"""


def plant(folder: Path, unit: str = "rad/s", per: str = "-", right: str = "k*u") -> Plant:
    return filed_plant(folder, TEXT.format(unit=unit, per=per, right=right))


def test_a_file_s_unit_is_kept_for_words_and_no_part_of_equality(tmp_path: Path) -> None:
    degrees = plant(tmp_path)
    size, unit = file_unit(degrees.states[0])
    assert unit == "deg" and np.isclose(size, np.pi / 180)
    path = tmp_path / "plant.toml"
    text = path.read_text(encoding="utf-8").replace('unit = "-"', 'unit = "%"')
    path.write_text(text.replace("value = 1,", "value = 100,"), encoding="utf-8")
    assert load_plant(path) == degrees


@pytest.mark.parametrize(
    ("unit", "per", "seconds", "shown"),
    [
        ("rad/s", "-", 0.02, (0.02, "s")),
        ("rad/ms", "-", 0.02, (20.0, "ms")),
        ("rad/ms", "-", 2.0, (2.0, "s")),
        ("rad/s", "1/min", 90.0, (1.5, "min")),
        ("rad/min", "1/h", 90.0, (1.5, "min")),
        ("rad/min", "1/h", 7200.0, (2.0, "h")),
        ("rad/s", "1/h", 90.0, (90.0, "s")),
        ("rpm", "-", 90.0, (90.0, "s")),
    ],
)
def test_times_are_in_the_largest_unit_of_the_file_that_fits(
    tmp_path: Path, unit: str, per: str, seconds: float, shown: tuple[float, str]
) -> None:
    found = plant(tmp_path, unit, per, "u" if per == "-" else "u + 0*k*a")
    number, name = time_in_file_units(found, seconds)
    assert np.isclose(number, shown[0]) and name == shown[1]
    rate, unit = rate_in_file_units(found, 1 / seconds)
    assert np.isclose(rate, 1 / shown[0]) and unit == f"1/{shown[1]}"


def test_no_decay_is_no_time(tmp_path: Path) -> None:
    assert rate_in_file_units(plant(tmp_path), 0.0) == (0.0, "1/s")
