"""Why there are no gains, in a sentence: which requirement excludes them, and what to change."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

from takagi.models.plant.file_units import rate_in_file_units

if TYPE_CHECKING:
    from takagi.certificates.design.plant.gains import FoundGains
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

DECAY = "decay"
# How the label of an inequality begins -> the requirement that it expresses.
_WISHES = {
    "disc": "fastest",
    "sector": "damping",
    "gain bound": "gain_bound",
    "initial state": "initial",
    "state box": "range",
    "input effort": "input_limit",
    "input limit": "input_limit",
    "input saturation limit": "input_limit",
    "command limit": "input_limit",
}


def obstacle(found: FoundGains, plant: Plant, model: TSModel, asked: PlantSettings) -> str:
    """Return the sentence; empty where the answer does not say which inequalities stop it."""
    from takagi.certificates.design.plant.plain_words import stuck_blend
    from takagi.lmi.decision.outcome import binding_shares

    answer = found.design.answer
    if answer.found:
        return ""
    stuck = stuck_blend(model)
    if stuck:
        return (
            f"In the model, where {stuck}, no input moves a part of the plant that does not settle "
            "by itself. What to change: give the states and signals in that expression ranges "
            "that leave such values out, or add an input that acts there."
        )
    if answer.status != "infeasible" or answer.condition is None:
        return _undecided(plant, asked)
    strict = [lmi.name for lmi in answer.condition.lmis if lmi.strict][1:]
    sizes: dict[str, float] = defaultdict(float)
    for share in binding_shares(answer.condition, answer.multipliers, *strict):
        sizes[_wish(share.label)] += share.share
    if not sizes:
        return ""
    if not asked.decay_rate and asked.gain_bound is not None:
        sizes.setdefault("gain_bound", 0.0)
    # That the loop settles is no wish that could be given up, unless it has a rate.
    wished = {DECAY} if asked.decay_rate else set()
    order = sorted(sizes, key=lambda wish: (wish == DECAY and wish not in wished, -sizes[wish]))
    first, *others = order
    second = f" Next in the way: {_what(others[0], plant, asked)}." if others else ""
    return (
        f"Most in the way is {_what(first, plant, asked)}. "
        f"What to change: {_advice(first, asked)}.{second}"
    )


def _undecided(plant: Plant, asked: PlantSettings) -> str:
    """Return the sentence where the solvers found neither gains nor a reason why there are none."""
    rate = asked.decay_rate
    if isinstance(rate, float | int) and rate > 0:
        number, unit = rate_in_file_units(plant, rate)
        return (
            f"No solver found gains with the decay rate of {number:.4g} {unit}, nor a proof that "
            "there are none. What to change: lower the rate (--decay-rate, or a longer --settle); "
            "if it is right, write the plant in units in which its figures are of like size."
        )
    return (
        "No solver found gains, nor a proof that there are none. What to change: give the states "
        "that stand in the premises smaller ranges, or write the plant in units in which its "
        "figures are of like size."
    )


def _wish(label: str) -> str:
    return next((wish for start, wish in _WISHES.items() if label.startswith(start)), DECAY)


def _what(wish: str, plant: Plant, asked: PlantSettings) -> str:
    if wish == DECAY:
        rate = asked.decay_rate
        if isinstance(rate, float | int) and rate > 0:
            number, unit = rate_in_file_units(plant, rate)
            return f"the decay rate of {number:.4g} {unit}, which all rules and their blends need"
        return "that one function has to decay along all rules and their blends"
    if wish == "fastest":
        assert asked.fastest is not None
        number, unit = rate_in_file_units(plant, asked.fastest)
        return f"fastest = {number:.4g} {unit}, the largest size of the poles"
    return {
        "damping": f"damping = {asked.damping or 0:g}, the least damping ratio of the poles",
        "gain_bound": f"gain_bound = {asked.gain_bound or 0:g}, on every gain",
        "initial": "that the set must hold all initial states",
        "range": "that the set must stay in the ranges of the states",
        "input_limit": "that no input may pass its limit",
    }[wish]


def _advice(wish: str, asked: PlantSettings) -> str:
    if wish == DECAY:
        rate = asked.decay_rate
        advice = ["raise gain_bound (--gain-bound)"] if asked.gain_bound is not None else []
        if isinstance(rate, float | int) and rate > 0:
            advice.append("lower the rate (--decay-rate, or a longer --settle)")
        advice.append("give the states that stand in the premises smaller ranges")
        if asked.relaxation is not None:
            advice.append("take richer relaxations (--relaxation auto)")
        return ", or ".join(advice)
    return {
        "fastest": "raise it (--fastest), or leave it out",
        "damping": "lower it (--damping), or leave it out",
        "gain_bound": "raise it (--gain-bound), or leave it out",
        "initial": "take smaller initial states (--initial), or wider ranges of inputs and states",
        "range": "give the states wider ranges, or take smaller initial states (--initial)",
        "input_limit": "give the inputs wider ranges (or --input-limit), or take smaller initial "
        "states (--initial)",
    }[wish]
