"""The right-hand side of the plant by its own equations, in floating point, without a model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

Rate = Callable[[Floats, Floats, Floats], Floats]


def right_side(
    plant: Plant,
    moving: Sequence[Variable] = (),
    *,
    fixed: Mapping[str, Fraction] | None = None,
    told: bool = False,
) -> Rate:
    """Return (x, u, w) -> x' of the plant, or x(t + T) in discrete time; all in SI.

    A blended plant is evaluated by the equations that its file states, with its two actuators,
    each limited to its range; the last entry of u is then the rate of the effort.

    Parameters
    ----------
    moving : the disturbances in w, in the order of w; all others keep their rest values.
    fixed : name -> value of disturbances, such as uncertain parameters, that replaces the rest
        value; not for a blended plant.
    told : for a blended plant, whether the last entries of u are the commands of its two
        actuators; if not, the commands follow from the state.
    """
    import sympy as sp

    from takagi.models.blending.blending import blending_of
    from takagi.models.blending.run_time import RunTimeBlending

    blending = blending_of(plant)
    if blending is not None:
        return RunTimeBlending(blending).disturbed_rate(moving, limited=True, told=told)
    free = [v.symbol for v in moving]
    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    values |= {
        v.symbol: sp.Rational(*(fixed or {}).get(v.name, v.rest).as_integer_ratio())
        for v in plant.disturbances
        if v.symbol not in free
    }
    symbols = [*(v.symbol for v in (*plant.states, *plant.inputs)), *free]
    rows = [sp.sympify(row).subs(values) for row in plant.equations]
    right = sp.lambdify(symbols, rows, modules=["scipy", "numpy"])
    mass = None
    if plant.mass is not None:
        mass = sp.lambdify(symbols, plant.mass.subs(values).tolist(), modules=["scipy", "numpy"])

    def rate(x: Floats, u: Floats, w: Floats) -> Floats:
        point = (*map(float, x), *map(float, u), *map(float, w))
        f = np.array(right(*point), dtype=np.float64)
        if mass is None:
            return f
        return np.asarray(np.linalg.solve(np.array(mass(*point), float), f), dtype=np.float64)

    return rate
