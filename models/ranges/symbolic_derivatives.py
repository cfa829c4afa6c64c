"""Derivatives and orders of poles of sympy expressions, as the ball forms need them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.ranges.large_powers import with_exponentials_as_symbols

if TYPE_CHECKING:
    import sympy as sp


def derivative(expression: sp.Expr, symbol: sp.Symbol, order: int = 1) -> sp.Expr | None:
    """Return the derivative; None where a table has no further one."""
    try:
        return expression.diff(symbol, order)
    except ModelError:
        return None


def is_zero(expression: sp.Expr) -> bool:
    import sympy as sp

    if expression == 0 or sp.expand(expression) == 0:
        return True
    return bool(with_exponentials_as_symbols(sp.simplify, expression) == 0)


def slope_or_none(expression: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
    """Return the derivative, or an expression that no tape knows."""
    import sympy as sp

    found = derivative(expression, symbol)
    return sp.Function("no_slope")(symbol) if found is None else found


def order_of(exponent: object) -> int:
    import sympy as sp

    return int(exponent) if isinstance(exponent, (int, sp.Integer)) and exponent > 0 else 0
