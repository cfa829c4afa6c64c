"""Expressions as functions of floats and arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp

_IN_NUMPY = frozenset(
    "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sinc sign Abs "
    "Max Min Piecewise".split()
)


def float_function(symbols: Sequence[sp.Symbol], written: Any) -> Callable[..., Any]:
    """Return the function of the symbols' values, floats or arrays, that evaluates expressions.

    scipy's special functions take longer to load than all of sympy, so they are only for
    expressions with a function that numpy lacks.

    Parameters
    ----------
    written : an expression, or a list of them; the value is of the same form.
    """
    rows = written if isinstance(written, list | tuple) else [written]
    functions = {f.func for row in rows for f in sp.sympify(row).atoms(sp.Function)}
    # A table brings its own program.
    scipy_too = any(f.__name__ not in _IN_NUMPY and not hasattr(f, "_imp_") for f in functions)
    function: Callable[..., Any] = sp.lambdify(
        symbols, written, modules=["scipy", "numpy"] if scipy_too else ["numpy"]
    )
    return function
