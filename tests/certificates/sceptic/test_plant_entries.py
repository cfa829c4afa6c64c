"""Entries of a plant's matrices: quotients, roots and sums that cancel, and what must not."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker.arithmetic.interval import point
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.plant.atoms import Atoms
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.polynomial import Quotient
from takagi.certificates.checker.plant.table import Table, read_table
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import Surface, interpolate_curve, sector_model
from takagi.models.plant_files.loader import load_plant
from takagi.models.splines.spline import interpolate
from tests.certificates.embedding.plants import (
    changed,
    said_of,
)
from tests.certificates.kinds.claims import Data, as_read
from tests.symbolic_plants import plant_of

TRUE = [
    ("sqrt(2)*sqrt(9.81*h)", "sqrt(19.62*h)"),
    ("sqrt(218)", "sqrt(2)*sqrt(109)"),
    ("sqrt(9.81)", "3*sqrt(109)/10"),
    ("sqrt(2*h + 1)", "sqrt(2)*sqrt(h + 1/2)"),
    ("(2*h)^(3/2)", "2*sqrt(2)*h*sqrt(h)"),
    ("(8*h)^(-1/2)", "sqrt(2)/4/sqrt(h)"),
    ("(16*h)^(1/3)", "2*2^(1/3)*h^(1/3)"),
    ("(h/(2*h + 2))^(1/2)", "sqrt(h/(h + 1))/sqrt(2)"),
    ("sqrt(3)*sqrt(5) + sqrt(2)^2", "sqrt(15) + 2"),
    ("sqrt(-h)*sqrt(2)", "sqrt(-2*h)"),
]
FALSE = [
    ("sqrt(2)*sqrt(h)", "sqrt(3*h)"),
    ("sqrt(2)*sqrt(3)", "sqrt(5)"),
    ("sqrt(2) + sqrt(3)", "sqrt(5)"),
    ("sqrt(4*h)", "4*sqrt(h)"),
    ("sqrt(-h)", "-sqrt(h)"),
    ("sqrt(h^2)", "h"),
    ("sqrt(4*h^2)", "2*h"),
    ("sqrt(4*(h - 1)^2)", "2*(1 - h)"),
    ("(8*h)^(1/3)", "sqrt(2)*h^(1/3)"),
    ("sqrt(2*h + 1)", "sqrt(2)*sqrt(h + 1)"),
]


def equal(left: str, right: str) -> bool:
    graph = Graph()
    scope = Scope({"h": graph.variable("h")})
    nodes = [read_expression(text, graph, scope, "here") for text in (left, right)]
    return Algebra(graph).equal(*nodes)


@pytest.mark.parametrize(("left", "right"), TRUE)
def test_roots_that_are_equal(left: str, right: str) -> None:
    assert equal(left, right)


@pytest.mark.parametrize(("left", "right"), FALSE)
def test_roots_that_are_not_shown_to_be_equal(left: str, right: str) -> None:
    assert not equal(left, right)


def value(found: Quotient, names: dict[int, tuple[str, int, int]]) -> float:
    """Return the value of a sum of products of roots of whole numbers."""
    assert not found.bottom
    terms = (
        float(c) * math.prod(names[a][2] ** (k / names[a][1]) for a, k in monomial)
        for monomial, c in found.top.items()
    )
    return math.fsum(terms)


@given(
    number=st.fractions(min_value=Fraction(1, 10**6), max_value=10**6, max_denominator=10**6),
    p=st.integers(-5, 5).filter(bool),
    q=st.integers(2, 5),
)
def test_a_power_of_a_number_has_its_value(number: Fraction, p: int, q: int) -> None:
    """In the ring, as products of roots of factors, and in floats."""
    atoms = Atoms()
    found = atoms.power(Quotient({(): number}), Fraction(p, q))
    names = {atom: key for key, atom in atoms.keys.items() if isinstance(key, tuple)}
    assert value(found, names) == pytest.approx(float(number) ** (p / q), rel=1e-11)


@pytest.mark.parametrize("number", ["1" + "0" * 300 + "7", "99999999999999999999999999999977/3"])
def test_a_large_number_is_left_whole(number: str) -> None:
    """It takes no time, and says no more than that equal roots are equal."""
    assert equal(f"sqrt({number})*sqrt(2*h)", f"sqrt(2)*sqrt({number}*h)") in (True, False)
    assert not equal(f"sqrt({number})", f"sqrt({number} + 1)")


def two_states(
    equation: str, premise: str, lower: object, upper: object, entries: list[str]
) -> Data:
    """Return x' = equation as a row of entries in z = premise, y' = -y, on |x|, |y| <= 1."""
    return {
        "kind": "plant",
        "sample_time": None,
        "states": [{"name": n, "unit": "-", "rest": 0, "range": [-1, 1]} for n in "xy"],
        "equations": [equation, "-y"],
        "embedding": {
            "premises": [{"name": "z", "expression": premise, "lower": lower, "upper": upper}],
            "A": [entries, ["0", "-1"]],
        },
    }


SINE = two_states("sin(y + 2*x)", "sin(y + 2*x)/(y + 2*x)", "0.0470", 1, ["2*z", "z"])
PROVED = {
    "sine": SINE,
    "written otherwise": two_states(
        "sin(y + 2*x)", "-3*sin(-2*x - y)/(6*x + 3*y)", "0.0470", 1, ["2*z", "z"]
    ),
    "with another variable": two_states(
        "y*sin(y + 2*x)", "y*sin(y + 2*x)/(2*x + y)", -1, 1, ["2*z", "z"]
    ),
    "cosine": two_states("1 - cos(y - x)", "(1 - cos(y - x))/(y - x)", -1, 1, ["-z", "z"]),
    "of order two": two_states(
        "(1 - cos(y - x))/(y - x)", "(1 - cos(y - x))/(x - y)^2", "0.35", "0.5", ["-z", "z"]
    ),
    "exponential": two_states(
        "exp(x + y) - 1", "(exp(y + x) - 1)/(x + y)", "0.432", "3.195", ["z", "z"]
    ),
}
PROVED["about another point"] = two_states(
    "sin(x + y + 1) - sin(1)", "(sin(x + y + 1) - sin(1))/(x + y)", "-0.351", "0.9", ["z", "z"]
)
PROVED["at a corner of the box alone"] = changed(
    SINE, lambda d: [state.update(range=[0, 1]) for state in d["states"]]
)


@given(
    a=st.integers(-3, 3).filter(bool),
    b=st.integers(-3, 3).filter(bool),
    share=st.floats(0.9, 1.1).filter(lambda s: abs(s - 1) > 1e-6),
)
def test_the_bound_is_the_threshold(a: int, b: int, share: float) -> None:
    """sin(s)/s falls from 1 to sin(r)/r, r = |a| + |b|, for r below its first minimum at 4.49."""
    r = abs(a) + abs(b)
    if r > 4:
        return
    true = math.sin(r) / r
    lower = true + (1 - share) * 0.1
    s = f"{a}*x + {b}*y"
    data = two_states(f"sin({s})", f"sin({s})/({s})", repr(lower), 1, [f"{a}*z", f"{b}*z"])
    assert (said_of(data).verdict is Verdict.PROVED) == (lower <= true)


def test_the_truck_and_trailer_in_states_of_its_own() -> None:
    """x3+ = x3 + v T sin(x2 + v T/(2 L) x1) with the premise sin(s)/s: two rules.

    Tanaka and Sano (1994), as recalled in the built-in plant's file.
    """
    x1, x2, x3, u, z = sp.symbols("x1 x2 x3 u z", real=True)
    s = x2 - x1 * sp.Rational(2, 11)
    plant = plant_of(
        [
            x1 * sp.Rational(15, 11) - sp.Rational(5, 7) * u,
            x2 - 2 * x1 / sp.Integer(11) * 2,
            x3 - 2 * sp.sin(s),
        ],
        [x1, x2, x3],
        [u],
        box={x1: (-1, 1), x2: (-2, 2)},
        premises={z: sp.sin(s) / s},
    )
    data = plant_data(sector_model(plant))
    found = said_of(data)
    assert found.verdict is Verdict.PROVED, found.text
    assert "model of 2 rules exactly" in found.text
    wrong = changed(data, lambda d: d["embedding"]["premises"][0].update(upper="0.9999999"))
    assert said_of(wrong).verdict is Verdict.UNDECIDED


CURVE = interpolate_curve([-4, -2, 0, 1, 2.5, 4], [-0.5, -0.3, 0, 0.3, 0.2, 0.5])
FRICTION = {
    "tables": {
        "friction": {"knots": [CURVE.knots.tolist()], "coefficients": CURVE.coefficients.tolist()}
    }
}


def table_of(data: dict[str, Any], name: str) -> Table:
    return read_table(as_read(data["tables"]), name, "tables")


@given(x=st.fractions(min_value=-4, max_value=4, max_denominator=100), order=st.integers(0, 2))
def test_the_value_is_that_of_the_model_and_lies_in_the_enclosure(x: Fraction, order: int) -> None:
    """Two programs, one in Bernstein form and one by de Boor's recursion, agree exactly."""
    table = table_of(FRICTION, "friction")
    found = table.exact([x], (order,))
    assert found == CURVE.exact(x, order)
    low, high = table.bounds([point(x)], (order,))
    assert low <= found * 10**36 <= high


