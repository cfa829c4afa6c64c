"""A plant's expressions as functions of floats."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant


def numeric(
    rows: Iterable[sp.Expr], symbols: Sequence[sp.Symbol], values: Mapping[sp.Symbol, sp.Expr]
) -> Callable[..., Floats]:
    """Return the function of the symbols' values that gives the values of the rows, (rows,).

    Parameters
    ----------
    values : of all other symbols, put in first.
    """
    import sympy as sp

    expressions = [sp.sympify(row).subs(values) for row in rows]
    function = sp.lambdify(symbols, expressions, modules=["scipy", "numpy"])
    return lambda *point: np.array(function(*point), dtype=np.float64)


def explicit_rows(
    plant: Plant, symbols: Sequence[sp.Symbol], values: Mapping[sp.Symbol, sp.Expr]
) -> Callable[..., Floats]:
    """Return f of the plant's equations, or M^-1 f, as a function of the symbols in floats."""
    right_sides = numeric(plant.equations, symbols, values)
    if plant.mass is None:
        return right_sides
    mass, shape = numeric(plant.mass, symbols, values), plant.mass.shape

    def solved(*point: float) -> Floats:
        M, f = mass(*point).reshape(shape), right_sides(*point)
        return np.asarray(np.linalg.solve(M, f), dtype=np.float64)

    return solved
