"""Gains for a model with many rules, within a budget of time: which kind, and what is said of it.

A gain for every rule is the default.  Where it is estimated to take longer than the budget, one
gain for all rules is sought: its inequalities are linear in the vertices, so those at the vertices
are all, and the unknowns do not grow with the rules.  It is found for the whole model.  Where there
is none, gains that depend on the premises of most effect alone are sought, with the other premises
in the middle of their ranges.  That model is not the plant; these gains are valid only if the
certificate, which is always about all rules, is proved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.plant.blend_regions import ONE_GAIN, expanded
from takagi.certificates.design.plant.gains import FoundGains, find_gains
from takagi.certificates.design.plant.work_estimate import WorkEstimate, effects, work_of
from takagi.certificates.document.plant_blend import unknown_premises
from takagi.models.arrays import Indices
from takagi.models.ts.model import TSModel

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant

BUDGET = 120.0  # s
# Work that is announced although nothing is changed because of it.
LONG = 20.0  # s
SHOWN = 3  # premises in the announcement
READABLE = 60  # characters of a premise's expression that are shown whole


@dataclass(frozen=True, slots=True)
class GainChoice:
    """How gains are sought: what is announced before, ``""`` for short work, and the notes.

    Attributes
    ----------
    shortened : whether a gain for every rule would take longer than the budget.
    """

    shortened: bool
    announcement: str = ""
    note: str = ""


def gain_choice(model: TSModel, asked: PlantSettings, budget: float) -> GainChoice:
    """Return how gains are sought within ``budget`` [s], by estimates alone.

    A relaxation that was asked for is kept, however long it takes.
    """
    sizes = (len(model.states), len(model.inputs))
    single = work_of(len(model.A), sizes, asked, one_gain=True)
    if asked.relaxation == ONE_GAIN:
        said = f"one gain for all rules: {single.words}"
        return GainChoice(False, "" if single.seconds < LONG else f"{_head(model)}; {said}")
    each = work_of(len(model.A), sizes, asked, one_gain=False, merged=bool(model.premises))
    if each.seconds < LONG or len(model.A) == 1:
        return GainChoice(False)
    told = f"{_head(model)}; a gain for every rule: {each.words}"
    if asked.relaxation is not None or each.seconds <= budget:
        return GainChoice(False, f"{told}. {_less(model, asked, single)}")
    note = (
        f"one gain for all {len(model.A)} rules: a gain for every rule would take "
        f"{each.words}, more than the {budget:g} s of --time"
    )
    chosen = f"Chosen: one gain for all rules, {single.words}, because the budget is {budget:g} s"
    return GainChoice(True, f"{told}. {chosen} (--time). {_less(model, asked, single)}", note)


def shortened_gains(
    plant: Plant, model: TSModel, asked: PlantSettings, choice: GainChoice
) -> FoundGains:
    """Return one gain for all rules; what answers that there is none is returned too."""
    found = find_gains(plant, model, replace(asked, relaxation=ONE_GAIN))
    return replace(found, notes=(choice.note, *found.notes), explainable=False)


def gains_of_few_premises(
    plant: Plant, model: TSModel, asked: PlantSettings, budget: float
) -> FoundGains | None:
    """Return gains that depend on the premises of most effect, as many as the budget allows.

    None where no two rules are left, or where the smaller model has no gains.
    """
    sizes = (len(model.states), len(model.inputs))
    order = np.argsort(-effects(model), kind="stable")
    count = len(order) - 1
    while count and work_of(2**count, sizes, asked, one_gain=False).seconds > budget / 2:
        count -= 1
    if not count:
        return None
    kept = sorted(int(k) for k in order[:count])
    smaller, rules = model_of_premises(model, kept)
    found = find_gains(plant, smaller, asked)
    if not found.design.found:
        return None
    names = ", ".join(model.premises[k].name for k in kept)
    note = (
        f"gains that depend on {names} alone, sought with the other premises in the middle of "
        f"their ranges and proved with all {len(model.A)} rules"
    )
    return replace(found, design=expanded(found.design, rules), notes=(note, *found.notes))


def gains_of_known_premises(
    plant: Plant, model: TSModel, asked: PlantSettings
) -> FoundGains | None:
    """Return gains that depend on the premises without uncertain parameters.

    They are sought with the other premises in the middle of their ranges.  None where no premise is
    uncertain or known, or where the smaller model has no gains.
    """
    unknown = unknown_premises(model)
    kept = [k for k, hidden in enumerate(unknown) if not hidden]
    if not any(unknown) or not kept or plant.blending is not None or asked.relaxation is not None:
        return None
    smaller, rules = model_of_premises(model, kept)
    found = find_gains(plant, smaller, asked)
    if not found.design.found:
        return None
    note = (
        "gains that depend on the premises without uncertain parameters, sought with the others in "
        f"the middle of their ranges and proved with all {len(model.A)} rules"
    )
    return replace(found, design=expanded(found.design, rules), notes=(note, *found.notes))


def model_of_premises(model: TSModel, kept: list[int]) -> tuple[TSModel, Indices]:
    """Return the model with the other premises at mid-range, and each rule's place in it."""
    places: dict[tuple[int, ...], list[int]] = {}
    for rule, corners in enumerate(model.rules):
        places.setdefault(tuple(corners[k] for k in kept), []).append(rule)
    members = [places[corners] for corners in sorted(places)]
    means = [
        np.array([stack[rules].mean(axis=0) for rules in members]) for stack in (model.A, model.B)
    ]
    smaller = TSModel(
        *means,
        states=model.states,
        inputs=model.inputs,
        premises=[model.premises[k] for k in kept],
        rules=sorted(places),
        box=model.box,
        sample_time=model.sample_time,
        name=model.name,
    )
    where = np.empty(len(model.A), dtype=np.intp)
    for number, rules in enumerate(members):
        where[rules] = number
    return smaller, where


def _head(model: TSModel) -> str:
    """Return rules and the premises of most effect, with ranges and units."""
    ranked = np.argsort(-effects(model), kind="stable")[:SHOWN]
    ranges = [
        f"{p.name}{_formula(model, k)} in [{float(p.lower):.4g}, {float(p.upper):.4g}]"
        + (f" {p.unit}" if p.unit != "-" else "")
        for k, p in ((int(k), model.premises[int(k)]) for k in ranked)
    ]
    widest = f", of most effect {'; '.join(ranges)}" if ranges else ""
    return f"{len(model.A)} rules by {len(model.premises)} premises{widest}"


def _formula(model: TSModel, premise: int) -> str:
    """Return " = " and the premise's expression; of a long one the variables that it depends on."""
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return ""
    expression = list(form.factored.premises.values())[premise]
    shown = str(expression)
    if len(shown) <= READABLE:
        return f" = {shown}"
    return f", which depends on {', '.join(sorted(map(str, expression.free_symbols)))},"


def _less(model: TSModel, asked: PlantSettings, single: WorkEstimate) -> str:
    """Return what takes less time."""
    if len(model.premises) < 2:
        return f"--relaxation {ONE_GAIN} takes {single.words}."
    least = model.premises[int(np.argmin(effects(model)))]
    sizes = (len(model.states), len(model.inputs))
    fewer = work_of(len(model.A) // 2, sizes, asked, one_gain=False)
    return (
        f"What takes less: a plant with one premise less, {fewer.time}; {least.name} has the least "
        "effect. A given --decay-rate, which is one problem in the place of several. --relaxation "
        f"{ONE_GAIN}, {single.time}."
    )
