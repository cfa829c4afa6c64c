r"""Claims of kind ``effort-blend``: the blended plant equals the plant with two actuators.

The model of the certificate has one effort U as a state, U' as an input, and signals: the share F
and, where stated, errors delta.  Its member ``blending`` has the equations with two actuators.
Let psi(s) be 0 for s <= -e, (s + e)^2 / 4e between -e and e, and s for s >= e.  The law commands

    low    v = idle - direction psi(-U) / b          b the effectiveness, overlap e > 0
    high   v = idle + direction psi(U) / b

and an actuator with an error is at v* + (1 + delta)(v - v*), where v* is its command at rest.  The
checker proves:

1. psi(U) = psi(U*) + F (U - U*) and psi(-U) = psi(-U*) - (1 - F)(U - U*), with F the slope of the
   secant of psi from the rest U*.  psi is convex, so F does not decrease with U: over the range of
   U it lies between its values at the ends, and these lie in the range of the signal ``share``.
2. b > 0 on the box, and psi_max / b is at most the room from the actuator's idle position to its
   limit.  psi increases with U, so that b >= psi_max / room on the box is enough for every U.
   The law divides by b: it depends on no signal that the law does not know.
3. The equations with both actuators' positions inserted are those of the model, as functions, where
   the state lies in the box; U' is the input.  Share and errors are in A and B only, and their
   columns of E are 0: a claim without disturbance holds however they change.
4. A law with gains K_i depends only on signals that it knows: rules that differ only in premises
   with an actuator error have equal gains.  The law knows F, which follows from its own state U.

Source: derived here; the ramp is that of the effort-sharing law of a wind turbine.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import ClassVar

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kernel.reader import canonical, member
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.blend import Acting, Blend, read_blend, secant
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.known_signals import check_known
from takagi.certificates.checker.plant.plant_claim import Enclosure, PlantClaim
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.checker.words.rounded import at_least, at_most

# Bounds that mean "positive" and "finite" for an effectiveness.
SMALLEST_EFFECTIVENESS, LARGEST_EFFECTIVENESS = Fraction(1, 10**40), Fraction(10**60)


@dataclass(frozen=True)
class EffortBlend(PlantClaim):
    """The plant with its two actuators is the model's plant; see the module."""

    form: ClassVar[str] = "sector"

    @cached_property
    def blend(self) -> Blend:
        """The blend of model and law.

        Raises
        ------
        CertificateError : the model has no blend, or the law has another.
        """
        blend = read_blend(self.model, self.plant, "model")
        if self.gains is not None:
            emitted = member(self.gains, "blending", "gains")
            if canonical(emitted) != canonical(self.model["blending"]):
                raise CertificateError(
                    "gains.blending is not the model's: the law has another blend"
                )
        return blend

    @property
    def share(self) -> tuple[Fraction, Fraction]:
        """The least and the largest share F."""
        ends, rest, overlap = self.blend.ends, self.blend.rest, self.blend.overlap
        return secant(ends[0], rest, overlap), secant(ends[1], rest, overlap)

    def obligations(self) -> Obligations:
        plant, blend = self.plant, self.blend
        algebra = Algebra(plant.graph, plant.tables)
        ranges = Ranges(plant.evaluator, algebra, plant.box)
        _check_share(plant, blend, *self.share)
        _check_schedules(plant, blend)
        for acting in blend.actuators:
            yield _acts(plant, ranges, blend, acting)
        _check_equations(plant, blend, algebra, ranges)
        if self.gains is not None:
            errors = {acting.error.symbol for acting in blend.actuators if acting.error is not None}
            unknown_signal = "an error of an actuator"
            check_known(plant, plant_loop(self.model), errors, self.gains, unknown_signal)

    def sentence(self) -> str:
        blend, (low, high) = self.blend, self.share
        unit = "" if blend.effort.unit == "-" else f" {blend.effort.unit}"
        ends = f"[{at_most(blend.ends[0], 9)}, {at_least(blend.ends[1], 9)}]"
        clauses = [
            f"where the effort is in {ends}{unit} and the state in the box, {blend.high.name} has "
            f"a share between {at_least(low, 6)} and {at_most(high, 6)} of its motion from rest "
            f"and {blend.low.name} the rest",
            *filter(None, map(_actuator_in_words, blend.actuators)),
        ]
        if self.gains is not None:
            clauses.append("the law knows all that its gains depend on")
        return "; ".join([*clauses, "standard library alone"])


def _actuator_in_words(acting: Acting) -> str:
    """Return the range that an actuator keeps and the error that it may have; empty for neither."""
    limits = error = ""
    if acting.side is not None:
        limits = f" keeps [{at_least(acting.side[0], 9)}, {at_most(acting.side[1], 9)}]"
        limits += "" if acting.unit == "-" else f" {acting.unit}"
    if acting.error is not None and acting.error.side is not None:
        down, up = acting.error.side
        # An assumption, as the box is: rounded inward, so that the sentence claims no more.
        error = f" moves the plant {at_most(1 + down, 6)} to {at_least(1 + up, 6)} times as "
        error += "much as told from its position at rest"
    if not limits and not error:
        return ""
    return f"{acting.name}{limits}{' and' * bool(limits and error)}{error}"


