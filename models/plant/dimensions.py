"""Every sum, equation, output and argument must fit by its units."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.files.units import PURE, Dimension, parse_unit

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant

__all__ = ["check_units", "dimension_of"]

PER_SECOND = parse_unit("1/s").dimension
CURE = 'correct the expression or a unit, or turn checking off with units = "unchecked"'
KEPT = ("Abs", "Max", "Min")  # the value has the unit of the arguments
NUMBERS = (
    "sin cos tan exp log asin acos atan sinh cosh tanh asinh acosh atanh sinc erf sign".split()
)


def check_units(plant: Plant) -> None:
    """Raise ModelError unless every equation, mass entry, output and premise fits by its units.

    What is added must have one unit; arguments of sin, exp, ... are pure numbers or in rad; the
    derivative of a state has its unit per second (in discrete time: its unit); tables take and
    give what they say.  Numbers in an expression are pure; 0 fits everything.

    The check reads the expressions as sympy holds them: what cancels is not looked at.
    """
    units = _dimensions(plant)
    values = plant.values
    wanted = _rate_dimensions(plant, units, values)
    for variable, row, dimension in zip(plant.states, plant.equations, wanted, strict=True):
        place = f"equation of {variable.name}"
        found = dimension_of(row, units, values, place=place)
        if dimension is not None and found is not None and found != dimension:
            left = "the left side" if plant.mass is not None else _left(plant, variable.name)
            raise ModelError(
                f"{place}: {_short(row)} has the unit {found}, but {left} has {dimension}; {CURE}"
            )
    for output in plant.outputs:
        place = f"output {output.name}"
        found = dimension_of(output.expression, units, values, place=place)
        stated = _si(output.unit, place).dimension
        if found is not None and found != stated:
            raise ModelError(
                f"{place}: {_short(output.expression)} has the unit {found}, but {output.unit!r} "
                f"is stated ({stated}); {CURE}"
            )
    for symbol, expression in plant.premises.items():
        dimension_of(expression, units, values, place=f"premise {symbol}")


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
        self,
        units: Mapping[sp.Symbol, Dimension],
        values: Mapping[sp.Symbol, Fraction],
        place: str,
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
                    f"{self.place}: {_short(first[0])} has the unit {first[1]} and {_short(part)} "
                    f"has {found}, but they are {how}; {CURE}"
                )
            first = first or (part, found)
        return None if first is None else first[1]

    def power(self, expression: sp.Expr) -> Dimension:
        base = self.of(expression.base) or PURE
        exponent = expression.exp.subs(self.values)
        self.pure(expression.exp, f"the exponent of {_short(expression.base)}")
        if base == PURE:
            return PURE
        if not exponent.is_Rational:
            raise ModelError(
                f"{self.place}: {_short(expression.base)} has the unit {base}, so its exponent "
                f"must be a rational number, not {_short(exponent)}; {CURE}"
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
                f"{self.place}: {name} in {_short(expression)} has no unit rule; {CURE}"
            )
        for argument in expression.args:
            self.pure(argument, f"the argument of {name}")
        return PURE

    def pure(self, expression: sp.Expr, what: str) -> None:
        found = self.of(expression)
        if found not in (None, PURE):
            raise ModelError(
                f"{self.place}: {what}, {_short(expression)}, has the unit {found}; it must be a "
                f"pure number or in rad; {CURE}"
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
                    f"{_short(argument)}, has the unit {given}; {unit!r} ({wanted}) is needed; "
                    f"{CURE}"
                )
            found = found.times(wanted.power(Fraction(-order)))
        return found


def _dimensions(plant: Plant) -> dict[sp.Symbol, Dimension]:
    found = {v.symbol: _si(v.unit, f"variable {v.name}").dimension for v in plant.variables}
    for parameter in plant.parameters:
        place = f"parameter {parameter.symbol}"
        found[parameter.symbol] = _si(parameter.unit, place).dimension
    return found


def _rate_dimensions(
    plant: Plant, units: Mapping[sp.Symbol, Dimension], values: Mapping[sp.Symbol, Fraction]
) -> list[Dimension | None]:
    """Return the unit of each row of M x'; None for a row of zeros."""
    step = PER_SECOND if plant.sample_time is None else PURE
    rates = [units[variable.symbol].times(step) for variable in plant.states]
    if plant.mass is None:
        return list(rates)
    found: list[Dimension | None] = []
    for row, variable in enumerate(plant.states):
        place = f"mass row of {variable.name}"
        seen: tuple[str, Dimension] | None = None
        for column, rate in enumerate(rates):
            entry = dimension_of(plant.mass[row, column], units, values, place=place)
            if entry is None:
                continue
            term = f"({_short(plant.mass[row, column])}) {_left(plant, plant.states[column].name)}"
            total = entry.times(rate)
            if seen is not None and seen[1] != total:
                raise ModelError(
                    f"{place}: {seen[0]} has the unit {seen[1]} and {term} has {total}, but they "
                    f"are added; {CURE}"
                )
            seen = seen or (term, total)
        found.append(None if seen is None else seen[1])
    return found


def _left(plant: Plant, name: str) -> str:
    return f"{name}'" if plant.sample_time is None else f"{name}(t + T)"


def _si(text: str, place: str) -> Any:
    unit = parse_unit(text)
    if not unit.is_si:
        raise ModelError(
            f"{place}: the unit {text!r} is not SI; give the value in {unit.si!r} (plant files "
            "convert, a Plant in Python does not)"
        )
    return unit


def _short(expression: sp.Expr) -> str:
    text = str(expression).replace("**", "^")
    return text if len(text) <= 80 else f"{text[:77]}..."
