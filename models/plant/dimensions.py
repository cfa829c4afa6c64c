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
UNIT_KEEPING = ("Abs", "Max", "Min")  # the value has the unit of the arguments
NUMBERS = (
    "sin cos tan exp log asin acos atan sinh cosh tanh asinh acosh atanh sinc erf sign".split()
)


def dimension_of(
    expression: sp.Expr,
    units: Mapping[sp.Symbol, Dimension],
    values: Mapping[sp.Symbol, Fraction],
    *,
    owner: str,
) -> Dimension | None:
    """Return the dimension of an expression; None for 0, which fits every unit.

    Parameters
    ----------
    units : of every symbol in the expression.
    values : of the parameters, for exponents.
    owner : what to call the expression in messages.

    Raises
    ------
    ModelError : the parts do not fit.
    """
    return _Reader(units, values, owner).of(expression)


class _Reader:
    """Dimensions of the parts of one expression."""

    def __init__(
        self, units: Mapping[sp.Symbol, Dimension], values: Mapping[sp.Symbol, Fraction], owner: str
    ) -> None:
        self.units = units
        self.values = values
        self.place = owner

    def of(self, expression: sp.Expr) -> Dimension | None:
        if expression.is_Symbol:
            return self.units[expression]
        if expression.is_Number or expression.is_NumberSymbol:
            return None if expression == 0 else PURE
        if expression.is_Add:
            return self.same(expression.args, "added")
        if expression.is_Mul:
            dimension: Dimension = PURE
            for argument in expression.args:
                dimension = dimension.times(self.of(argument) or PURE)
            return dimension
        if expression.is_Pow:
            return self.power(expression)
        return self.function(expression)

    def same(self, operands: tuple[sp.Expr, ...], how: str) -> Dimension | None:
        first: tuple[sp.Expr, Dimension] | None = None
        for operand in operands:
            dimension = self.of(operand)
            if dimension is None:
                continue
            if first is not None and dimension != first[1]:
                raise ModelError(
                    f"{self.place}: {short(first[0])} has the unit {first[1]} and {short(operand)} "
                    f"has {dimension}, but they are {how}; {ADVICE}"
                )
            first = first or (operand, dimension)
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
        if name in UNIT_KEEPING:
            return self.same(expression.args, "compared")
        if name not in NUMBERS:
            raise ModelError(
                f"{self.place}: {name} in {short(expression)} has no unit rule; {ADVICE}"
            )
        for argument in expression.args:
            self.pure(argument, f"the argument of {name}")
        return PURE

    def pure(self, expression: sp.Expr, role: str) -> None:
        dimension = self.of(expression)
        if dimension not in (None, PURE):
            raise ModelError(
                f"{self.place}: {role}, {short(expression)}, has the unit {dimension}; it must be "
                f"a pure number or in rad; {ADVICE}"
            )

    def table(self, expression: Any) -> Dimension:
        """Return the unit of a TableFunction, its derivatives included."""
        dimension = parse_unit(expression.value_unit).dimension
        triples = zip(expression.args, expression.argument_units, expression.orders, strict=True)
        for number, (argument, unit, order) in enumerate(triples, start=1):
            needed = parse_unit(unit).dimension
            argument_dimension = self.of(argument)
            if argument_dimension is not None and argument_dimension != needed:
                raise ModelError(
                    f"{self.place}: argument {number} of the table {expression.title}, "
                    f"{short(argument)}, has the unit {argument_dimension}; {unit!r} ({needed}) is "
                    f"needed; {ADVICE}"
                )
            dimension = dimension.times(needed.power(Fraction(-order)))
        return dimension


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
