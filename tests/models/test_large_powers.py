"""Two Arrhenius laws of different activation energies, as most textbook reactors have them."""

from __future__ import annotations

import sympy as sp

from takagi.models import Interval
from takagi.models.ranges.expression_range import expression_range
from takagi.models.ranges.symbolic_steps import with_exponentials_as_symbols

T, c = sp.symbols("T c", real=True)
FIRST = sp.exp(-sp.Rational(97583, 10) / T)
SECOND = sp.exp(-sp.Integer(8560) / T)


def test_the_step_sees_symbols_and_gives_the_exponentials_back() -> None:
    """(e1 c + e2 c)/c is e1 + e2; no exponential is within what the step is given."""
    seen: list[sp.Expr] = []

    def step(expression: sp.Expr) -> sp.Expr:
        seen.append(expression)
        return sp.cancel(expression)

    found = with_exponentials_as_symbols(step, (FIRST * c + SECOND * c**2) / c)

    assert sp.expand(found - FIRST - SECOND * c) == 0
    assert not seen[0].has(sp.exp)


def test_a_single_exponential_or_small_ones_are_left_as_they_are() -> None:
    for expression in (FIRST * c, sp.exp(c) + sp.exp(2 * c), sp.sin(c)):
        assert with_exponentials_as_symbols(sp.Tuple, expression) == (expression,)


def test_a_quotient_of_two_arrhenius_laws_is_bounded_across_its_limit() -> None:
    """(k1(387 + d) - k1(387) + k3(387 + d) - k3(387))/d, with the derivative at d = 0.

    sympy reads these as powers 97583 and 8560 of exponentials; its greatest common divisor of the
    numerator asked for numbers of more than 2^36 bits, and the process ended.
    """
    d = sp.Symbol("d", real=True)
    rates = 1287 * 10**9 * FIRST + 9043 * 10**6 * SECOND + c * FIRST * SECOND
    quotient = (rates.subs(T, 387 + d) - rates.subs(T, 387)) / d
    box = {d: Interval.of(-4, 4), c: Interval.of(1, 2)}
    found = expression_range(quotient, box).outer

    slope = float(rates.diff(T).subs({T: 387, c: 1}))
    assert float(found.lower) < slope < float(found.upper)
    for end in (-4, 4):
        value = float(quotient.subs({d: end, c: 1}).evalf(30))
        assert float(found.lower) <= value * (1 + 1e-9) and value <= float(found.upper) * (1 + 1e-9)
    assert float(found.upper) < 3 * slope
