"""Outputs that follow references: the plant with integral states, and where it can be held.

    x' = f(x, u, w),   xi_j' = h_j(x) - r_j

The references r_j are signals from outside, known to the law; the xi_j are states of the law.
At an equilibrium with constant r, xi' = 0 means h_j(x) = r_j: there is no steady-state error.

The equilibrium for each reference is found by Newton's method in floating point.  Nothing is proved
here: the numbers say whether the inputs can hold a reference, and how far the equilibrium is from
the ends of the ranges.  ``equilibrium_line`` fits a function of the signals to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import rational
from takagi.models.plant.plant import (
    Plant,
    Reference,
    Variable,
    in_file_units,
    numeric,
    range_in_file_units,
)

if TYPE_CHECKING:
    import sympy as sp


def following_plant(
    plant: Plant, references: Sequence[tuple[Reference, Variable, Variable, sp.Expr]]
) -> Plant:
    """Return the plant with the integral states among its states, the references as signals.

    ``references`` : reference, its signal r with a range, its integral xi, and h(x) that follows.

    Raises
    ------
    ModelError : discrete time, a mass matrix, a blend, more references than inputs, a followed
        expression with an input or a disturbance.
    """
    name = plant.name
    if plant.sample_time is not None:
        raise ModelError(f"plant {name!r} is of discrete time; references are for x' = f(x, u, w)")
    if plant.mass is not None:
        raise ModelError(
            f"plant {name!r} has a mass matrix; to follow a reference write it as x' = f(x, u, w)"
        )
    if plant.blending is not None:
        raise ModelError(f"plant {name!r} is behind a blend; it follows no reference")
    if len(references) > len(plant.inputs):
        raise ModelError(
            f"plant {name!r}: {len(references)} references and {len(plant.inputs)} inputs; each "
            "reference needs an input of its own"
        )
    states = {v.symbol for v in plant.states}
    allowed = states | {p.symbol for p in plant.parameters}
    for reference, _, _, followed in references:
        strange = sorted(str(s) for s in followed.free_symbols - allowed)
        if strange or not followed.free_symbols & states:
            problem = f"depends on {', '.join(strange)}" if strange else "depends on no state"
            raise ModelError(
                f"{reference.follows} {problem}; what follows a reference is an expression of "
                "states and known parameters"
            )
    integral_rates = [followed - signal.symbol for _, signal, _, followed in references]
    return replace(
        plant,
        equations=(*plant.equations, *integral_rates),
        states=(*plant.states, *(integral for _, _, integral, _ in references)),
        disturbances=(
            *(_as_it_rests(plant, v) for v in plant.disturbances),
            *(signal for _, signal, _, _ in references),
        ),
        references=tuple(reference for reference, _, _, _ in references),
    )


def _as_it_rests(plant: Plant, variable: Variable) -> Variable:
    """Return an uncertain parameter that moves the rest as one that pushes the state."""
    import sympy as sp

    if not variable.unknown:
        return variable
    at_rest = plant.at_rest | plant.rationals
    del at_rest[variable.symbol]
    residuals = [sp.sympify(row).subs(at_rest) for row in plant.equations]
    moves = any(sp.simplify(row.diff(variable.symbol)) != 0 for row in residuals)
    return replace(variable, schedules=not moves)


STEPS, ITERATIONS, HALVINGS = 8, 30, 30
MOST_CORNERS = 6
MOST_HALVED = 4  # signals whose equilibria are computed on a grid of three values each
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


def held_rests(plant: Plant, *, inside: bool = False) -> HeldRests:
    """Return the equilibria at the corners of the signals' ranges, after the plant's own rest.

    ``inside`` : whether equilibria between the corners follow.

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
    if inside:
        halfway: list[tuple[float, ...]] = [(low, (low + high) / 2, high) for low, high in ends]
        if len(ends) > MOST_HALVED:
            halfway = list(ends)
        corner_points = {tuple(corner) for corner in corners}
        corners += [np.array(point) for point in product(*halfway) if point not in corner_points]
        for k, pair in enumerate(ends):
            for end in pair:
                corners.append(np.array([*middle[:k], end, *middle[k + 1 :]]))
    values = [search.start]
    for corner in corners:
        values.append(search.along(middle, corner))
    return HeldRests(search.signals, np.array([middle, *corners]), np.array(values))


