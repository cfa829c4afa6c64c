"""Arguments of tables stay inside their tables, also where a table is the argument of another."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from takagi.models import (
    Interval,
    ModelError,
    Plant,
    Variable,
    interpolate_curve,
    sector_model,
    table_function,
)
from takagi.models.plant_files.entry_checks import check_coverage
from takagi.models.splines.table_function import TableFunction

X, U = sp.symbols("x u", real=True)


def table(name: str, low: float, high: float) -> type[TableFunction]:
    """Return the sine on [low, high] as a table."""
    x = np.linspace(low, high, 9)
    return table_function(name, interpolate_curve(x, np.sin(x), name=name))


INNER = table("inner", 0, 2)  # values up to 1
WIDE, NARROW = table("wide", -1, 1.5), table("narrow", 0, 0.5)


def plant(expression: sp.Expr, low: str = "0", high: str = "2") -> Plant:
    """Return x' = expression - (expression at rest, x = 1/4) + u."""
    rest = Fraction(1, 4)
    return Plant(
        states=(Variable(X, "-", Interval.of(low, high), rest),),
        inputs=(Variable(U),),
        equations=(expression - expression.subs(X, sp.Rational(1, 4)) + U,),
        name="nested",
    )


def test_a_table_of_a_table_is_covered_and_bounded() -> None:
    """wide(inner(x)) - its value at 1/4, over x - 1/4: a removable singularity of two splines."""
    described = plant(WIDE(INNER(X)))
    check_coverage(described)
    (premise,) = sector_model(described).premises

    x = np.linspace(0, 2, 801)
    quotient = (_value(x) - _value(0.25)) / (x - 0.25 + (x == 0.25))
    quotient = quotient[x != 0.25]
    assert float(premise.lower) <= quotient.min() <= float(premise.lower) + 0.01
    assert quotient.max() <= float(premise.upper) <= quotient.max() + 0.01
    assert premise.bounds.contains(premise.replay())


def _value(x: np.ndarray | float) -> np.ndarray:
    return np.asarray(WIDE.table(INNER.table(x, 0), 0))


def test_three_tables_inside_one_another() -> None:
    described = plant(INNER(WIDE(INNER(X))), "0.1", "1.9")
    check_coverage(described)
    assert len(sector_model(described).rules) == 2


def test_values_of_the_inner_table_that_leave_the_outer_one_are_refused() -> None:
    """inner takes values up to 1, narrow covers [0, 1/2]: the argument is named with its range."""
    with pytest.raises(ModelError, match=r"argument 1 of narrow\(inner\(x\)\), inner\(x\), takes"):
        check_coverage(plant(NARROW(INNER(X))))
    check_coverage(plant(NARROW(INNER(X)), "0.01", "0.5"))


def test_the_inner_argument_is_refused_first() -> None:
    """Where inner itself is left, the message is about inner and not about the range of wide."""
    with pytest.raises(ModelError, match=r"argument 1 of inner\(2\*x\), 2\*x, takes values"):
        check_coverage(plant(WIDE(INNER(2 * X))))


def test_a_derived_model_refuses_what_nobody_checked() -> None:
    """A Plant in Python is not read from a file; its bounds refuse the same."""
    for expression, words in ((WIDE(INNER(2 * X)), "of inner"), (NARROW(INNER(X)), "of narrow")):
        with pytest.raises(ModelError, match=rf"an argument {words}.*the table covers"):
            sector_model(plant(expression))
