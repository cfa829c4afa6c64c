r"""Points where a premise is 0/0, and its Taylor polynomial, which replaces it there.

Premises such as sin(x)/x have a limit at x = 0, but no value in floating point; near it, others
lose digits, (1 - cos x)/x^2 all of them below 1e-8.  For each factor of the denominator that
vanishes in the box a polynomial in that factor is written, and the distance within which it is
nearer to the premise than floating point is.  Both are tried against ball arithmetic at points
near that distance; the error is at most ``RELATIVE_ACCURACY`` of the premise's size there.

Where a premise with a table is 0/0, as friction(omega)/omega, its spline is one cubic below the
point and another above it, so that a polynomial is written for each side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.plant.table import DEGREE, at_point
from takagi.certificates.document.plant_embedding import rational_symbol, text_data
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.intervals.interval import Interval
    from takagi.models.splines.spline import Curve
    from takagi.models.ts.model import TSModel

# Relative accuracy of the polynomial that replaces a premise near 0/0.
RELATIVE_ACCURACY = 1e-12
# Distances to try, as shares of the factor's largest size in the box; and powers of the factor.
SHARES = (1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1)
ORDERS = (3, 4, 6, 8, 10)
# Test points of the step's own formula, and of the polynomial, in units of the distance.
MOST_ORDER = 6  # of a zero of the denominator
OUTSIDE, INSIDE = (1.0, -1.0, 1.3, -1.7, 3.0, -3.0), (1.0, -1.0, 0.6, -0.3)


def removable_points(
    model: TSModel, law_premises: Sequence[Mapping[str, Any]] | None = None
) -> tuple[dict[str, list[dict[str, Any]]], tuple[str, ...]]:
    """Return premise -> [{of, within, formula, limit}], and messages for premises without one.

    ``of`` is the factor that vanishes, in the grammar of plant files.

    ``law_premises`` : of a law, which may have weights of its own; None for those of the model.
    """
    form = None if model.derivation is None else model.derivation.form
    points_of: dict[str, list[dict[str, Any]]] = {}
    words: list[str] = []
    if form is None:
        return points_of, ()
    constants = {s: rational_symbol(v) for s, v in form.factored.constants.items()}
    expressions = {
        premise.name: expression.xreplace(constants)
        for premise, expression in zip(model.premises, form.factored.premises.values(), strict=True)
    }
    if law_premises is not None and all("expression" in premise for premise in law_premises):
        expressions = _of_the_law(law_premises, expressions, form.problem.sides, words)
    for name, written in expressions.items():
        points = list(_jumps(written, form.problem.sides))
        jumping = {point["of"] for point in points}
        for factor, symbol in _vanishing(written, form.problem.sides):
            if text_data(factor) in jumping:
                continue
            try:
                points.append(_stand_in(written, factor, symbol, form.problem.sides))
            except ModelError as error:
                words.append(f"premise {name} is 0/0 where {factor} = 0: {error}")
        if points:
            points_of[name] = points
    return points_of, tuple(words)


def _of_the_law(
    premises: Sequence[Mapping[str, Any]],
    expressions: Mapping[str, sp.Expr],
    box: Mapping[sp.Symbol, Interval],
    words: list[str],
) -> dict[str, sp.Expr]:
    """Return the premises of a law: the model's where the texts agree, others as they are read."""
    from takagi.models.expressions.parser import Scope, parse_expression

    model_premises = {text_data(expression): expression for expression in expressions.values()}
    scope = Scope({symbol.name: symbol for symbol in box})
    law_expressions: dict[str, sp.Expr] = {}
    for premise in premises:
        name, text = str(premise["name"]), str(premise["expression"])
        try:
            law_expressions[name] = (
                model_premises[text] if text in model_premises else parse_expression(text, scope)
            )
        except ModelError:
            words.append(f"premise {name}: whether it is 0/0 somewhere is not known")
    return law_expressions


