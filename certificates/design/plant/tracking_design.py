"""The design of a law that follows references, within narrower ranges of states where they help.

A set that stays in narrower ranges of states stays in the wider ones of the file, so that the claim
holds for the file's plant.  Slopes that vary less allow a larger set: a series motor, whose torque
is K i^2, may jump 12 times as far if the current stays in [2, 9] A in place of [0.5, 12] A.
Where outputs follow no reference, ``_obstacle`` says which ranges to narrow by how much.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.certificates.design.design import NoDesign, StepClock
from takagi.certificates.design.plant.gain_task import FoundGains, GainTask
from takagi.certificates.design.plant.plain_words import in_plant_words, require_sensible
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.design.plant.tracking_gains import require_measured, tracking_gains
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.plant.plant import range_in_file_units
from takagi.models.tracking import held_rests, signals_of

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.plant.plant import Plant, Variable


# Shares of the ranges of states that are tried for a set in which outputs follow references, what
# they have to gain in jumps, and the share of a reference's range that is jump enough.
NARROWER = (Fraction(1, 2), Fraction(1, 4))
LEAST_INCREASE, ENOUGH_JUMP = 1.5, 0.5


def design_tracking(task: GainTask, clock: StepClock) -> tuple[GainTask, FoundGains] | NoDesign:
    """Return gains with integral action and what they hold on; or why none and what would help.

    What they hold on is the task, with narrower ranges of the plant where they help.
    """
    plant = task.plant
    require_sensible(plant, task.model, task.settings)
    if plant.hides_states:
        require_measured(plant, task.model)
    with clock("gains"), in_plant_words(plant):
        gains = tracking_gains(task)
        best = task, gains
        if claims_alone(plant):  # all claims say that states stay in their ranges
            best = _within_narrower_ranges(task, gains)
    if best[1].jump > 0:
        return best
    with clock("what would help"):
        return NoDesign(_obstacle(task, gains.design))


def claims_alone(plant: Plant) -> bool:
    """Return whether a plant's claims are those about its references alone."""
    return bool(plant.references) and (plant.hides_states or not plant.rests_exactly)


def _within_narrower_ranges(task: GainTask, gains: FoundGains) -> tuple[GainTask, FoundGains]:
    """Return gains and set within narrower ranges of states, where they allow larger jumps."""
    plant, best = task.plant, (task, gains)
    states = [v for v in moving_slopes(plant) if v in plant.states]
    for share in NARROWER if states else ():
        if best[1].jump >= ENOUGH_JUMP:
            break
        ranges = narrowed(plant, states, share)
        try:
            narrow = _narrow_task(task, ranges)
            narrower = tracking_gains(narrow)
        except ModelError:
            # The rests leave no room in these ranges.
            break
        if narrower.jump > LEAST_INCREASE * best[1].jump:
            note = (
                "states are proved to stay in narrower ranges, where slopes vary less: "
                f"{', '.join(map(range_in_words, ranges.values()))}"
            )
            best = narrow, replace(narrower, notes=(note, *narrower.notes))
    return best


def _narrow_task(task: GainTask, ranges: dict[str, Variable]) -> GainTask:
    """Return the task within other ranges.

    Raises
    ------
    ModelError : the rests leave no room in them.
    """
    narrow = with_ranges(task.plant, ranges)
    return GainTask.of(narrow, secant_model(narrow, rest=task.settings.rest), task.settings)


def moving_slopes(plant: Plant) -> list[Variable]:
    """Return the states and inputs with a range on which slopes of the equations depend."""
    import sympy as sp

    rows = sp.Matrix([sp.sympify(row) for row in plant.equations])
    variables = [*plant.states, *plant.inputs]
    slopes = rows.jacobian([v.symbol for v in variables])
    return [v for v in variables if v.range is not None and v.symbol in slopes.free_symbols]


def with_ranges(plant: Plant, replaced: dict[str, Variable]) -> Plant:
    """Return the plant with these variables in the place of those of the same name."""
    return replace(
        plant,
        states=tuple(replaced.get(v.name, v) for v in plant.states),
        inputs=tuple(replaced.get(v.name, v) for v in plant.inputs),
        disturbances=tuple(replaced.get(v.name, v) for v in plant.disturbances),
    )


def narrowed(plant: Plant, group: Sequence[Variable], share: Fraction) -> dict[str, Variable]:
    """Return the variables with this share of the distance from where they rest to each end."""
    states = [plant.states[k] for k in plant.own_states]
    values = held_rests(plant).values
    rests = {
        v.name: (Fraction(float(low)), Fraction(float(high)))
        for v, low, high in zip(
            (*states, *plant.inputs), values.min(axis=0), values.max(axis=0), strict=True
        )
    }
    narrower = {}
    for v in group:
        assert v.range is not None  # such variables are narrowed
        low, high = rests.get(v.name, (v.rest, v.rest))
        ends = (low + share * (v.range.lower - low), high + share * (v.range.upper - high))
        narrower[v.name] = replace(v, range=Interval(*(Fraction(f"{float(e):.6g}") for e in ends)))
    return narrower


def range_in_words(variable: Variable) -> str:
    """Return "w in [35, 130] rad/s", in the units of the file."""
    return f"{variable.name} in {range_in_file_units(variable)}"


# What is left of a range's distance from rest: the first decides whether wider ones are tried.
RANGE_SHARES = (Fraction(1, 10), Fraction(1, 2), Fraction(1, 4))


def _obstacle(task: GainTask, design: Design) -> str:
    """Return that no set was found, and which narrower ranges have one, each by itself."""
    words = "no set was found in which outputs follow their references within the ranges"
    if not design.found:
        words = "no gain was found with which all slopes of the plant in its ranges settle"
        if design.answer.diagnosis:
            words += f" ({design.answer.diagnosis})"
    sentences = [*filter(None, (_widest(task, group) for group in _groups(task.plant)))]
    if sentences:
        return f"{words}. A set is found with {'; or with '.join(sentences)}. Change one of these"
    return (
        f"{words}, nor with all references, disturbances and ranges at a tenth of their distances "
        "from rest, one after the other. Move the rest to where the slopes of the equations are "
        "away from 0, or ask for less (decay_rate, input_limit)"
    )


def _groups(plant: Plant) -> Iterator[list[Variable]]:
    """Yield what is narrowed together: each signal, all, and what the slopes depend on likewise."""
    for group in (list(signals_of(plant)), moving_slopes(plant)):
        for variable in group:
            yield [variable]
        if len(group) > 1:
            yield group


def _widest(task: GainTask, group: list[Variable]) -> str:
    """Return the widest of the narrower ranges with which a set is found, in words; else empty."""
    if not _works(task, group, RANGE_SHARES[0]):
        return ""
    wider = (s for s in RANGE_SHARES[1:] if _works(task, group, s))
    share = next(wider, RANGE_SHARES[0])
    return " and ".join(range_in_words(v) for v in narrowed(task.plant, group, share).values())


def _works(task: GainTask, group: list[Variable], share: Fraction) -> bool:
    """Return whether a set is found if these ranges are narrowed."""
    ranges = narrowed(task.plant, group, share)
    try:
        held_rests(with_ranges(task.plant, ranges))
        return tracking_gains(_narrow_task(task, ranges), few=True).jump > 0
    except ModelError:
        # The ranges no longer hold the rests at all references.
        return False
