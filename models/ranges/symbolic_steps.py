"""Derivatives and orders of poles; polynomial steps of sympy on several Arrhenius laws.

Sympy reads exp(-97583/(10 T)) as the 97583rd power of exp(-1/(10 T)).  With two such powers its
greatest common divisor evaluates polynomials at integers that no memory holds, and the process
ends.  Here each exponential is a symbol of its own for the length of such a step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

LARGEST = 64  # the largest power that the grammar of plant files lets stand


def with_exponentials_as_symbols(
    step: Callable[[sp.Expr], sp.Expr], expression: sp.Expr
) -> sp.Expr:
    """Return ``step(expression)``, with symbols in the place of exponentials of large numbers.

    ``step`` rewrites an expression without changing its value, such as ``sympy.cancel``; what it
    returns has the exponentials again.  It is given the expression itself unless at least two
    different exponentials have a rational factor above ``LARGEST``.
    """
    import sympy as sp

    large = [e for e in expression.atoms(sp.exp) if _size(e.args[0]) > LARGEST]
    if len(large) < 2:
        return step(expression)
    back = {sp.Dummy(f"e{k}", positive=True): e for k, e in enumerate(sorted(large, key=str))}
    covered = expression.xreplace({e: symbol for symbol, e in back.items()})
    return step(covered).xreplace(back)


def _size(exponent: sp.Expr) -> int:
    """Return the largest numerator among the rational factors of the exponent's terms."""
    import sympy as sp

    terms = sp.Add.make_args(exponent)
    return max(abs(int(term.as_coeff_Mul(rational=True)[0].p)) for term in terms)


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
