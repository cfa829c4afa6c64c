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
from typing import Any, ClassVar

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kernel.reader import canonical, integer, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.expression import NAME, Scope, read_expression
from takagi.certificates.checker.plant.graph import FUNCTIONS
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import Enclosure, PlantClaim
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, Variable, rational
from takagi.certificates.checker.plant.sector_embedding import check_known, plant_loop
from takagi.certificates.checker.words.rounded import at_least, at_most

# Bounds that mean "positive" and "finite" for an effectiveness.
SMALLEST_EFFECTIVENESS, LARGEST_EFFECTIVENESS = Fraction(1, 10**40), Fraction(10**60)


@dataclass(frozen=True)
class Acting:
    """One actuator: ``sign`` is 1 for the high one, -1 for the low one.

    ``effectiveness`` is a node; ``error`` is the signal delta, None for an exact actuator.
    """

    name: str
    unit: str
    sign: int
    direction: int
    effectiveness: int
    idle: Fraction
    side: tuple[Fraction, Fraction] | None
    error: Variable | None


@dataclass(frozen=True)
class Blend:
    """All data of the blend; ``scope`` has the names that its equations may use."""

    effort: Variable
    rate: Variable
    share: Variable
    rest: Fraction
    ends: tuple[Fraction, Fraction]
    overlap: Fraction
    low: Acting
    high: Acting
    equations: list[str]
    scope: Scope

    @property
    def actuators(self) -> tuple[Acting, Acting]:
        return self.low, self.high


def secant(s: Fraction, rest: Fraction, overlap: Fraction) -> Fraction:
    """Return the secant slope of psi from ``rest`` to s; its derivative if they are equal."""
    if s != rest:
        return (psi(s, overlap) - psi(rest, overlap)) / (s - rest)
    return share(s, overlap)


def read_blend(model: Any, plant: PlantNodes, where: str) -> Blend:
    """Return the member ``blending`` of a model of kind ``plant``.

    Raises
    ------
    CertificateError : a part is missing or has a wrong form, a variable does not exist, the overlap
        is not positive, the effort has no range, or an actuator's name is already in use.
    """
    stated = member(model, "blending", where)
    where = f"{where}.blending"
    effort = _variable(stated, "effort", plant.states, where)
    rest = plant.graph.value(effort.rest)
    if rest is None or effort.side is None:
        raise CertificateError(f"{where}.effort: a rest that is a fraction and a range are needed")
    overlap = rational(member(stated, "overlap", where), plant.graph, f"{where}.overlap")
    if overlap <= 0:
        raise CertificateError(f"{where}.overlap: a positive number is needed")
    equations = member(stated, "equations", where)
    if not isinstance(equations, list) or len(equations) != len(plant.states) - 1:
        raise CertificateError(f"{where}.equations: one for each state but the effort is needed")
    rate = _variable(stated, "rate", plant.inputs, where)
    share = _variable(stated, "share", plant.disturbances, where)
    added = {effort.name, rate.name, share.name}
    for key in ("low", "high"):
        named = member(member(stated, key, where), "error", f"{where}.{key}")
        added |= {named} if isinstance(named, str) else set()
    # The blend adds these variables; the equations with two actuators must not use them.
    plant_names = {name: node for name, node in plant.scope.names.items() if name not in added}
    scope = Scope(plant_names, plant.scope.tables)
    low, high = (
        _acting(member(stated, key, where), plant, scope, sign, f"{where}.{key}")
        for key, sign in (("low", -1), ("high", 1))
    )
    used_names = {*plant.scope.names, *scope.tables, *FUNCTIONS, "pi"}
    if low.name == high.name or {low.name, high.name} & used_names:
        raise CertificateError(f"{where}: the actuators need names of their own")
    return Blend(
        effort=effort,
        rate=rate,
        share=share,
        rest=rest,
        ends=(rest + effort.side[0], rest + effort.side[1]),
        overlap=overlap,
        low=low,
        high=high,
        equations=equations,
        scope=scope,
    )


def _variable(owner: Any, key: str, variables: list[Variable], where: str) -> Variable:
    name = text(owner, key, where)
    for variable in variables:
        if variable.name == name:
            return variable
    raise CertificateError(f"{where}.{key}: {name[:60]!a} is none of the model's")


def _acting(actuator: Any, plant: PlantNodes, scope: Scope, sign: int, where: str) -> Acting:
    name = text(actuator, "input", where)
    if not NAME.fullmatch(name):
        raise CertificateError(f"{where}.input: {name[:60]!a} is no name")
    direction = integer(actuator, "direction", where)
    if direction not in (-1, 1):
        raise CertificateError(f"{where}.direction: 1 or -1 is needed")
    written = member(actuator, "effectiveness", where)
    ends = member(actuator, "range", where)
    side = None
    if ends is not None:
        if not isinstance(ends, list) or len(ends) != 2:
            raise CertificateError(f"{where}.range: two numbers are needed")
        low, high = (rational(end, plant.graph, f"{where}.range") for end in ends)
        side = low, high
    error = None
    if member(actuator, "error", where) is not None:
        error = _variable(actuator, "error", plant.disturbances, where)
    return Acting(
        name,
        text(actuator, "unit", where),
        sign,
        direction,
        read_expression(written, plant.graph, scope, f"{where}.effectiveness"),
        rational(member(actuator, "idle", where), plant.graph, f"{where}.idle"),
        side,
        error,
    )


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
    names = dict(blend.scope.names)
    for acting in blend.actuators:
        commanded = _command(plant, blend, acting)
        if acting.error is not None:
            rest = plant.at_rest(commanded)
            wrong = g.add(g.constant(1), g.variable(acting.error.symbol))
            commanded = g.add(rest, g.multiply(wrong, g.subtract(commanded, rest)))
        names[acting.name] = commanded
    scope, written = Scope(names, blend.scope.tables), iter(blend.equations)
    for i, (state, row) in enumerate(zip(plant.states, plant.f, strict=True)):
        if state is blend.effort:
            if not algebra.equal(row, plant.value_of(blend.rate)):
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
    share = plant.value_of(blend.share)
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
