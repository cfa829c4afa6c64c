"""The equilibrium of a plant for each reference, by Newton's method in floating point.

Nothing is proved here.  The numbers say whether the inputs can hold a reference, and how far the
equilibrium is from the ends of the ranges; the search for a proof starts from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.plant.variables import Variable

if TYPE_CHECKING:
    pass

STEPS, ITERATIONS, HALVINGS = 8, 30, 30
MOST_CORNERS = 6
CLOSE = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class HeldRests:
    """Equilibria ("rests") of a plant with references.

    Attributes
    ----------
    signals : references, other disturbances with a range, and uncertain parameters, in the order
        of the plant.
    points : (k, s) values of the signals.
    values : (k, n + m), the plant's own states and inputs at these equilibria, SI; row 0 is the
        plant's rest.
    """

    signals: tuple[Variable, ...]
    points: Floats
    values: Floats


def signals_of(plant: Plant) -> tuple[Variable, ...]:
    """Return the signals with a range; each of their values has its own equilibrium."""
    return tuple(v for v in plant.disturbances if v.range is not None)


def held_rests(plant: Plant) -> HeldRests:
    """Return the equilibria at the corners of the signals' ranges, after the plant's own rest.

    Raises
    ------
    ModelError : a reference without an equilibrium, or with one outside the ranges of states and
        inputs; the message begins with the reference's name and states the largest value that the
        inputs can hold.
    """
    search = _Search(plant)
    ends = [(float(v.range.lower), float(v.range.upper)) for v in search.signals if v.range]
    middle = np.array([float(v.rest) for v in search.signals])
    if len(ends) <= MOST_CORNERS:
        corners = [np.array(corner) for corner in product(*ends)]
    else:
        corners = []
        for k, pair in enumerate(ends):
            for end in pair:
                point = middle.copy()
                point[k] = end
                corners.append(point)
    values = [search.start]
    for corner in corners:
        values.append(search.along(middle, corner))
    return HeldRests(search.signals, np.array([middle, *corners]), np.array(values))


class _Search:
    def __init__(self, plant: Plant) -> None:
        import sympy as sp

        names = {reference.name for reference in plant.references}
        integrals = {reference.integral for reference in plant.references}
        self.plant = plant
        self.own = [v for v in plant.states if v.name not in integrals]
        self.wanted: list[Variable] = [*self.own, *plant.inputs]
        self.signals = signals_of(plant)
        self.references = names
        fixed = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
        fixed |= {
            v.symbol: sp.Rational(*v.rest.as_integer_ratio())
            for v in plant.disturbances
            if v not in self.signals
        }
        rows = sp.Matrix([sp.sympify(row).subs(fixed) for row in plant.equations])
        unknowns = [v.symbol for v in self.wanted]
        symbols = [*unknowns, *(v.symbol for v in self.signals)]
        self._rows = sp.lambdify(symbols, list(rows), modules=["scipy", "numpy"])
        slopes = rows.jacobian(unknowns).tolist()
        self._slopes = sp.lambdify(symbols, slopes, modules=["scipy", "numpy"])
        self.start = np.array([float(v.rest) for v in self.wanted])
        self.scale = np.array([_size(v) for v in self.wanted])

    def along(self, first: Floats, last: Floats) -> Floats:
        """Return the equilibrium at ``last``, by continuation from that at ``first``."""
        value, held = self.start, 0.0
        for k in range(1, STEPS + 1):
            found = self._held(first + (last - first) * k / STEPS, value)
            if found is None:
                self._refuse(first, last, held, k / STEPS, value)
            assert found is not None  # refused above
            value, held = found, k / STEPS
        return value

    def _held(self, point: Floats, value: Floats) -> Floats | None:
        found = self._newton(point, value)
        return found if found is not None and not self._outside(found) else None

    def _newton(self, point: Floats, start: Floats) -> Floats | None:
        value = start.copy()
        for _ in range(ITERATIONS):
            with np.errstate(all="ignore"):
                rows = np.array(self._rows(*value, *point), dtype=np.float64)
                slopes = np.array(self._slopes(*value, *point), dtype=np.float64) * self.scale
            if not (np.all(np.isfinite(rows)) and np.all(np.isfinite(slopes))):
                return None
            step = np.linalg.lstsq(slopes, rows, rcond=None)[0]
            value = value - self.scale * step
            if np.abs(step).max() < CLOSE:
                # Newton's steps are small near a singular point too, so the residual is tested as
                # well.
                size = np.abs(slopes).sum(axis=1) + 1e-300
                return value if np.all(np.abs(rows) <= 1e-6 * size) else None
        return None

    def _outside(self, value: Floats) -> list[int]:
        found = []
        for k, variable in enumerate(self.wanted):
            if variable.range is not None:
                low, high = float(variable.range.lower), float(variable.range.upper)
                # A value exactly at the end of its range is inside; Newton's method finds it up to
                # rounding.
                slack = 1e-9 * (high - low)
                if not low - slack <= value[k] <= high + slack:
                    found.append(k)
        return found

    def _refuse(self, first: Floats, last: Floats, held: float, lost: float, value: Floats) -> None:
        """Raise ModelError with the largest reference on the way that the inputs can hold."""
        target = self._newton(last, value)
        for _ in range(HALVINGS):
            middle = (held + lost) / 2
            found = self._held(first + (last - first) * middle, value)
            if found is None:
                lost = middle
            else:
                held, value = middle, found
        moved = [k for k in range(len(last)) if last[k] != first[k]]
        most = first + (last - first) * held
        names = ", ".join(
            f"{self.signals[k].name} = {_shown(self.signals[k], last[k])}" for k in moved
        )
        best = ", ".join(
            f"{self.signals[k].name} = {_shown(self.signals[k], most[k])}" for k in moved
        )
        lead = min(
            (self.signals[k].name for k in moved if self.signals[k].name in self.references),
            default=min(self.references),
        )
        if target is None:
            why = f"the plant has no rest at {names}"
        else:
            parts = [
                f"{self.wanted[k].name} = {_shown(self.wanted[k], target[k])}, outside its range "
                f"{_ends(self.wanted[k])}"
                for k in self._outside(target)
            ]
            why = f"at {names} the plant rests with {'; '.join(parts)}"
        raise ModelError(
            f"{lead}: {why}; on the way there {best} is the last that is held: narrow the range of "
            "the reference, or widen what it leaves"
        )


def _size(variable: Variable) -> float:
    return 1.0 if variable.range is None else float(variable.range.width) / 2


def _shown(variable: Variable, value: float) -> str:
    from takagi.models.plant.file_units import file_unit

    size, unit = file_unit(variable)
    return f"{value / size:.4g}{'' if unit == '-' else f' {unit}'}"


def _ends(variable: Variable) -> str:
    from takagi.models.plant.file_units import file_unit

    assert variable.range is not None  # it left this range
    size, unit = file_unit(variable)
    low, high = (float(end) / size for end in (variable.range.lower, variable.range.upper))
    return f"[{low:.4g}, {high:.4g}]{'' if unit == '-' else f' {unit}'}"
