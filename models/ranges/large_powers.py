"""Sympy's polynomial steps on expressions with several Arrhenius laws.

Sympy reads exp(-97583/(10 T)) as the 97583rd power of exp(-1/(10 T)).  With two such powers its
greatest common divisor evaluates polynomials at integers that no memory holds, and the process
ends.  Here each exponential is a symbol of its own for the length of such a step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

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