@given(
    x=st.fractions(min_value=0, max_value=3, max_denominator=50),
    y=st.fractions(min_value=-1, max_value=3, max_denominator=50),
    dx=st.integers(0, 2),
    dy=st.integers(0, 2),
)
def test_a_surface_too(x: Fraction, y: Fraction, dx: int, dy: int) -> None:
    surface: Surface = SURFACE
    data = {
        "tables": {
            "s": {
                "knots": [surface.x_knots.tolist(), surface.y_knots.tolist()],
                "coefficients": surface.coefficients.tolist(),
            }
        }
    }
    found = table_of(data, "s").exact([x, y], (dx, dy))
    assert found is not None
    assert float(found) == pytest.approx(float(surface(float(x), float(y), dx, dy)), abs=1e-9)


SURFACE = interpolate(
    np.array([0.0, 0.5, 1.0, 2.0, 3.0]),
    np.array([-1.0, 0.0, 1.0, 3.0]),
    np.cos(np.arange(20.0).reshape(5, 4)),
)


def test_outside_the_table_there_is_no_value() -> None:
    table = table_of(FRICTION, "friction")
    assert table.exact([Fraction(4)], (0,)) == Fraction("0.5")
    assert table.exact([Fraction(4) + Fraction(1, 10**30)], (0,)) is None


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("pendulum")
    page = (Path(__file__).parents[3] / "docs/plants.md").read_text(encoding="utf-8")
    for start, name in (("```csv\n", "friction.csv"), ("```toml\n", "pendulum.toml")):
        text = page.split(start)[1].split("```")[0]
        (folder / name).write_text(text, encoding="utf-8")
    file = folder / "pendulum.toml"
    data = plant_data(sector_model(load_plant(file), rest="solve inputs"))
    return file, data


