"""Two actuators that share one effort, as a value: where each one acts, and its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ramps import ramp, ramp_slope, share_range

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

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


@dataclass(frozen=True, slots=True, eq=False)
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

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Blending) and self._parts() == other._parts()

    def __hash__(self) -> int:
        return hash((self.effort, self.overlap))

    def _parts(self) -> tuple[object, ...]:
        return (self.effort, self.rate, self.overlap, self.low, self.high, self.plant)

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

        values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in self.plant.values.items()}
        return sp.sympify(actuator.effectiveness).subs(values)

    def at_rest(self, actuator: Actuator) -> Fraction:
        """Return the actuator's command where the plant rests, exactly.

        Raises
        ------
        ModelError : the effectiveness there is not a rational number.
        """
        delivered = self.delivered(actuator, self.effort.rest)
        if delivered == 0:
            return actuator.variable.rest
        b = self.effectiveness(actuator).subs(_rests(self.plant))
        if not b.is_Rational or b == 0:
            raise ModelError(
                f"blending: at rest the effectiveness of {actuator.name} is {b}, no number other "
                "than 0 that is a fraction; write it so that it is one there (see docs/plants.md), "
                f"or rest the effort where {actuator.name} idles"
            )
        step = delivered / Fraction(int(b.p), int(b.q))
        return actuator.variable.rest + self.sign(actuator) * actuator.direction * step


def blending_of(plant: Plant) -> Blending | None:
    """Return the blending from which a plant was made; None for other plants."""
    blending = plant.blending
    assert blending is None or isinstance(blending, Blending)  # set by ``blended_plant`` alone
    return blending


def unit_text(unit: str) -> str:
    """Return a unit as text to be written behind a number."""
    return "" if unit == "-" else f" {unit}"


def _rests(plant: Plant) -> Mapping[sp.Symbol, sp.Rational]:
    import sympy as sp

    return {v.symbol: sp.Rational(*v.rest.as_integer_ratio()) for v in plant.variables}


def _check(blending: Blending) -> None:
    e, effort = blending.overlap, blending.effort
    if e <= 0:
        why = (
            f"between {float(e):g} and {float(-e):g} no actuator would act: a hole"
            if e < 0
            else "the share of the actuators would jump at the effort 0"
        )
        raise ModelError(
            f"overlap: {float(e):g}{unit_text(effort.unit)} was given, so that {why}; "
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
            f"{float(actuator.variable.rest):g}{unit_text(actuator.variable.unit)}, which is the "
            "end of its range: beyond the hand-over no actuator acts; correct the direction, the "
            "rest or the range"
        )