def _check_share(plant: PlantNodes, blend: Blend, low: Fraction, high: Fraction) -> None:
    rest, side = plant.graph.value(blend.share.rest), blend.share.side
    if rest is None or side is None:
        raise Refused("the share has no range")
    if not (rest + side[0] <= low and high <= rest + side[1]):
        raise Refused(
            f"the share takes values from {at_most(low, 9)} to {at_least(high, 9)}, not only those "
            "of its range"
        )
    for acting in blend.actuators:
        if acting.error is None:
            continue
        if plant.graph.value(acting.error.rest) != 0 or acting.error.side is None:
            raise Refused(f"the error of {acting.name} needs a range about 0")
        if acting.error.side[0] <= -1:
            raise Refused(f"with its error {acting.name} may not act at all")
        if acting.error.name == blend.share.name:
            raise Refused(f"the error of {acting.name} is the share")
    first, second = (acting.error for acting in blend.actuators)
    if first is not None and second is not None and first.name == second.name:
        raise Refused("the errors of both actuators are one signal")


def _check_schedules(plant: PlantNodes, blend: Blend) -> None:
    """Refuse share or error with a column of E that is not 0: it would act as a disturbance."""
    signals = [blend.share, *(a.error for a in blend.actuators if a.error is not None)]
    for signal in signals:
        column = plant.disturbances.index(signal)
        if any(plant.graph.value(row[column]) != 0 for row in plant.entries.get("E", [])):
            raise Refused(f"{signal.name} moves the state as a disturbance does, not in A or B")


def _acts(plant: PlantNodes, ranges: Ranges, blend: Blend, acting: Acting) -> Enclosure:
    """Return the obligation b > 0 on the box; b >= psi_max / room if the actuator has limits."""
    hidden = {v.symbol for v in plant.disturbances if v.unknown}
    if hidden & plant.graph.variables(acting.effectiveness):
        raise Refused(f"the law commands {acting.name} by what it does not know")
    smallest = SMALLEST_EFFECTIVENESS
    if acting.side is not None:
        upward = acting.sign * acting.direction > 0
        room = acting.side[1] - acting.idle if upward else acting.idle - acting.side[0]
        if not acting.side[0] <= acting.idle <= acting.side[1] or room <= 0:
            raise Refused(f"{acting.name} has no room to act from where it idles")
        largest = max(psi(acting.sign * end, blend.overlap) for end in blend.ends)
        smallest = max(SMALLEST_EFFECTIVENESS, largest / room)
    subject = (
        f"the effectiveness of {acting.name}, which has to be at least {at_most(smallest, 6)},"
    )
    return Enclosure(ranges, acting.effectiveness, smallest, LARGEST_EFFECTIVENESS, subject)


def _check_equations(plant: PlantNodes, blend: Blend, algebra: Algebra, ranges: Ranges) -> None:
    g = plant.graph
    names = dict(blend.names)
    origin = {v.symbol: g.constant(0) for v in (*plant.states, *plant.inputs, *plant.disturbances)}
    for acting in blend.actuators:
        commanded = _command(plant, blend, acting)
        if acting.error is not None:
            rest = substituted(g, commanded, origin)
            wrong = g.add(g.constant(1), g.variable(acting.error.symbol))
            commanded = g.add(rest, g.multiply(wrong, g.subtract(commanded, rest)))
        names[acting.name] = commanded
    scope, written = Scope(names, blend.tables), iter(blend.equations)
    for i, (state, row) in enumerate(zip(plant.states, plant.f, strict=True)):
        if state is blend.effort:
            rate = g.add(blend.rate.rest, g.variable(blend.rate.symbol))
            if not algebra.equal(row, rate):
                raise Refused("the effort does not move by its rate")
            _check_own_row(plant, i)
            continue
        subject = f"the equation of {state.name} with both actuators"
        node = read_expression(next(written), g, scope, subject)
        ranges.prove_continuous(node, subject)
        if not algebra.equal(node, row):
            raise Refused(f"{subject} is not shown to be the model's")


def _command(plant: PlantNodes, blend: Blend, acting: Acting) -> int:
    """Return v of the law, with psi expressed by the share F."""
    g = plant.graph
    share = g.add(blend.share.rest, g.variable(blend.share.symbol))
    if acting.sign < 0:
        share = g.subtract(share, g.constant(1))
    resting = g.constant(psi(acting.sign * blend.rest, blend.overlap))
    delivered = g.add(resting, g.multiply(share, g.variable(blend.effort.symbol)))
    step = g.divide(delivered, acting.effectiveness)
    return g.add(
        g.constant(acting.idle), g.multiply(g.constant(acting.sign * acting.direction), step)
    )


def _check_own_row(plant: PlantNodes, effort_row: int) -> None:
    """Refuse discrete time, and a mass matrix that couples the effort with other states."""
    if plant.sample_time is not None:
        raise Refused("an effort with a rate is of continuous time")
    for i, row in enumerate(plant.mass or []):
        for j, node in enumerate(row):
            if effort_row in (i, j) and plant.graph.value(node) != int(i == j):
                raise Refused("the mass matrix has a part in the effort")
