"""A blend at run time, in floating point: share, commands, and the plant with its two actuators."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.blending.blending import SHARE, Actuator, Blending
from takagi.models.errors import ModelError
from takagi.models.ramps import effort_ramp

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable


@dataclass(frozen=True, eq=False)
class RunTimeBlending:
    """Evaluates ``blending`` at states of the blended plant: those of the plant, then the effort.

    Attributes
    ----------
    errors : actuator -> delta: its motion from rest moves the plant 1 + delta times as much. The
        default is 0. Values outside the range of a proof are allowed.

    Raises
    ------
    ModelError : a name that is no blended actuator.
    """

    blending: Blending
    errors: Mapping[str, float] | None = None

    def __post_init__(self) -> None:
        names = [a.name for a in self.blending.actuators]
        for name in self.errors or {}:
            if name not in names:
                raise ModelError(
                    f"error of {name}: the blended actuators are {' and '.join(names)}"
                )

    def share(self, effort: float) -> float:
        """Return F(U) of the high actuator, the slope of the secant of psi from rest."""
        e, rest = float(self.blending.overlap), float(self.blending.effort.rest)
        if effort == rest:
            return float(self.blending.share_at_rest)
        # psi in two parts, each a function of differences that are exact in floating point: the
        # difference of psi itself has no digits left near rest.
        here, there = (min(max(s, -e), e) for s in (effort, rest))
        curved = (here - there) * (here + there + 2 * e) / (4 * e)
        return (curved + (max(effort, e) - max(rest, e))) / (effort - rest)

    def signals(self, state: Floats) -> dict[str, float]:
        """Return the signals that the law knows at a state (n,): the share's deviation, by name.

        The name is that of the model's variable: the deviation from the share at the equilibrium.
        """
        at_rest = float(self.blending.share_at_rest)
        name = f"delta_{SHARE}" if self.blending.share_at_rest else SHARE
        return {name: self.share(float(state[-1])) - at_rest}

    def commands(self, state: Floats) -> Floats:
        """Return the commands (low, high) of the actuators at a state (n,), in SI."""
        commands = []
        for actuator, b in zip(self.blending.actuators, self._effectiveness, strict=True):
            sign = self.blending.sign(actuator)
            psi = float(effort_ramp(sign * state[-1], float(self.blending.overlap)))
            step = sign * actuator.direction * psi / b(*map(float, state[:-1]))
            commands.append(float(actuator.variable.rest) + step)
        return np.array(commands)

    def sent(self, state: Floats) -> Floats:
        """Return the commands (low, high), held within the ranges of the actuators."""
        sides = [a.variable.range for a in self.blending.actuators]
        low = [-np.inf if side is None else float(side.lower) for side in sides]
        high = [np.inf if side is None else float(side.upper) for side in sides]
        return np.clip(self.commands(state), low, high)

    def moved(self, commands: Floats) -> Floats:
        """Return the actual positions (low, high) for their commands, with ``errors``."""
        rest = self.at_rest
        wrong = [(self.errors or {}).get(a.name, 0.0) for a in self.blending.actuators]
        return np.asarray(rest + (1 + np.array(wrong)) * (commands - rest))

    def disturbed_rate(
        self, moving: Sequence[Variable], *, told: bool = False
    ) -> Callable[[Floats, Floats, Floats], Floats]:
        """Return (x, u, w) -> x' of the plant as it was written, moved by its two actuators.

        u has the plant's other inputs, then the rate of the effort; w has the disturbances in
        ``moving``, in its order.  Other signals have their rest values, and commands are held
        within the ranges of the actuators.

        Parameters
        ----------
        told : whether u ends with the commands (low, high), as a program sends and holds them, and
            they do not follow from the state.
        """
        plant = self.blending.plant
        free = [v.symbol for v in moving]
        values = {s: value for s, value in self._values().items() if s not in free}
        inputs = [v.symbol for v in plant.inputs]
        blended = {a.variable.symbol: k for k, a in enumerate(self.blending.actuators)}
        right_sides = explicit_rows(
            plant, [*(v.symbol for v in plant.states), *inputs, *free], values
        )

        def slope(x: Floats, u: Floats, w: Floats) -> Floats:
            if told:
                u, sent = u[:-2], np.asarray(u[-2:], dtype=np.float64)
            else:
                sent = self.sent(x)
            acting, other_inputs = self.moved(sent), iter(u[:-1])
            inputs_acting = [
                float(acting[blended[s]] if s in blended else next(other_inputs)) for s in inputs
            ]
            return np.append(
                right_sides(*map(float, x[:-1]), *inputs_acting, *map(float, w)), float(u[-1])
            )

        return slope

    def _values(self) -> dict[sp.Symbol, sp.Expr]:
        import sympy as sp

        plant = self.blending.plant
        values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
        rests = {v.symbol: sp.Rational(*v.rest.as_integer_ratio()) for v in plant.disturbances}
        return values | rests

    @cached_property
    def _effectiveness(self) -> tuple[Callable[..., float], ...]:
        return tuple(self._compiled(a) for a in self.blending.actuators)

    def _compiled(self, actuator: Actuator) -> Callable[..., float]:
        import sympy as sp

        symbols = [v.symbol for v in self.blending.plant.states]
        b = sp.sympify(actuator.effectiveness).subs(self._values())
        function: Callable[..., float] = sp.lambdify(symbols, b, modules=["scipy", "numpy"])
        return function

    @cached_property
    def at_rest(self) -> Floats:
        """The commands (low, high) at the equilibrium."""
        return np.array([float(self.blending.at_rest(a)) for a in self.blending.actuators])


def explicit_rows(
    plant: Plant, symbols: Sequence[sp.Symbol], values: Mapping[sp.Symbol, sp.Expr]
) -> Callable[..., Floats]:
    """Return f of the plant's equations, or M^-1 f, as a function of the symbols in floats."""
    import sympy as sp

    rows = [sp.sympify(row).subs(values) for row in plant.equations]
    right_sides = sp.lambdify(symbols, rows, modules=["scipy", "numpy"])
    if plant.mass is None:
        return lambda *point: np.array(right_sides(*point), dtype=np.float64)
    mass = sp.lambdify(symbols, plant.mass.subs(values).tolist(), modules=["scipy", "numpy"])

    def solved(*point: float) -> Floats:
        f = np.array(right_sides(*point), dtype=np.float64)
        return np.asarray(np.linalg.solve(np.array(mass(*point), float), f), dtype=np.float64)

    return solved
