"""Units of premises, as far as the expressions determine them."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.files.units import PURE, Dimension, parse_unit
from takagi.models.plant.dimensions import NUMBERS, dimension_of
from takagi.models.plant.plant import Plant

if TYPE_CHECKING:
    import sympy as sp

UNKNOWN = "SI"  # coherent SI units; which, is hidden in the numbers


def units_of(plant: Plant, premises: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, str]:
    """Return the unit of each premise that is written with the plant's own parameters."""
    unit_texts = {p.symbol: p.unit for p in plant.parameters}
    unit_texts |= {v.symbol: v.unit for v in plant.variables}
    premise_units = {}
    for symbol, expression in premises.items():
        try:
            units = {s: parse_unit(unit).dimension for s, unit in unit_texts.items()}
            name = f"premise {symbol}"
            premise_units[symbol] = _text(
                expression, unit_texts, dimension_of(expression, units, plant.values, owner=name)
            )
        except (ModelError, KeyError):
            premise_units[symbol] = UNKNOWN
    return premise_units


def unit_of(expression: sp.Expr, units: Mapping[sp.Symbol, str]) -> str:
    """Return the unit of an expression whose parameters are numbers; "SI" where they hide it.

    sin(x)/x is a pure number and x y has the unit of both; a term with a number other than 1 and
    -1 may have any unit, for the number may be a parameter's value.

    Parameters
    ----------
    units : of the variables.
    """
    try:
        dimensions = {s: parse_unit(unit).dimension for s, unit in units.items()}
    except ModelError:
        return UNKNOWN
    return _text(expression, units, _dimension(expression, dimensions))


def _text(expression: sp.Expr, units: Mapping[sp.Symbol, str], dimension: Dimension | None) -> str:
    # A variable by itself keeps its own words: rad is a pure number too.
    if expression in units:
        return units[expression]
    integral = dimension is not None and all(e.denominator == 1 for e in dimension.exponents)
    return str(dimension) if integral else UNKNOWN  # half powers are not written in units


def _dimension(expression: sp.Expr, units: Mapping[sp.Symbol, Dimension]) -> Dimension | None:
    """Return the dimension; None where it cannot be told."""
    if expression.is_Symbol:
        return units.get(expression)
    if expression in (1, -1):
        return PURE
    if expression.is_Add:
        dimensions = {d for a in expression.args if (d := _dimension(a, units)) is not None}
        return dimensions.pop() if len(dimensions) == 1 else None
    if expression.is_Mul:
        total: Dimension | None = PURE
        for argument in expression.args:
            factor = _dimension(argument, units)
            total = None if total is None or factor is None else total.times(factor)
        return total
    if expression.is_Pow:
        base, exponent = _dimension(expression.base, units), expression.exp
        if base == PURE:
            return PURE
        rational_power = base is not None and exponent.is_Rational
        return (
            base.power(Fraction(int(exponent.p), int(exponent.q)))
            if rational_power and base
            else None
        )
    if hasattr(expression, "value_unit"):
        return _of_table(expression)
    if type(expression).__name__ in ("Abs", "Max", "Min"):
        dimensions = {d for a in expression.args if (d := _dimension(a, units)) is not None}
        return dimensions.pop() if len(dimensions) == 1 else None
    return PURE if type(expression).__name__ in NUMBERS else None


def _of_table(call: sp.Expr) -> Dimension:
    dimension = parse_unit(call.value_unit).dimension
    for unit, order in zip(call.argument_units, call.orders, strict=True):
        dimension = dimension.times(parse_unit(unit).dimension.power(Fraction(-order)))
    return dimension
