"""Two actuators that share one effort, as a value and at run time.

A blend at run time, in floating point: share, commands, and the plant with its two actuators.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.files.units import behind
from takagi.models.intervals.interval import Interval, rational
from takagi.models.plant.plant import explicit_rows
from takagi.models.ramps import effort_ramp, ramp, ramp_slope, share_range

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant, Variable


# Names that the blended plant adds to those of the file.
EFFORT, RATE, SHARE = "effort", "effort_rate", "share"


@dataclass(frozen=True, slots=True)
class Actuator:
    """One of the two actuators.

    Attributes
    ----------
    variable : the input of the plant: its rest is where it idles while the other one acts, its
        range the limits of its commands.
    direction : 1 if raising the input raises the effort, -1 if it lowers it.
    effectiveness : b > 0, effort per unit of the input, in states, signals and parameters.
    error : delta_max in [0, 1): the input's motion from rest moves the plant 1 + delta times as
        much as commanded, |delta| <= delta_max, in any way over time.
    """

    variable: Variable
    direction: int
    effectiveness: sp.Expr
    error: Fraction = Fraction(0)

    @property
    def name(self) -> str:
        return self.variable.name

    @property
    def error_name(self) -> str:
        """The signal delta of the blended plant."""
        return f"{self.name}_error"


@dataclass(frozen=True, slots=True)
class Blending:
    """One effort U for two actuators, psi the ramp of ``ramps.effort_ramp``, e its overlap:

        low    u = idle - direction psi(-U) / b        acts where U < e
        high   u = idle + direction psi(U) / b         acts where U > -e

    Attributes
    ----------
    effort : U, with its range and where it rests, SI.
    rate : U', which the law commands.
    overlap : e > 0, in the unit of the effort.
    plant : as it was written, with the two actuators among its inputs.

    Raises
    ------
    ModelError : an overlap that is not positive, an effort without a range on both sides of 0, one
        input for both, an error that is not a share, an actuator that does not move the plant.
    """

    effort: Variable
    rate: Variable
    overlap: Fraction
    low: Actuator
    high: Actuator
    plant: Plant

    def __post_init__(self) -> None:
        _check(self)

    @property
    def actuators(self) -> tuple[Actuator, Actuator]:
        """Return (low, high)."""
        return self.low, self.high

    @property
    def efforts(self) -> Interval:
        """The range of the effort."""
        assert self.effort.range is not None  # checked when it was made
        return self.effort.range

    @property
    def share(self) -> Interval:
        """The range of the secant share F of the high actuator."""
        return share_range(self.efforts, self.effort.rest, self.overlap)

    @property
    def share_at_rest(self) -> Fraction:
        """psi' at the rest of the effort."""
        return ramp_slope(self.effort.rest, self.overlap)

    def sign(self, actuator: Actuator) -> int:
        """Return 1 for the high actuator, -1 for the low one."""
        return 1 if actuator is self.high else -1

    def delivered(self, actuator: Actuator, effort: Fraction) -> Fraction:
        """Return psi(U) of the high actuator, psi(-U) of the low one, exactly."""
        return ramp(self.sign(actuator) * effort, self.overlap)

    def most(self, actuator: Actuator) -> Fraction:
        """Return the most effort that is asked of an actuator over the range of the effort."""
        ends = (self.efforts.lower, self.efforts.upper)
        return max(self.delivered(actuator, end) for end in ends)

    def room(self, actuator: Actuator) -> Fraction | None:
        """Return the distance from idle to the actuator's limit; None without limits."""
        side = actuator.variable.range
        if side is None:
            return None
        upward = actuator.direction * self.sign(actuator) > 0
        rest = actuator.variable.rest
        return side.upper - rest if upward else rest - side.lower

    def effectiveness(self, actuator: Actuator) -> sp.Expr:
        """Return b with the values of the parameters, exactly."""
        import sympy as sp

        return sp.sympify(actuator.effectiveness).subs(self.plant.rationals)

    def at_rest(self, actuator: Actuator) -> Fraction:
        """Return the actuator's command where the plant rests, exactly.

        Raises
        ------
        ModelError : the effectiveness there is not a rational number.
        """
        delivered = self.delivered(actuator, self.effort.rest)
        if delivered == 0:
            return actuator.variable.rest
        b = self.effectiveness(actuator).subs(self.plant.at_rest)
        if not b.is_Rational or b == 0:
            raise ModelError(
                f"blending: at rest the effectiveness of {actuator.name} is {b}, no number other "
                "than 0 that is a fraction; write it so that it is one there, or "
                f"rest the effort where {actuator.name} idles"
            )
        step = delivered / Fraction(int(b.p), int(b.q))
        return actuator.variable.rest + self.sign(actuator) * actuator.direction * step


