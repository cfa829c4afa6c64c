"""Descent by BFGS with a weak Wolfe line search, which also works where the function has kinks.

Source: Lewis and Overton (2013), Mathematical Programming 141: the line search is their algorithm
2.6, by bisection, and the update is the usual one; no smoothness is assumed, and none is promised
of the end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from takagi.models.arrays import Floats

Function: TypeAlias = Callable[[Floats], tuple[float, Floats]]

# The line search: the share of the slope that the value has to gain, and that may remain.
GAINED, REMAINING = 1e-4, 0.5
BISECTIONS = 50
# An interval this short, relative to x, is at a kink: nothing more is to be found in it.
SHORT = 1e-9
# The descent ends where so many steps together gained less than was asked for.
WINDOW = 15


class Descent(NamedTuple):
    """Where a descent ended, and the value there."""

    x: Floats
    value: float


class _Step(NamedTuple):
    x: Floats
    value: float
    gradient: Floats


def descend(
    function: Function, x: Floats, *, steps: int, enough: float, below: float = -np.inf
) -> Descent:
    """Return the end of a descent from x.

    Parameters
    ----------
    function : x to (value, gradient); a value of inf is a wall.
    steps : the most steps.
    enough : the descent ends where ``WINDOW`` steps together gained less than this.
    below : it also ends at a value below this one.
    """
    value, gradient = function(x)
    here = _Step(x, value, gradient)
    if not np.isfinite(value):
        return Descent(x, value)
    inverse: Floats | None = None
    values = [value]
    for _ in range(steps):
        if here.value < below or not here.gradient.any():
            break
        step = None if inverse is None else _searched(function, here, -inverse @ here.gradient)
        if step is None:
            # A fresh start along the gradient, once the curvature is of no use.
            inverse = None
            size = float(np.linalg.norm(here.gradient))
            step = _searched(function, here, -here.gradient / max(size, 1.0))
        if step is None:
            break
        inverse = _updated(inverse, step.x - here.x, step.gradient - here.gradient)
        here = step
        values.append(here.value)
        if len(values) > WINDOW and values[-1 - WINDOW] - here.value < enough:
            break
    return Descent(here.x, here.value)


def _searched(function: Function, here: _Step, direction: Floats) -> _Step | None:
    """Return a point along the direction with a lower value and a flatter slope; None if none."""
    slope = float(here.gradient @ direction)
    if not slope < 0 or not np.isfinite(direction).all():
        return None
    low, high, length = 0.0, np.inf, 1.0
    reach, size = float(np.linalg.norm(direction)), float(np.linalg.norm(here.x)) + SHORT
    lower: _Step | None = None
    for _ in range(BISECTIONS):
        x = here.x + length * direction
        value, gradient = function(x)
        # The comparison is written so that a value that is not a number counts as too large.
        if not value <= here.value + GAINED * length * slope:
            high = length
        else:
            lower = _Step(x, value, gradient)
            if gradient @ direction >= REMAINING * slope:
                return lower
            low = length
        length = 2.0 * low if np.isinf(high) else (low + high) / 2.0
        if (high - low) * reach < SHORT * size:
            break
    # The value falls, but the slope stays steep: a kink was not passed.
    return lower if lower is not None and lower.value < here.value else None


def _updated(inverse: Floats | None, moved: Floats, turned: Floats) -> Floats:
    """Return the inverse Hessian after a step; it stays positive definite."""
    along = float(moved @ turned)
    one = np.eye(len(moved))
    # Without positive curvature along the step the update would lose definiteness; it is left out.
    if not along > 0:
        return one if inverse is None else inverse
    if inverse is None:
        # The first inverse Hessian gets the size that the first step has shown (Nocedal and Wright,
        # 6.20).
        inverse = one * (along / float(turned @ turned))
    left = one - np.outer(moved, turned) / along
    found = left @ inverse @ left.T + np.outer(moved, moved) / along
    return found if np.isfinite(found).all() else one