def test_the_pendulum_of_the_page_on_plant_files_is_proved(
    pendulum: tuple[Path, dict[str, Any]],
) -> None:
    """Its friction is a table through 0, whose spline passes 0 by 1e-17."""
    _, data = pendulum
    assert said_of(data).verdict is Verdict.PROVED
    wrong = changed(data, coefficient(2, 0.01))
    assert said_of(wrong).verdict is Verdict.UNDECIDED


def coefficient(place: int, value: float) -> Callable[[dict[str, Any]], None]:
    def change(data: dict[str, Any]) -> None:
        data["tables"]["friction"]["coefficients"][place] = value

    return change


def another_knot(data: dict[str, Any]) -> None:
    data["tables"]["friction"]["knots"][0].insert(5, 1)
    data["tables"]["friction"]["coefficients"].append(0.5)


def moved_knot(data: dict[str, Any]) -> None:
    knots = np.array(data["tables"]["friction"]["knots"][0])
    knots[4] = 0.5
    x, values = [-4, -2, 0, 2, 4], [-0.5, -0.3, 0, 0.3, 0.5]
    spline = make_interp_spline(x, values, k=3, t=knots)
    data["tables"]["friction"].update(knots=[knots.tolist()], coefficients=spline.c.tolist())


def test_a_table_is_that_of_its_file(pendulum: tuple[Path, dict[str, Any]]) -> None:
    """A hash alone would let a certificate have friction of its own beside the real file."""
    file, data = pendulum
    assert "tables pass their files' values" in compare_plant(as_read(data), file)
    others = (coefficient(0, -0.501), coefficient(4, 5.0), another_knot, moved_knot)
    for change in others:
        with pytest.raises(CertificateError, match="friction"):
            compare_plant(as_read(changed(data, change)), file)


@pytest.mark.parametrize(
    "written",
    ["-4, -0.5\n-2, -0.3\n0, 0\n2, 0.3\n4, 0.6", "-4, -0.5\n-1, -0.3\n0.1, 0\n2, 0.3\n4, 0.5",
     "-4, -0.5\n-2, -0.3\n0, 0\n2, 0.3", "", "-4\n-2\n0\n2\n4", "a, b", "1, 1e999\n2, 1"],
)  # fmt: skip
def test_another_file_is_refused(
    written: str, pendulum: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    file, data = pendulum
    other = tmp_path / "pendulum.toml"
    other.write_text(file.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "friction.csv").write_text(written, encoding="utf-8")
    with pytest.raises(CertificateError, match="friction"):
        compare_plant(as_read(data), other)