def blending_of(plant: Plant) -> Blending | None:
    """Return the blending from which a plant was made; None for other plants."""
    blending = plant.blending
    assert blending is None or isinstance(blending, Blending)  # set by ``blended_plant`` alone
    return blending


def _check(blending: Blending) -> None:
    e, effort = blending.overlap, blending.effort
    if e <= 0:
        why = (
            f"between {float(e):g} and {float(-e):g} no actuator would act: a hole"
            if e < 0
            else "the share of the actuators would jump at the effort 0"
        )
        raise ModelError(
            f"overlap: {float(e):g}{behind(effort.unit)} was given, so that {why}; "
            "give a positive one"
        )
    if effort.range is None or not effort.range.lower < 0 < effort.range.upper:
        range_text = "no range" if effort.range is None else f"the range {effort.range}"
        raise ModelError(
            f"effort: {range_text} was given; below 0 the low actuator acts, above 0 the high one: "
            "give range = [low, high] with 0 inside, or write the plant with one input"
        )
    if blending.low.name == blending.high.name:
        raise ModelError(
            f"high: {blending.high.name} is the low actuator already; two inputs are needed"
        )
    for end, actuator in (("low", blending.low), ("high", blending.high)):
        if actuator.direction not in (-1, 1):
            raise ModelError(
                f"{end}.direction: {actuator.direction} was given; 1 if raising {actuator.name} "
                "raises the effort, -1 if it lowers it"
            )
        if not 0 <= actuator.error < 1:
            raise ModelError(
                f"{end}.error: {float(actuator.error):g} was given; a share from 0 up to but not "
                "1 is needed: with 1 the actuator might not act at all"
            )
        _check_acts(blending, end, actuator)


def _check_acts(blending: Blending, end: str, actuator: Actuator) -> None:
    plant = blending.plant
    symbol = actuator.variable.symbol
    if not any(row.has(symbol) for row in plant.equations):
        raise ModelError(
            f"{end}.input: no equation contains {actuator.name}: where it should act, nothing "
            "does; write what it does into an equation, or name the input that does it"
        )
    if (plant.mass is not None and plant.mass.has(symbol)) or any(
        y.expression.has(symbol) for y in plant.outputs
    ):
        raise ModelError(
            f"{end}.input: {actuator.name} stands in the mass matrix or an output; a blended "
            "actuator may stand in equations only"
        )
    symbols = {v.symbol for v in (*plant.states, *plant.disturbances)} | set(plant.values)
    strange = sorted(str(s) for s in actuator.effectiveness.free_symbols - symbols)
    if strange:
        raise ModelError(
            f"{end}.effectiveness: {', '.join(strange)} stands in it; states, signals and "
            "parameters may"
        )
    room = blending.room(actuator)
    if room is not None and room <= 0:
        direction = "up" if actuator.direction * blending.sign(actuator) > 0 else "down"
        raise ModelError(
            f"{end}.input: {actuator.name} acts by going {direction} from its rest, "
            f"{float(actuator.variable.rest):g}{behind(actuator.variable.unit)}, which is the "
            "end of its range: beyond the hand-over no actuator acts; correct the direction, the "
            "rest or the range"
        )


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

        ``told`` : whether u ends with the commands (low, high), as a program sends and holds them,
        and they do not follow from the state.
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
        plant = self.blending.plant
        return plant.rationals | {v.symbol: rational(v.rest) for v in plant.disturbances}

    @cached_property
    def _effectiveness(self) -> tuple[Callable[..., float], ...]:
        return tuple(self._compiled(a) for a in self.blending.actuators)

    def _compiled(self, actuator: Actuator) -> Callable[..., float]:
        import sympy as sp

        from takagi.models.ranges.float_value import float_function

        symbols = [v.symbol for v in self.blending.plant.states]
        b = sp.sympify(actuator.effectiveness).subs(self._values())
        return float_function(symbols, b)

    @cached_property
    def at_rest(self) -> Floats:
        """The commands (low, high) at the equilibrium."""
        return np.array([float(self.blending.at_rest(a)) for a in self.blending.actuators])