class _Search:
    def __init__(self, plant: Plant) -> None:
        import sympy as sp

        names = {reference.name for reference in plant.references}
        self.plant = plant
        self.own = [plant.states[k] for k in plant.own_states]
        self.wanted: list[Variable] = [*self.own, *plant.inputs]
        self.signals = signals_of(plant)
        self.references = names
        fixed = plant.rationals
        fixed |= {v.symbol: rational(v.rest) for v in plant.disturbances if v not in self.signals}
        unknowns = [v.symbol for v in self.wanted]
        symbols = [*unknowns, *(v.symbol for v in self.signals)]
        rows = sp.Matrix([sp.sympify(row).subs(fixed) for row in plant.equations])
        self._rows = numeric(rows, symbols, {})
        self._slopes = numeric(rows.jacobian(unknowns), symbols, {})
        self.start = np.array([float(v.rest) for v in self.wanted])
        self.scale = np.array([_size(v) for v in self.wanted])

    def along(self, first: Floats, last: Floats) -> Floats:
        """Return the equilibrium at ``last``, by continuation from that at ``first``."""
        value, held_share = self.start, 0.0
        for k in range(1, STEPS + 1):
            equilibrium = self._held(first + (last - first) * k / STEPS, value)
            if equilibrium is None:
                self._refuse(first, last, held_share, k / STEPS, value)
            assert equilibrium is not None  # refused above
            value, held_share = equilibrium, k / STEPS
        return value

    def _held(self, point: Floats, value: Floats) -> Floats | None:
        equilibrium = self._newton(point, value)
        return equilibrium if equilibrium is not None and not self._outside(equilibrium) else None

    def _newton(self, point: Floats, start: Floats) -> Floats | None:
        value = start.copy()
        for _ in range(ITERATIONS):
            with np.errstate(all="ignore"):
                rows = self._rows(*value, *point)
                slopes = self._slopes(*value, *point).reshape(len(rows), -1) * self.scale
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
        outside = []
        for k, variable in enumerate(self.wanted):
            if variable.range is not None:
                low, high = float(variable.range.lower), float(variable.range.upper)
                # A value exactly at the end of its range is inside; Newton's method finds it up to
                # rounding.
                slack = 1e-9 * (high - low)
                if not low - slack <= value[k] <= high + slack:
                    outside.append(k)
        return outside

    def _refuse(
        self, first: Floats, last: Floats, held_share: float, lost: float, value: Floats
    ) -> None:
        """Raise ModelError with the largest reference on the way that the inputs can hold."""
        target = self._newton(last, value)
        for _ in range(HALVINGS):
            middle = (held_share + lost) / 2
            equilibrium = self._held(first + (last - first) * middle, value)
            if equilibrium is None:
                lost = middle
            else:
                held_share, value = middle, equilibrium
        moving = [k for k in range(len(last)) if last[k] != first[k]]
        last_held = first + (last - first) * held_share
        names, best = (
            ", ".join(
                f"{self.signals[k].name} = {in_file_units(self.signals[k], at[k])}" for k in moving
            )
            for at in (last, last_held)
        )
        lead = min(
            (self.signals[k].name for k in moving if self.signals[k].name in self.references),
            default=min(self.references),
        )
        if target is None:
            why = f"the plant has no rest at {names}"
        else:
            limit_texts = [
                f"{self.wanted[k].name} = {in_file_units(self.wanted[k], target[k])}, outside its "
                f"range {range_in_file_units(self.wanted[k])}"
                for k in self._outside(target)
            ]
            why = f"at {names} the plant rests with {'; '.join(limit_texts)}"
        raise ModelError(
            f"{lead}: {why}; on the way there {best} is the last that is held: narrow the range of "
            "the reference, or widen what it leaves"
        )


def _size(variable: Variable) -> float:
    return 1.0 if variable.range is None else float(variable.range.width) / 2