def _jumps(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> Iterator[dict[str, Any]]:
    """Yield what replaces a premise that jumps at x = 0, as |x|/x: its two sides.

    At x = 0 it is the value above; the premise is a factor of x alone.
    """
    import sympy as sp

    from takagi.models.ranges.cell_search import Cell, parts_by_sign

    for size in sorted(expression.atoms(sp.Abs), key=str):
        symbol = size.args[0]
        if not symbol.is_Symbol or not box[symbol].contains(0):
            continue
        if not expression.subs(symbol, 0).has(sp.nan, sp.zoo, sp.oo):
            continue
        sides = [written for written, _ in parts_by_sign(expression, [Cell({symbol: box[symbol]})])]
        limits = [side.subs(symbol, 0) for side in sides]
        if any(limit.has(sp.nan, sp.zoo, sp.oo) for limit in limits):
            continue
        below, above = text_data(sides[0]), text_data(sides[-1])
        yield {
            "of": symbol.name,
            "within": RELATIVE_ACCURACY * float(box[symbol].magnitude),
            "formula": f"choose({symbol.name}, {below}, {above})",
            "limit": text_data(limits[-1]),
        }


def _vanishing(
    expression: sp.Expr, box: Mapping[sp.Symbol, Interval]
) -> Iterator[tuple[sp.Expr, sp.Symbol]]:
    """Yield factors of the denominator that vanish somewhere in the box, and a variable of each."""
    import sympy as sp

    if not any(p.exp.is_negative and p.base.free_symbols for p in expression.atoms(sp.Pow)):
        return
    for factor in sp.Mul.make_args(sp.factor(sp.fraction(sp.together(expression))[1])):
        base = factor.as_base_exp()[0]
        linear = [
            s for s in sorted(base.free_symbols, key=str)
            if s in box and base.is_polynomial(s) and sp.degree(base, s) == 1
        ]  # fmt: skip
        if linear and _low(base, box) <= 0 <= -_low(-base, box):
            yield base, linear[0]


def _low(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> float:
    from takagi.models.ranges.expression_range import expression_range

    if expression.is_Symbol:
        return float(box[expression].lower)
    if (-expression).is_Symbol:
        return -float(box[-expression].upper)
    domain = {s: box[s] for s in expression.free_symbols}
    return float(expression_range(expression, domain).outer.lower)


def _stand_in(
    expression: sp.Expr, factor: sp.Expr, symbol: sp.Symbol, box: Mapping[sp.Symbol, Interval]
) -> dict[str, Any]:
    import sympy as sp

    t = sp.Symbol("t_", real=True)
    # The factor is linear in the variable.
    slope = factor.diff(symbol)
    back = (t - factor.subs(symbol, 0)) / slope
    size = max(abs(float(end)) for end in (_low(factor, box), -_low(-factor, box)))
    others = {s: box[s] for s in expression.free_symbols if s != symbol}
    rows = [
        {s: float(side.lower) * k + float(side.upper) * (1 - k) for s, side in others.items()}
        for k in (0.0, 0.35, 1.0)
    ]
    # An expression with tables has one polynomial on each side, up to the next knot.
    polynomials, reach = one_sided(expression, symbol, back.subs(t, 0)), math.inf
    sides, signs = [expression], [0]
    if polynomials is not None:
        # The factor is slope times a deviation of the variable.
        sides, signs, reach = [*polynomials[:2]], [-1, 1], polynomials[2] * abs(float(slope))
    text = text_data(factor)
    for order in ORDERS:
        terms = [_terms(side.subs(symbol, back), t, order) for side in sides]
        for share in SHARES:
            distance = float(f"{share * size:.3g}")
            if distance >= reach:
                continue
            trials = [
                _Trial(side, symbol, back, t, coefficients, distance)
                for side, coefficients in zip(sides, terms, strict=True)
            ]
            if all(
                trial.good(rows, sign=sign, largest_factor=reach)
                for trial, sign in zip(trials, signs, strict=True)
            ):
                below, *above = (_written(coefficients, text) for coefficients in terms)
                if len(sides) > 1 and sp.simplify(terms[0][0] - terms[1][0]) != 0:
                    raise ModelError("its limits from both sides differ")
                alike = above in ([], [below])
                return {
                    "of": text,
                    "within": distance,
                    "formula": below if alike else f"choose({text}, {below}, {above[0]})",
                    "limit": text_data(terms[-1][0]),
                }
    raise ModelError("no polynomial was found that is close enough to it there")


def _terms(quotient: sp.Expr, t: sp.Symbol, count: int) -> list[sp.Expr]:
    """Return the coefficients of t^0, t^1, ... of N(t) / D(t), D = t^p G, by division of series."""
    import sympy as sp

    top, bottom = sp.fraction(sp.together(quotient))
    order = next(
        (k for k, c in enumerate(_derivatives(bottom, t, MOST_ORDER)) if not _vanishes(c)), None
    )
    if order is None:
        raise ModelError("its denominator vanishes there to a high order")
    below = _derivatives(bottom, t, count + order)
    above = _derivatives(top, t, count + order)
    if not all(_vanishes(c) for c in above[:order]):
        raise ModelError("it is a pole: the numerator does not vanish with it")
    coefficients: list[sp.Expr] = []
    for k in range(count):
        remainder = above[k + order] - sum(coefficients[j] * below[k - j + order] for j in range(k))
        coefficients.append(_plain(remainder / below[order]))
    return coefficients


def _derivatives(expression: sp.Expr, t: sp.Symbol, count: int) -> list[sp.Expr]:
    """Return the Taylor coefficients at t = 0."""
    coefficients, derivative = [], expression
    for k in range(count):
        value = derivative.subs(t, 0)
        if not value.is_finite and value.is_finite is not None:
            raise ModelError("its numerator or denominator has no value there")
        coefficients.append(value / math.factorial(k))
        derivative = derivative.diff(t)
    return coefficients


def _plain(value: sp.Expr) -> sp.Expr:
    """Return a number with 17 digits, where it is one that is not short and rational."""
    import sympy as sp

    if not value.is_number:
        return sp.simplify(value)
    short = value.is_Rational and abs(value.p) < 10**15 and value.q < 10**15
    return value if short else sp.Float(value.evalf(30), 17)


def _vanishes(value: sp.Expr) -> bool:
    import sympy as sp

    return bool(abs(value.evalf(30)) < 1e-25) if value.is_number else sp.simplify(value) == 0


class _Trial:
    """One polynomial over one distance."""

    def __init__(
        self, expression: sp.Expr, symbol: sp.Symbol, back: sp.Expr, t: sp.Symbol,
        terms: list[sp.Expr], within: float,
    ) -> None:  # fmt: skip
        import sympy as sp

        self.expression, self.symbol, self.within = expression, symbol, within
        self.others = sorted(expression.free_symbols - {symbol}, key=str)
        self.back = sp.lambdify([t, *self.others], back, modules="math")
        self.own = sp.lambdify([symbol, *self.others], expression, modules="math")
        polynomial = sp.horner(sum(c * t**k for k, c in enumerate(terms)), t)
        self.polynomial = sp.lambdify([t, *self.others], polynomial, modules="math")

    def good(
        self, rows: list[dict[sp.Symbol, float]], *, sign: int = 0, largest_factor: float = math.inf
    ) -> bool:
        """Return whether formula and polynomial are near the expression where each is used.

        ``sign`` : of the factor, where the expression holds on one side alone; 0 for both.
        ``largest_factor`` : the largest factor at which it holds.
        """

        def on_side(shares: tuple[float, ...]) -> list[float]:
            return [s for s in shares if s * sign >= 0 and abs(s) * self.within < largest_factor]

        for row in rows:
            other_values = [row[s] for s in self.others]
            for share in on_side(OUTSIDE):
                x = float(self.back(share * self.within, *other_values))
                if not self.near(float(self.own(x, *other_values)), x, row):
                    return False
            for share in on_side(INSIDE):
                x = float(self.back(share * self.within, *other_values))
                value = float(self.polynomial(share * self.within, *other_values))
                if not self.near(value, x, row):
                    return False
        return True

    def near(self, value: float, x: float, row: dict[sp.Symbol, float]) -> bool:
        from takagi.models.ranges.expression_range import expression_value

        exact = expression_value(self.expression, {**row, self.symbol: x})
        tolerance = RELATIVE_ACCURACY * max(abs(exact), 1e-30)
        return math.isfinite(value) and abs(value - exact) <= tolerance


def _written(terms: list[sp.Expr], factor: str) -> str:
    """Return c_0 + t (c_1 + t (...)) as text."""
    import sympy as sp

    t = sp.Symbol("t_", real=True)
    text = str(sp.horner(sum(c * t**k for k, c in enumerate(terms)), t)).replace("**", "^")
    return text.replace("t_", factor if factor.isidentifier() else f"({factor})")


def one_sided(
    expression: sp.Expr, symbol: sp.Symbol, point: sp.Expr
) -> tuple[sp.Expr, sp.Expr, float] | None:
    """Return the expression below and above ``symbol = point``, and how far from there they hold.

    None for an expression without tables.

    Raises
    ------
    ModelError : a table of two arguments, one of another argument than symbol plus a number, or a
        point that is no rational number.
    """
    import sympy as sp

    from takagi.models.splines.spline import Curve
    from takagi.models.splines.table_function import TableFunction

    calls = sorted(expression.atoms(TableFunction), key=str)
    if not calls:
        return None
    below: dict[sp.Expr, sp.Expr] = {}
    above: dict[sp.Expr, sp.Expr] = {}
    reach = float("inf")
    for call in calls:
        if symbol not in call.free_symbols:
            continue
        (argument, *further) = call.args
        curve = call.func.table
        if further or not isinstance(curve, Curve) or not (argument - symbol).is_Rational:
            raise ModelError(f"{call} is no table of {symbol} alone, plus a number")
        argument_there = argument.subs(symbol, point)
        if not argument_there.is_Rational:
            raise ModelError(f"{call} is 0/0 where {symbol} is {point}, which is no number")
        x = Fraction(int(argument_there.p), int(argument_there.q))
        (order,) = call.func.orders
        for replacements, side in ((below, -1), (above, 1)):
            powers = _piece(curve, x, side)
            t = argument - argument_there
            cubic = sum(sp.Rational(*c.as_integer_ratio()) * t**k for k, c in enumerate(powers))
            replacements[call] = sp.diff(cubic, symbol, order)
        reach = min(reach, _reach(curve, x))
    return expression.xreplace(below), expression.xreplace(above), reach


def _piece(curve: Curve, x: Fraction, side: int) -> list[Fraction]:
    """Return the Taylor coefficients at x of the polynomial below (-1) or above (1) it."""
    knots = [Fraction(repr(float(k))) for k in curve.knots]
    coefficients = [Fraction(repr(float(c))) for c in curve.coefficients]
    spans = [k for k in range(DEGREE, len(knots) - DEGREE - 1) if knots[k] < knots[k + 1]]
    inside = [
        k
        for k in spans
        if (knots[k] < x <= knots[k + 1] if side < 0 else knots[k] <= x < knots[k + 1])
    ]
    span = inside[0] if inside else (spans[0] if side < 0 else spans[-1])
    near, active = knots[span - 2 : span + 4], coefficients[span - DEGREE : span + 1]
    return [at_point(near, active, x, k) / math.factorial(k) for k in range(DEGREE + 1)]


def _reach(curve: Curve, x: Fraction) -> float:
    """Return the distance from x to the nearest other knot."""
    away = {abs(Fraction(repr(float(k))) - x) for k in curve.knots} - {Fraction(0)}
    return float(min(away))
