"""The grammar of plant files: what it reads, what it refuses, and that nothing takes long."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.expressions.parser import FUNCTIONS, Scope, parse_expression
from takagi.models.ranges.expression_range import expression_value

X, Y, K, THETA = (sp.Symbol(name, real=True) for name in ("x", "y", "k", "theta"))


def scope() -> Scope:
    return Scope({s.name: s for s in (X, Y, K, THETA)}, {K: Fraction(3)})


def parsed(text: str) -> sp.Expr:
    return parse_expression(text, scope())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-x^2", -(X**2)),
        ("(-x)^2", X**2),
        ("2^3^2", sp.Integer(512)),
        ("2^-3^2", sp.Rational(1, 512)),
        ("x - y - 1", X - Y - 1),
        ("x/y/2", X / (2 * Y)),
        ("x/y*2", 2 * X / Y),
        ("2*-x", -2 * X),
        ("x**2 + +y", X**2 + Y),
        ("x^k", X**K),
        ("x^(1/2)", sp.sqrt(X)),
        ("0.1*x + 1e-3", X / 10 + sp.Rational(1, 1000)),
        ("sin(x)*cos(pi*y) + abs(x)", sp.sin(X) * sp.cos(sp.pi * Y) + sp.Abs(X)),
        ("  x\n + y ", X + Y),
    ],
)
def test_text_means_what_mathematics_means_by_it(text: str, expected: sp.Expr) -> None:
    """Powers bind from the right and before signs; numbers are the decimals that are written."""
    assert parsed(text) == expected


def test_numbers_keep_digits_that_a_float_has_not() -> None:
    """Read as a float, both would be 1/10."""
    assert parsed("0.10000000000000000001") != sp.Rational(1, 10)
    assert parsed("0.1") == sp.Rational(1, 10)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_every_function_has_ball_arithmetic(name: str) -> None:
    """A name in the grammar that bounds cannot be proved for would promise too much."""
    point = 1.5 if name == "acosh" else 0.5

    found = expression_value(parsed(f"{name}(x)"), {X: point})

    assert found == pytest.approx(float(parsed(f"{name}(x)").subs(X, sp.Rational(point)).evalf()))


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        ("sin(thta)", 5, "did you mean 'theta'"),
        ("x y", 3, "operator is missing before 'y'"),
        ("2x", 2, "operator is missing before 'x'"),
        ("x +", 4, "ends where a number"),
        ("(x", 3, "should close"),
        ("x)", 2, "without its opening bracket"),
        ("sin x", 1, r"write sin\(\.\.\.\)"),
        ("sni(x)", 1, "did you mean 'sin'"),
        ("x(3)", 1, r"write x\*\(\.\.\.\)"),
        ("sin(x, y)", 1, "takes 1 argument"),
        ("x = 3", 3, "no '='"),
        ("x.real", 2, "cannot stand in an expression"),
        ("x @ y", 3, "cannot stand in an expression"),
        ("", 1, "empty"),
        ("1/0", 2, "division by zero"),
        ("1/(x - x)", 2, "division by zero"),
        ("0^0", 2, "is not a number"),
        ("sqrt(-1)", 1, "not a finite real number"),
        ("asin(2)", 1, "not a real number"),
        ("tan(pi/2)", 1, "not a finite real number"),
        ("x^y", 2, "exponent depends on y"),
        ("x^pi", 2, "a rational up to 64"),
        ("theta^1000", 6, "a rational up to 64"),
        ("__import__('os').system('true')", 12, "cannot stand"),
        ("lambda: 1", 7, "cannot stand"),
    ],
)
def test_what_is_refused_says_where_and_how_to_mend_it(text: str, column: int, words: str) -> None:
    with pytest.raises(ModelError, match=words) as caught:
        parsed(text)

    place, _, caret = str(caught.value).splitlines()
    assert place.startswith(f"column {column}:")
    assert caret == "    " + " " * (column - 1) + "^"


def test_an_error_in_a_later_line_names_the_line() -> None:
    with pytest.raises(ModelError, match="line 3, column 2: 'foo'"):
        parsed("x\n + \n foo")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("9^9^9^9", "exponent"),
        ("((2*x)^64)^64", "degree 4096"),
        ("((10^64)^64)^64", "bits"),
        ("1e999999999", "powers of ten"),
        ("1" * 41, "41 digits"),
        ("exp(exp(exp(100)))", "too large"),
        ("(" * 60 + "x" + ")" * 60, "50 levels"),
        ("-" * 60 + "x", "50 levels"),
        ("2^" * 60 + "x", "50 levels"),
        ("x+" * 3000 + "x", "4000 are allowed"),
    ],
)
def test_what_would_take_long_is_refused_before_it_is_worked_out(text: str, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        parsed(text)


def leaves() -> st.SearchStrategy[str]:
    numbers = st.decimals(min_value=0, max_value=100, places=3).map(str)
    return st.one_of(numbers, st.sampled_from(["x", "y", "theta"]))


def bracketed(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    pairs = st.tuples(inner, st.sampled_from(["+", "-", "*"]), inner)
    return st.one_of(
        pairs.map(lambda parts: f"({parts[0]} {parts[1]} {parts[2]})"),
        inner.map(lambda text: f"sin({text})"),
        inner.map(lambda text: f"(-{text})"),
    )


@given(st.recursive(leaves(), bracketed, max_leaves=12))
def test_bracketed_text_equals_what_python_makes_of_it(text: str) -> None:
    import re

    exact = re.sub(r"\d+\.\d+", lambda match: f"sp.Rational('{match.group()}')", text)
    exact = exact.replace("sin(", "sp.sin(")
    expected = eval(exact, {"sp": sp, "x": X, "y": Y, "theta": THETA})

    assert parsed(text) == expected


@given(st.text(alphabet="xyk0123456789.e+-*/^(), sincoexp\n", max_size=40))
def test_any_text_gives_an_expression_or_a_model_error(text: str) -> None:
    try:
        found = parsed(text)
    except ModelError:
        return

    assert found.free_symbols <= {X, Y, K, THETA}
