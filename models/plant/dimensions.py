"""The dimension of an expression; every sum and argument in it must fit by its units."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.files.units import PURE, Dimension, parse_unit

if TYPE_CHECKING:
    import sympy as sp

ADVICE = 'correct the expression or a unit, or turn checking off with units = "unchecked"'
KEPT = ("Abs", "Max", "Min")  # the value has the unit of the arguments
NUMBERS = (
    "sin cos tan exp log asin acos atan sinh cosh tanh asinh acosh atanh sinc erf sign".split()
)


def dimension_of(
    expression: sp.Expr,
    units: Mapping[sp.Symbol, Dimension],
    values: Mapping[sp.Symbol, Fraction],
    *,
    place: str,
) -> Dimension | None:
    """Return the dimension of an expression; None for 0, which fits every unit.

    Parameters
    ----------
    units : of every symbol in the expression.
    values : of the parameters, for exponents.
    place : what to call the expression in messages.

    Raises
    ------
    ModelError : the parts do not fit.
    """
    return _Reader(units, values, place).of(expression)


class _Reader:
    """Dimensions of the parts of one expression."""

    def __init__(
        self, units: Mapping[sp.Symbol, Dimension], values: Mapping[sp.Symbol, Fraction], place: str
    ) -> None:
        self.units = units
        self.values = values
        self.place = place

    def of(self, expression: sp.Expr) -> Dimension | None:
        if expression.is_Symbol:
            return self.units[expression]
        if expression.is_Number or expression.is_NumberSymbol:
            return None if expression == 0 else PURE
        if expression.is_Add:
            return self.same(expression.args, "added")
        if expression.is_Mul:
            found: Dimension = PURE
            for argument in expression.args:
                found = found.times(self.of(argument) or PURE)
            return found
        if expression.is_Pow:
            return self.power(expression)
        return self.function(expression)

    def same(self, parts: tuple[sp.Expr, ...], how: str) -> Dimension | None:
        first: tuple[sp.Expr, Dimension] | None = None
        for part in parts:
            found = self.of(part)
            if found is None:
                continue
            if first is not None and found != first[1]:
                raise ModelError(
                    f"{self.place}: {short(first[0])} has the unit {first[1]} and {short(part)} "
                    f"has {found}, but they are {how}; {ADVICE}"
                )
            first = first or (part, found)
        return None if first is None else first[1]

    def power(self, expression: sp.Expr) -> Dimension:
        base = self.of(expression.base) or PURE
        exponent = expression.exp.subs(self.values)
        self.pure(expression.exp, f"the exponent of {short(expression.base)}")
        if base == PURE:
            return PURE
        if not exponent.is_Rational:
            raise ModelError(
                f"{self.place}: {short(expression.base)} has the unit {base}, so its exponent "
                f"must be a rational number, not {short(exponent)}; {ADVICE}"
            )
        return base.power(Fraction(int(exponent.p), int(exponent.q)))

    def function(self, expression: sp.Expr) -> Dimension | None:
        name = type(expression).__name__
        if hasattr(expression, "argument_units"):
            return self.table(expression)
        if name in KEPT:
            return self.same(expression.args, "compared")
        if name not in NUMBERS:
            raise ModelError(
                f"{self.place}: {name} in {short(expression)} has no unit rule; {ADVICE}"
            )
        for argument in expression.args:
            self.pure(argument, f"the argument of {name}")
        return PURE

    def pure(self, expression: sp.Expr, what: str) -> None:
        found = self.of(expression)
        if found not in (None, PURE):
            raise ModelError(
                f"{self.place}: {what}, {short(expression)}, has the unit {found}; it must be a "
                f"pure number or in rad; {ADVICE}"
            )

    def table(self, expression: Any) -> Dimension:
        """Return the unit of a TableFunction, its derivatives included."""
        found = parse_unit(expression.value_unit).dimension
        triples = zip(expression.args, expression.argument_units, expression.orders, strict=True)
        for number, (argument, unit, order) in enumerate(triples, start=1):
            wanted = parse_unit(unit).dimension
            given = self.of(argument)
            if given is not None and given != wanted:
                raise ModelError(
                    f"{self.place}: argument {number} of the table {expression.title}, "
                    f"{short(argument)}, has the unit {given}; {unit!r} ({wanted}) is needed; "
                    f"{ADVICE}"
                )
            found = found.times(wanted.power(Fraction(-order)))
        return found


def without_matrix_row(expression: sp.Expr, variables: Collection[sp.Symbol]) -> sp.Expr:
    """Return the expression without the numbers times variables of a row of a matrix.

    Where every term is a number times a variable, as in -2 x + 0.5 v, the numbers are entries of A
    or B in SI, with the unit that fits; a term with 1 or -1 stays.
    """
    import sympy as sp

    pairs = [term.as_coeff_Mul() for term in sp.Add.make_args(expression)]
    if not all(core in variables for _, core in pairs):
        return expression
    return sp.Add(*(share * core for share, core in pairs if abs(share) == 1))


def short(expression: sp.Expr) -> str:
    """Return an expression as it is printed in messages, cut at 80 characters."""
    text = str(expression).replace("**", "^")
    return text if len(text) <= 80 else f"{text[:77]}..."
