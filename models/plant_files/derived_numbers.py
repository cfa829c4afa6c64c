"""Parameters and rests of a plant file that are expressions, and parameters with a range.

An uncertain parameter p in [low, high] becomes a scheduling signal: the model covers every value in
the range.  A proved claim holds for each constant p, and also if p varies in its range in any way.
No gain may depend on p.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

import sympy as sp

from takagi.models.equations.equilibrium import decimal_near
from takagi.models.errors import ModelError
from takagi.models.expressions.parser import Scope, tokens_of
from takagi.models.files.units import PURE, Dimension, Unit, behind, parse_unit
from takagi.models.intervals.interval import Interval
from takagi.models.plant.dimensions import dimension_of
from takagi.models.plant.plant import Parameter, Variable
from takagi.models.ranges.expression_range import expression_range

if TYPE_CHECKING:
    from takagi.models.files.library import Document
    from takagi.models.plant.entries import ParameterEntry, PlantEntry
    from takagi.models.plant.plant import Plant


@dataclass(eq=False)
class DerivedNumbers:
    """The parameters of a file.  Each is read once, after those on which it depends.

    Attributes
    ----------
    read : place in the file, text and scope -> expression.
    uncertain : name -> signal, for the parameters of which only a range is known.
    moving : symbol -> expression, for the parameters that depend on uncertain ones.  They have no
        value of their own, so the expressions are substituted into the equations.
    """

    document: Document
    entry: PlantEntry
    read: Callable[[str, str, Scope], sp.Expr]
    computed: dict[str, Parameter] = field(default_factory=dict)
    closed: dict[str, sp.Expr] = field(default_factory=dict)
    uncertain: dict[str, Variable] = field(default_factory=dict)
    moving: dict[sp.Symbol, sp.Expr] = field(default_factory=dict)

    def parameters(self) -> tuple[Parameter, ...]:
        """Return the parameters with values, in the order of the file.

        Raises
        ------
        ModelError : with file, line and field: a circle, an expression that is no finite real
            number, another unit than its own.
        """
        for name in self.entry.parameters:
            self._parameter(name, ())
        moving = {symbol.name for symbol in self.moving} | self.uncertain.keys()
        return tuple(self.computed[name] for name in self.entry.parameters if name not in moving)

    def rest(
        self, field_path: str, text: str, unit: Unit
    ) -> tuple[Fraction, Fraction, sp.Expr | None]:
        """Return a rest that is an expression: nearest decimal, radius, exact expression."""
        expression = self._expression(field_path, text, ())
        names = self._uncertain_in(expression)
        if names:
            raise self.document.error(
                field_path,
                f"{text} moves with {', '.join(names)}, which is known within a range only, so the "
                "plant has no rest of its own there; give a number at which every equation "
                "vanishes for all values, or follow it by [reference] with an integral",
            )
        self._check_unit(field_path, expression, unit.dimension)
        return self._number(field_path, expression)

    def _uncertain_in(self, expression: sp.Expr) -> list[str]:
        renamed = expression.xreplace(self.moving)
        return sorted(s.name for s in renamed.free_symbols if s.name in self.uncertain)

    def _parameter(self, name: str, above: tuple[str, ...]) -> None:
        field_path, stated = f"parameters.{name}", self.entry.parameters[name]
        if name in above:
            circle = " -> ".join((*above[above.index(name) :], name))
            raise self.document.error(
                field_path, f"{name} depends on itself: {circle}; give one of these a number"
            )
        if name in self.computed:
            return
        symbol = sp.Symbol(name, real=True)
        if stated.range is not None:
            variable = uncertain_parameter(self.document, symbol, stated)
            self.uncertain[name] = variable
            self.computed[name] = Parameter(symbol, variable.rest, variable.unit, stated.source)
            return
        if stated.value is None:
            raise self.document.error(f"{field_path}.value", "is missing; add it")
        if not isinstance(stated.value, str):
            unit = self.document.unit(f"{field_path}.unit", stated.unit or "-")
            value = unit.to_si(Fraction(stated.value))
            self.computed[name] = Parameter(
                symbol, value, unit.si, stated.source, written=stated.unit or "-"
            )
            self.closed[name] = sp.Rational(value.numerator, value.denominator)
            return
        expression = self._expression(field_path, stated.value, (*above, name))
        unit = self._own_unit(field_path, stated, expression)
        if self._uncertain_in(expression):
            self.moving[symbol] = expression.xreplace(self.moving)
            # Other expressions use its unit; nothing reads this value.
            self.computed[name] = Parameter(symbol, Fraction(0), unit.si, stated.source)
            return
        value, within, equals = self._number(field_path, expression)
        self.computed[name] = Parameter(symbol, value, unit.si, stated.source, within, equals)
        self.closed[name] = self._closed(expression)

    def _expression(self, field_path: str, text: str, above: tuple[str, ...]) -> sp.Expr:
        """Return the expression; the parameters in it are read first."""
        with self.document.at(field_path):
            token_names = {token.text for token in tokens_of(text) if token.kind == "name"}
        for name in sorted(token_names & self.entry.parameters.keys()):
            self._parameter(name, above)
        parameters = {name: self.computed[name] for name in self.computed if name in token_names}
        ranged = {*self.uncertain, *(symbol.name for symbol in self.moving)}
        constants = {
            p.symbol: p.value for n, p in parameters.items() if p.within == 0 and n not in ranged
        }
        return self.read(
            field_path, text, Scope({n: p.symbol for n, p in parameters.items()}, constants)
        )

    def _closed(self, expression: sp.Expr) -> sp.Expr:
        return expression.subs({self.computed[n].symbol: c for n, c in self.closed.items()})

    def _number(
        self, field_path: str, expression: sp.Expr
    ) -> tuple[Fraction, Fraction, sp.Expr | None]:
        """Return value, radius and exact expression; the last two only if it is not a fraction."""
        value = self._closed(expression)
        exact = value if value.is_Rational else sp.nsimplify(value) if value.is_rational else value
        if exact.is_Rational:
            return Fraction(int(exact.p), int(exact.q)), Fraction(0), None
        if exact.has(sp.zoo, sp.nan, sp.oo, -sp.oo) or sp.N(exact, 20).is_real is not True:
            raise self.document.error(
                field_path,
                "has no finite real value: it divides by 0, or takes a root or logarithm of a "
                "negative number; correct it, or a parameter that it depends on",
            )
        with self.document.at(field_path):
            return (*decimal_near(exact), exact)

    def _own_unit(self, field_path: str, stated: ParameterEntry, expression: sp.Expr) -> Unit:
        """Return the stated unit if it fits; without one, the unit that the parameters give."""
        if stated.unit is None:
            dimension = self._dimension(field_path, expression)
            return parse_unit(str(PURE if dimension is None else dimension))
        unit = self.document.unit(f"{field_path}.unit", stated.unit)
        if not unit.is_si:
            raise self.document.error(
                f"{field_path}.unit",
                f"{stated.unit!r} was given, but an expression has its SI value; write {unit.si!r}",
            )
        self._check_unit(field_path, expression, unit.dimension)
        return unit

    def _check_unit(self, field_path: str, expression: sp.Expr, stated: Dimension) -> None:
        dimension = self._dimension(field_path, expression)
        if self.entry.units == "checked" and dimension not in (None, stated):
            raise self.document.error(
                field_path,
                f"the expression has the unit {dimension}, but {stated} is stated; correct one",
            )

    def _dimension(self, field_path: str, expression: sp.Expr) -> Dimension | None:
        if self.entry.units != "checked":
            return None
        units: Mapping[sp.Symbol, Dimension] = {
            p.symbol: parse_unit(p.unit).dimension for p in self.computed.values()
        }
        values = {p.symbol: p.value for p in self.computed.values()}
        try:
            return dimension_of(expression, units, values, owner=field_path)
        except ModelError as error:
            raise self.document.error(
                field_path, str(error).removeprefix(f"{field_path}: ")
            ) from error


def uncertain_parameter(document: Document, symbol: sp.Symbol, stated: ParameterEntry) -> Variable:
    """Return the signal of a parameter with a range; it rests at its value, or in the middle.

    Raises
    ------
    ModelError : with file, line and field: ends in the wrong order or equal, a value that is an
        expression or outside the range.
    """
    assert stated.range is not None  # called for such parameters only
    field_path, (low, high) = f"parameters.{symbol.name}", stated.range
    text = stated.unit or "-"
    unit_text = behind(text)
    if low > high:
        raise document.error(
            f"{field_path}.range", f"[{low}, {high}] was given; give the smaller end first"
        )
    if low == high:
        raise document.error(
            f"{field_path}.range",
            f"[{low}, {high}] has no width; write value = {low} for a parameter that is known",
        )
    if stated.value is None:
        value = (Fraction(low) + Fraction(high)) / 2
    elif isinstance(stated.value, Decimal):
        value = Fraction(stated.value)
    else:
        raise document.error(
            f"{field_path}.value",
            f"{stated.value!r} is an expression; an uncertain parameter has a range of its own, so "
            "give a number, or leave the range out: a derived parameter is as uncertain as those "
            "that it depends on",
        )
    if not low <= value <= high:
        raise document.error(
            f"{field_path}.value",
            f"{stated.value}{unit_text} is outside the range [{low}, {high}]{unit_text}; give a "
            "value inside it, or leave the value out",
        )
    unit = document.unit(f"{field_path}.unit", text)
    return Variable(
        symbol,
        unit.si,
        Interval(unit.to_si(Fraction(low)), unit.to_si(Fraction(high))),
        unit.to_si(value),
        f"uncertain parameter{f': {stated.source}' if stated.source else ''}",
        schedules=True,
        unknown=True,
        written=text,
    )


def check_divisors(document: Document, plant: Plant) -> None:
    """Refuse ranges of uncertain parameters in which an equation divides by 0.

    Only divisors without states are tested here.  Divisors with states are tested when the bounds
    of the model are proved.

    Raises
    ------
    ModelError : with file, line and field of the first parameter in such a divisor.
    """
    box = {v.symbol: v.range for v in plant.uncertain if v.range is not None}
    for variable, row in zip(plant.states, plant.equations, strict=True):
        for power in sorted(row.subs(plant.rationals).atoms(sp.Pow), key=str):
            symbols = power.base.free_symbols
            if not power.exp.is_negative or not symbols or not symbols <= box.keys():
                continue
            divisor_range = expression_range(power.base, {s: box[s] for s in symbols}).outer
            if not divisor_range.contains(0):
                continue
            name = min(str(s) for s in symbols)
            ranges = ", ".join(f"{s} in {box[s]}" for s in sorted(symbols, key=str))
            raise document.error(
                f"parameters.{name}.range",
                f"the equation of {variable.name} divides by {power.base}, which may be 0 for "
                f"{ranges}; give a range in which it is not, or correct the equation",
            )
