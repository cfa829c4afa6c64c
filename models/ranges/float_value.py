"""An expression in floats, where rounding leaves it a true value to twelve digits.

Every operation is computed together with a bound of its error, to first order in u = 2^-53:

    a + b : e_a + e_b + u |a + b|               a b : |a| e_b + |b| e_a + u |a b|
    a^n   : |n a^(n-1)| e_a + 2 u |a^n|        f(a) : |f'(a)| e_a + 2 u |f(a)|

Near 0/0, as (1 - cos x)/x^2 about x = 0, the bound grows beyond what is accepted.

Source: Higham (2002), Accuracy and Stability of Numerical Algorithms, section 3.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import sympy as sp

ROUNDING = 2.0**-53
# Accepted bound of the error, as a share of the value.
ACCURACY = 1e-12
# Function -> its name in ``math``, and a bound of its slope at ``a``, where its value is ``v``.
_SLOPES: Mapping[Any, tuple[str, str]] = {
    sp.sin: ("sin", "1"),
    sp.cos: ("cos", "1"),
    sp.tan: ("tan", "(1 + {v}*{v})"),
    sp.asin: ("asin", "1/sqrt(1 - {a}*{a})"),
    sp.acos: ("acos", "1/sqrt(1 - {a}*{a})"),
    sp.atan: ("atan", "1"),
    sp.exp: ("exp", "{v}"),
    sp.log: ("log", "1/{a}"),
    sp.sinh: ("sinh", "(1 + abs({v}))"),
    sp.cosh: ("cosh", "{v}"),
    sp.tanh: ("tanh", "1"),
    sp.asinh: ("asinh", "1"),
    sp.atanh: ("atanh", "1/(1 - {a}*{a})"),
    sp.erf: ("erf", "1.13"),
}
_FUNCTIONS = {name: getattr(math, name) for name, _ in _SLOPES.values()}


class NotInFloats(Exception):
    """A part of an expression that is not evaluated in floats: ball arithmetic does it."""


FloatValue = Callable[[Sequence[float]], float | None]


def float_value(expression: sp.Expr, symbols: Sequence[sp.Symbol]) -> FloatValue | None:
    """Return the function of the symbols' values, or None for functions that it does not know.

    It returns None where an operation has no value, or the bound of the error is larger than
    ``ACCURACY`` times the value.
    """
    writer = _Writer(symbols)
    try:
        value, error = writer.written(expression)
    except NotInFloats:
        return None
    lines = [f"def compiled({', '.join(writer.arguments)}):", *writer.lines]
    lines.append(f"    return {value}, {error}")
    names: dict[str, Any] = {"sqrt": math.sqrt, "power": math.pow, **_FUNCTIONS}
    exec("\n".join(lines), names)
    compiled = names["compiled"]

    def evaluate(point: Sequence[float]) -> float | None:
        try:
            value, error = compiled(*point)
        except (ArithmeticError, ValueError):
            return None
        # A comparison with nan is false.
        return value if error <= ACCURACY * abs(value) < math.inf else None

    return evaluate


class _Writer:
    """Writes an expression as lines of Python, each part once.

    A part is the name of its value and that of its error bound, "0" where it is exact.
    """

    def __init__(self, symbols: Sequence[sp.Symbol]) -> None:
        self.arguments = [f"x{k}" for k in range(len(symbols))]
        self.lines: list[str] = []
        self._parts: dict[sp.Expr, tuple[str, str]] = {
            symbol: (name, "0") for symbol, name in zip(symbols, self.arguments, strict=True)
        }

    def written(self, expression: sp.Expr) -> tuple[str, str]:
        if expression not in self._parts:
            self._parts[expression] = self._new(expression)
        return self._parts[expression]

    def _new(self, expression: sp.Expr) -> tuple[str, str]:
        if expression.is_number:
            return self._number(expression)
        if expression.is_Add or expression.is_Mul:
            first, *others = map(self.written, expression.args)
            for other in others:
                first = (
                    self._sum(first, other) if expression.is_Add else self._product(first, other)
                )
            return first
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        if expression.func is sp.Abs:
            value, error = self.written(expression.args[0])
            return self._line(f"abs({value})"), error
        if expression.func not in _SLOPES:
            raise NotInFloats(expression)
        name, slope = _SLOPES[expression.func]
        argument, error = self.written(expression.args[0])
        value = self._line(f"{name}({argument})")
        terms = [f"{2 * ROUNDING}*abs({value})"]
        if error != "0":
            terms.append(f"abs({slope.format(a=argument, v=value)})*{error}")
        return value, self._line(" + ".join(terms))

    def _number(self, expression: sp.Expr) -> tuple[str, str]:
        if not expression.is_real or not expression.is_finite:
            raise NotInFloats(expression)
        value = float(expression)
        return f"({value!r})", "0" if sp.Rational(value) == expression else repr(
            ROUNDING * abs(value)
        )  # fmt: skip

    def _sum(self, first: tuple[str, str], second: tuple[str, str]) -> tuple[str, str]:
        value = self._line(f"{first[0]} + {second[0]}")
        errors = [error for _, error in (first, second) if error != "0"]
        return value, self._line(" + ".join([*errors, f"{ROUNDING}*abs({value})"]))

    def _product(self, first: tuple[str, str], second: tuple[str, str]) -> tuple[str, str]:
        value = self._line(f"{first[0]}*{second[0]}")
        terms = [f"{ROUNDING}*abs({value})"]
        for (factor, _), (_, error) in ((first, second), (second, first)):
            if error != "0":
                terms.append(f"abs({factor})*{error}")
        return value, self._line(" + ".join(terms))

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> tuple[str, str]:
        if not exponent.is_Rational:
            raise NotInFloats(exponent)
        argument, error = self.written(base)
        if exponent == sp.Rational(1, 2):
            value = self._line(f"sqrt({argument})")
            slope = f"0.5/{value}"
        elif exponent.is_Integer:
            n = int(exponent)
            value = self._line(f"{argument}**{n}" if n > 0 else f"1/{argument}**{-n}")
            slope = f"{n}*{argument}**{n - 1}"
        else:
            value = self._line(f"power({argument}, {float(exponent)!r})")
            slope = f"{float(exponent)!r}*{value}/{argument}"
        terms = [f"{2 * ROUNDING}*abs({value})"]
        if error != "0":
            terms.append(f"abs({slope})*{error}")
        return value, self._line(" + ".join(terms))

    def _line(self, formula: str) -> str:
        name = f"v{len(self.lines)}"
        self.lines.append(f"    {name} = {formula}")
        return name


_IN_NUMPY = frozenset(
    "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sinc sign Abs "
    "Max Min Piecewise".split()
)


def float_function(symbols: Sequence[sp.Symbol], written: Any) -> Callable[..., Any]:
    """Return the function of the symbols' values, floats or arrays, that evaluates expressions.

    scipy's special functions take longer to load than all of sympy, so they are only for
    expressions with a function that numpy lacks.

    ``written`` : an expression, or a list of them; the value is of the same form.
    """
    rows = written if isinstance(written, list | tuple) else [written]
    functions = {f.func for row in rows for f in sp.sympify(row).atoms(sp.Function)}
    # A table brings its own program.
    scipy_too = any(f.__name__ not in _IN_NUMPY and not hasattr(f, "_imp_") for f in functions)
    function: Callable[..., Any] = sp.lambdify(
        symbols, written, modules=["scipy", "numpy"] if scipy_too else ["numpy"]
    )
    return function
