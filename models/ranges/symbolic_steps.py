"""Rewriting of expressions: derivatives, orders of poles, large powers, one variable for a sum.

Sympy reads exp(-97583/(10 T)) as the 97583rd power of exp(-1/(10 T)).  With two such powers its
greatest common divisor evaluates polynomials at integers that no memory holds, and the process
ends.  Here each exponential is a symbol of its own for the length of such a step.

sin(x + 2 y)/(x + 2 y) is a function of t = x + 2 y.  The Taylor forms treat removable singularities
only where one variable is zero.  A sum is therefore replaced by one variable t if the expression
depends on the variables of the sum only through the sum.  A variable that is itself a divisor is
not replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

LARGEST = 64  # the largest power that the grammar of plant files lets stand


def with_exponentials_as_symbols(
    step: Callable[[sp.Expr], sp.Expr], expression: sp.Expr
) -> sp.Expr:
    """Return ``step(expression)``, with symbols in the place of exponentials of large numbers.

    ``step`` rewrites an expression without changing its value, such as ``sympy.cancel``; what it
    returns has the exponentials again.  It is given the expression itself unless at least two
    different exponentials have a rational factor above ``LARGEST``.
    """
    exponentials = [e for e in expression.atoms(sp.exp) if _size(e.args[0]) > LARGEST]
    if len(exponentials) < 2:
        return step(expression)
    back = {
        sp.Dummy(f"e{k}", positive=True): e for k, e in enumerate(sorted(exponentials, key=str))
    }
    covered = expression.xreplace({e: symbol for symbol, e in back.items()})
    return step(covered).xreplace(back)


def _size(exponent: sp.Expr) -> int:
    """Return the largest numerator among the rational factors of the exponent's terms."""
    terms = sp.Add.make_args(exponent)
    return max(abs(int(term.as_coeff_Mul(rational=True)[0].p)) for term in terms)


def derivative(expression: sp.Expr, symbol: sp.Symbol, order: int = 1) -> sp.Expr | None:
    """Return the derivative; None where a table has no further one."""
    try:
        return expression.diff(symbol, order)
    except ModelError:
        return None


def is_zero(expression: sp.Expr) -> bool:
    if expression == 0 or sp.expand(expression) == 0:
        return True
    return bool(with_exponentials_as_symbols(sp.simplify, expression) == 0)


def slope_or_none(expression: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
    """Return the derivative, or an expression that no tape knows."""
    slope = derivative(expression, symbol)
    return sp.Function("no_slope")(symbol) if slope is None else slope


def order_of(exponent: object) -> int:
    return int(exponent) if isinstance(exponent, (int, sp.Integer)) and exponent > 0 else 0


Linear: TypeAlias = "tuple[tuple[sp.Symbol, Fraction], ...]"


def combined(
    expression: sp.Expr, sides: Mapping[sp.Symbol, Interval]
) -> tuple[sp.Expr, dict[sp.Symbol, Interval], dict[sp.Symbol, sp.Expr]]:
    """Return the expression in t_k = sum_i a_i x_i + c where it divides by such sums.

    Besides ranges of all variables, and what each t_k stands for.

    The range of t_k over the box is exact, and so is that of the expression in t_k: the x_i of a
    sum stand nowhere else.  Symbols without a range leave everything as it is.
    """
    written, sums = _sums_of(expression)
    new_sides, meanings = dict(sides), {}
    for symbol, linear, offset, base in sums:
        if any(s not in sides for s, _ in linear):
            return expression, dict(sides), {}
        total = Interval(offset, offset)
        for s, factor in linear:
            total = total + sides[s] * factor
        new_sides[symbol], meanings[symbol] = total, base
    return written, new_sides, meanings


@lru_cache(maxsize=256)
def _sums_of(
    expression: sp.Expr,
) -> tuple[sp.Expr, tuple[tuple[sp.Symbol, Linear, Fraction, sp.Expr], ...]]:
    """Return the expression with sums replaced, and each with its terms and constant."""
    sums: list[tuple[sp.Symbol, Linear, Fraction, sp.Expr]] = []
    divisors = {
        power.base
        for power in expression.atoms(sp.Pow)
        if power.base.is_Add and power.exp.is_Rational and power.exp.is_negative
    }
    # Quotients of polynomials are exact as they are.
    if not divisors or expression.is_rational_function(*expression.free_symbols):
        return expression, ()
    # A variable that divides by itself, as x in (exp(x/(1 + x)) - 1)/x, has its singularity at its
    # own zero, and would lose it to the sum 1 + x.
    alone = {
        power.base
        for power in expression.atoms(sp.Pow)
        if power.base.is_Symbol and power.exp.is_Rational and power.exp.is_negative
    }
    for base in sorted(divisors, key=str):
        symbols = sorted(base.free_symbols, key=lambda s: (s.name, str(s)))
        if alone.intersection(symbols):
            continue
        linear = linear_terms(base, symbols) if set(symbols) <= expression.free_symbols else None
        if linear is None:
            continue
        t = sp.Dummy(f"combination{len(sums) + 1}", real=True)
        # x_1 is put in terms of t everywhere; if the others drop out, only t was there.
        (first, factor), *further_terms = linear[0]
        other_terms = sum(
            (sp.Rational(a.numerator, a.denominator) * s for s, a in further_terms), sp.S.Zero
        )
        constant = sp.Rational(linear[1].numerator, linear[1].denominator)
        solved = (t - other_terms - constant) / sp.Rational(factor.numerator, factor.denominator)
        # Every sum in it is multiplied out, so that what cancels is gone.
        substituted = expression.subs(first, solved)
        written = substituted.replace(lambda term: term.is_Add, sp.expand)
        if not written.free_symbols & set(symbols):
            expression = written
            sums.append((t, *linear, base))
    return expression, tuple(sums)


def linear_terms(base: sp.Expr, symbols: list[sp.Symbol]) -> tuple[Linear, Fraction] | None:
    """Return (terms, constant) of a sum that is affine with rational coefficients."""
    if not base.is_polynomial(*symbols):
        return None
    polynomial = sp.Poly(base, *symbols)
    if polynomial.total_degree() != 1 or not all(c.is_Rational for c in polynomial.coeffs()):
        return None
    slopes = [(s, polynomial.coeff_monomial(s)) for s in symbols]
    terms = [(s, c) for s, c in slopes if c != 0]
    if not terms:
        return None
    constant = polynomial.coeff_monomial(1)
    return (
        tuple((s, Fraction(int(c.p), int(c.q))) for s, c in terms),
        Fraction(int(constant.p), int(constant.q)),
    )
