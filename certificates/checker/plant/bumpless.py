r"""``bumpless`` of a plant with two actuators behind one effort: no jump, and bounds of the rates.

An actuator is told v = idle +- psi(s U)/b, with s = 1 for the high one and -1 for the low one
(``effort_blend``, which proves b > 0 on the box).  psi has a continuous slope, and b is continuous:
v is a continuous function of the state, and its largest jump is 0.  Its rate is

    |v'| = |psi'(s U) U' / b +- psi(s U) (1/b)'|,      (1/b)' = sum_i d(1/b)/dx_i f_i(x, u, w)

which is enclosed on the whole box: for every share and every error of an actuator, for U' in its
range, and for psi' and psi between 0 and their largest values over the effort's range.  b depends
on no signal, whose rate nothing bounds.

It is assumed that the state, the signals and the rate of the effort are in the box: along a motion
from an invariant set they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kernel.reader import number
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.derivative import derivative
from takagi.certificates.checker.plant.effort_blend import Acting, EffortBlend
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import Enclosure
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_most


@dataclass(frozen=True)
class PlantBumpless(EffortBlend):
    """Neither actuator's command jumps, and bounds of their rates, ``low`` and ``high``."""

    def obligations(self) -> Obligations:
        plant, blend, g = self.plant, self.blend, self.plant.graph
        evaluator = plant.evaluator
        ranges = Ranges(evaluator, Algebra(g, plant.tables), plant.box)
        for acting in blend.actuators:
            most, parts = max(acting.sign * end for end in blend.ends), []
            for function in (share, psi):
                # With a space it is no name of the plant's.
                name = f"{function.__name__} of {acting.name}"
                side = Fraction(0), function(most, blend.overlap)
                ranges.box[name] = evaluator.add_side(name, side)
                parts.append(g.variable(name))
            by_effort = g.divide(plant.value_of(blend.rate), acting.effectiveness)
            by_state = self._inverse(acting)
            command_rate = g.add(g.multiply(parts[0], by_effort), g.multiply(parts[1], by_state))
            bound = self._rate(acting)
            yield Enclosure(ranges, command_rate, -bound, bound, f"the rate of {acting.name}")

    def _inverse(self, acting: Acting) -> int:
        """Return the node of (1/b)'; its sign does not matter, because that of U' does not."""
        plant, g = self.plant, self.plant.graph
        variables = g.variables(acting.effectiveness)
        states = {state.symbol for state in plant.states}
        if signals := [v.name for v in plant.variables if v.symbol in variables - states]:
            raise Refused(f"{acting.name} is told by {', '.join(signals)}, whose rate has no bound")
        if variables & states and plant.mass is not None:
            raise Refused(f"{acting.name} is told by states whose rates a mass matrix couples")
        inverse = g.divide(g.constant(1), acting.effectiveness)
        return g.total(
            g.multiply(derivative(g, inverse, state.symbol), f)
            for state, f in zip(plant.states, plant.f, strict=True)
            if state.symbol in variables
        )

    def _rate(self, acting: Acting) -> Fraction:
        return number(self.claim, "high" if acting.sign > 0 else "low", self.where)

    def figures(self) -> Iterator[Figure | WindProfile]:
        for acting in self.blend.actuators:
            unit, rate = _per_second(acting), self._rate(acting)
            yield Figure(f"largest jump of {acting.name}", acting.unit, Fraction(0), larger=False)
            yield Figure(f"largest rate of {acting.name}", unit, rate, larger=False)

    def sentence(self) -> str:
        rates = (
            f"{acting.name} {at_most(self._rate(acting), 6)} {_per_second(acting)}"
            for acting in self.blend.actuators
        )
        return (
            "where the state, the signals and the rate of the effort are in the box, neither "
            f"actuator is told to jump, and each is told to move at most at: {', '.join(rates)}; "
            "standard library alone"
        )


def _per_second(acting: Acting) -> str:
    return "1/s" if acting.unit == "-" else f"{acting.unit} per s"
