"""Gains for a plant: translates a task into a problem for the solver layer.

Gains of a blended plant are sought by its regions, without errors, and put on all rules of the
model.  The rules of the model with errors are corners of premises that the law knows and of errors
that it does not.  Each takes the gain of that rule of the model without errors which has the same
corners of what is known; so gains differ only with what is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.plant.fuzzy_gains import fuzzy_gains, premise_rates
from takagi.certificates.design.plant.gain_task import (
    ALL_PAIRS,
    ONE_GAIN,
    FoundGains,
    GainTask,
    commanded_premises,
)
from takagi.certificates.design.plant.norm_wish import NormWish, norm_gains, norm_wish
from takagi.certificates.design.plant.plain_words import in_file_rates
from takagi.certificates.design.plant.static_gains import (
    fixed_order_gains,
    measured_states,
    require_states,
    static_gains,
)
from takagi.certificates.design.plant.wishes import (
    ABSURD,
    PRICES,
    SHARES,
    SMALLER,
    TRIED_RATES,
    crossing_rates,
    gain_size,
    largest_multiple,
    largest_set,
    moderate,
    needs_starts,
    pole_rates,
    reach_rates,
    slowest_mode,
)
from takagi.certificates.document.plant_embedding import blend_of, plant_and_claim, unknown_premises
from takagi.models.arrays import Indices
from takagi.models.blending.blending import SHARE as BLEND_SHARE
from takagi.models.errors import ModelError
from takagi.models.plant.plant import rate_in_file_units

if TYPE_CHECKING:
    import sympy as sp

    from takagi.certificates.claims.certification import ClaimRequirements
    from takagi.lmi import Design
    from takagi.models.ts.model import TSModel

# Fraction of the largest decay rate: at the maximum itself gains have no margin for rounding.
SHARE = 0.9
# Of the initial box, and the accuracy of the least share of the inputs' limits, relative.
ROOM, SHARE_STEP = 1.005, 0.03
GAIN_OF_EACH_REGION = "one gain for each region, sought without the actuators' errors"
# Where limits leave no gains to all pairs; of more rules it takes minutes.
RICHER, MOST_RICHER = "liu-zhang", 8


def find_gains(task: GainTask) -> FoundGains:
    """Return gains for the model as asked; where there are none, the answer that says so.

    Raises
    ------
    ModelError : what is asked makes no sense for this plant: names, a region in discrete time,
        "max" without bounded gains.
    """
    plant, settings, limited = task.plant, task.settings, task.input_limit is not None
    settings.require_names(
        states=tuple(v.name for v in plant.states),
        inputs=tuple(v.name for v in plant.inputs),
        disturbances=tuple(v.name for v in plant.disturbances),
        outputs=tuple(y.name for y in plant.outputs),
    )
    if settings.objective == "decay":
        return find_gains(task.asking(objective=None, decay_rate="max"))
    if needs_starts(settings) and limited and not settings.feedback:
        return _from_assumed_starts(task)
    wish = norm_wish(plant, task.model, settings)
    if settings.feedback:
        return fixed_order_gains(task, wish) if settings.order else _static(task, wish)
    if wish is not None:
        single, gain_notes = task.with_one_gain()
        # Gains with a norm exist only if gains exist, which is known sooner.
        gains = norm_gains(single, wish, _Question.of(single)(task.rate or 0.0))
        return replace(gains, notes=(*gain_notes, *gains.notes))
    if settings.objective == "effort":
        return _of_least_effort(task)
    ask = _Question.of(task)
    if settings.decay_rate == "max":
        if settings.gain_bound is None and not limited:
            raise ModelError(_no_largest(ask))
        return _near_largest(ask)
    if settings.decay_rate is not None:
        return _smaller(ask, ask.gains(ask(settings.decay_rate)))
    rates, price = ask.rates, PRICES[settings.effort]
    if settings.effort == "large" and not ask.limited:
        rates = [*rates, *(2.0**k * rate for rate in rates[-1:] for k in (1, 2))]
    ranged = np.isfinite(task.box)
    counted = ranged if ranged.any() else None
    design, note = moderate(ask, rates, for_set=ask.limited, price=price, counted=counted)
    if ask.limited and not design.found and settings.relaxation is None:
        return _richer(task, ask.gains(design))
    if ask.limited and not rates and design.found:
        design, note = _not_absurdly_slow(ask, design, note)
    notes = [in_file_rates(note, plant)] if note else []
    return _smaller(ask, ask.gains(design, *notes))


def _static(task: GainTask, wish: NormWish | None) -> FoundGains:
    """Return gains on the measured states alone."""
    from takagi.certificates.requests.loop.loop import ClaimedLoop

    model = task.model
    data, _, _ = plant_and_claim(model)
    scheduled = ClaimedLoop.of(model, model_data=data).exact.scheduled_by or model.states
    single, gain_notes = task.with_one_gain()
    measured = {model.states[k] for k in measured_states(task.plant, task.settings)}
    hidden = [name for name in scheduled if name in model.states and name not in measured]
    relaxation = single.settings.relaxation or ALL_PAIRS
    if hidden:
        names = ", ".join(label.partition(" [")[0] for label in hidden)
        gain_notes = (*gain_notes, f"{names} is in a premise and not measured: one gain")
        relaxation = ONE_GAIN
    plain = replace(single, settings=replace(single.settings.without_objective, feedback=()))
    gains = static_gains(task, wish, relaxation=relaxation, unstructured=find_gains(plain).design)
    return replace(gains, notes=(*gain_notes, *gains.notes))


def _of_least_effort(task: GainTask) -> FoundGains:
    """Return gains with the least share of the inputs' limits from the initial box, at its rate."""
    if task.input_limit is None:
        raise ModelError(
            "objective effort makes the share of the inputs' limits small that is used, but the "
            "inputs have neither range nor input_limit; give one, or bound the gains by gain_bound"
        )
    plain = replace(task, settings=task.settings.without_objective)
    gains = find_gains(plain)
    if not gains.design.found:
        return gains
    # What is claimed is about rounded gains and a rounded set, so the box gets a little room.
    wider = plain.asking(initial={name: ROOM * x for name, x in plain.settings.initial.items()})
    asked = plain.settings.decay_rate
    rate = gains.design.decay_rate or 0.0 if asked is None else asked
    low, high = 0.0, 1.0
    while high - low > SHARE_STEP * high:
        share = (low + high) / 2
        design = _Question.of(replace(wider, input_limit=share * task.input_limit))(rate)
        if design.found:
            high, gains = share, replace(gains, design=design, input_share=share)
        else:
            low = share
    note = f"the least share of the inputs' limits from the initial box is about {high:.2g}"
    return replace(gains, notes=(*gains.notes, note), options=None)


def _richer(task: GainTask, without: FoundGains) -> FoundGains:
    """Return gains by a richer relaxation, where limits leave none to all pairs of rules."""
    if not 1 < len(task.model.A) <= MOST_RICHER or without.design.relaxation == ONE_GAIN:
        return without
    gains = find_gains(task.asking(relaxation=RICHER))
    if not gains.design.found:
        return without
    note = f"all pairs of rules have no gains, the relaxation {RICHER} has"
    return replace(gains, notes=(*gains.notes, note))


def scheduled_gains(task: GainTask) -> FoundGains | None:
    """Return gains by a function that depends on the weights; None without any, or with limits."""
    commanded = commanded_premises(task.model)
    if task.input_limit is not None or any(unknown_premises(task.model)) or commanded:
        return None
    return fuzzy_gains(task)


def _not_absurdly_slow(ask: _Question, slowest: Design, note: str) -> tuple[Design, str]:
    """Return the design with a rate by what the inputs can do; ``slowest`` unless it is absurd."""
    box, price = ask.task.box, PRICES[ask.task.settings.effort]
    if np.isfinite(box).all() or not np.isfinite(box).any():
        return slowest, note
    rates, time = reach_rates(ask.task.model, box, np.asarray(ask.options["input_limit"]))
    if not rates or slowest_mode(ask.task.model, slowest) * time * ABSURD > 1:
        return slowest, note
    faster, choice = moderate(ask, rates, for_set=True, price=price, counted=np.isfinite(box))
    if faster.decay_rate == 0:
        return slowest, note
    pairs = zip(ask.task.plant.states, box, strict=True)
    free = ", ".join(v.name for v, half in pairs if np.isinf(half))
    return faster, (
        f"{choice}; {TRIED_RATES} follow from {time:.3g} s, in which the inputs bring "
        f"the states with a range to their ends, because {free} have none: give them ranges, or "
        "--settle"
    )


def regional_gains(task: GainTask) -> FoundGains | None:
    """Return gains that go with the share of a blend, sought without the actuators' errors.

    None where nothing is unknown to the law, where a relaxation was asked for, where both
    actuators act alike so that there is nothing to schedule, or where there are no such gains.
    Only the certificate decides whether they are valid with the errors.
    """
    if not any(unknown_premises(task.model)) or task.settings.relaxation is not None:
        return None
    nominal = _errorless(task)
    gains = None if nominal is None else find_gains(nominal[0])
    if nominal is None or gains is None or not gains.design.found:
        return None
    notes = (*gains.notes, GAIN_OF_EACH_REGION)
    return replace(gains, design=expanded(gains.design, nominal[1]), notes=notes)


def requirements_of(task: GainTask) -> ClaimRequirements:
    """Return what is asked of the gains, to be proved of them.

    Raises
    ------
    ModelError : what is asked makes no sense for this plant.
    """
    from takagi.certificates.claims.certification import ClaimRequirements

    plant, model, settings = task.plant, task.model, task.settings
    if settings.feedback:
        require_states(plant, settings)
    if settings.objective is not None and (plant.references or plant.measured is not None):
        cause = "follows references" if plant.references else "has an observer, for measured"
        raise ModelError(
            f"objective {settings.objective}: the law of plant {plant.name!r} {cause}, and an "
            "objective is for gains of all states; leave objective out, or that part of the file"
        )
    wish, noise = norm_wish(plant, model, settings), settings.noise
    return ClaimRequirements(
        decay_rate=task.rate,
        input_limits=task.input_limit,
        region=task.region,
        sample_time=settings.sample_time,
        noise={v.label: noise[v.name] for v in plant.disturbances if v.name in noise},
        horizon=settings.horizon,
        norm=None if wish is None else wish.request,
        norm_below=settings.norm_below,
        polynomial_region=_polynomial_region(task),
        premise_rates=partial(premise_rates, plant, model),
    )


def _polynomial_region(task: GainTask) -> bool:
    """Return whether a polynomial region of attraction is asked for."""
    plant, model = task.plant, task.model
    if task.settings.safe_start != "polynomial":
        return False
    if plant.references or plant.measured is not None or plant.blending is not None:
        raise ModelError(
            f"safe_start polynomial: the law of plant {plant.name!r} has states of its own, and "
            "such a set is for a law of the plant's states alone; leave safe_start out"
        )
    from takagi.certificates.requests.attraction_region import require_polynomial

    require_polynomial(plant_and_claim(model)[0], model.name)
    return True


@dataclass(frozen=True, slots=True)
class _Question:
    """One way to ask for gains at a decay rate."""

    task: GainTask
    by: Callable[..., Design]
    options: Mapping[str, Any]
    relaxations: tuple[str, ...]
    limited: bool
    rates: list[float]
    notes: tuple[str, ...]

    @classmethod
    def of(cls, task: GainTask) -> _Question:
        from takagi.lmi import attraction_pdc, pdc

        task, notes = task.with_one_gain()
        settings, box, input_limit = task.settings, task.box, task.input_limit
        options: dict[str, Any] = {"region": task.region, "gain_bound": settings.gain_bound}
        rates = pole_rates(task.model)
        if input_limit is not None:
            rates = crossing_rates(task.model, box, input_limit)
        if input_limit is not None and not settings.initial:
            options = {"input_limit": input_limit, "state_box": box, "saturation": None}
            note = "inputs are limited: gains with the largest ellipsoid in which all limits hold"
            names = (settings.relaxation or ALL_PAIRS,)
            return cls(task, attraction_pdc, options, names, True, rates, (*notes, note))
        if settings.initial:
            options |= {"initial_box": task.initial, "input_limit": input_limit}
            options["state_box"] = box if np.any(np.isfinite(box)) else None
        # The largest rate by every relaxation takes minutes: one is enough for it.
        fallback = () if settings.decay_rate == "max" else ("auto",)
        names = (ALL_PAIRS, *fallback) if settings.relaxation is None else (settings.relaxation,)
        return cls(task, pdc, options, names, False, rates, notes)

    def __call__(self, rate: float | str) -> Design:
        for relaxation in self.relaxations:
            design = self.by(
                self.task.model, decay_rate=rate, relaxation=relaxation, **self.options
            )
            if design.found:
                break
        return design

    def gains(self, design: Design, *notes: str) -> FoundGains:
        if design.found and design.relaxation != self.relaxations[0] != "auto":
            richer = f"all pairs of rules have no gains at this rate, {design.relaxation} has"
            notes = (*notes, richer)
        options = None if self.limited else self.options
        return FoundGains(design, (*self.notes, *notes), options)


def _from_assumed_starts(task: GainTask) -> FoundGains:
    """Return gains for wishes that need starts, where inputs are limited and none were given."""
    assert task.input_limit is not None  # asked before
    largest = largest_set(task.model, task.box, task.input_limit)
    if not largest.found:
        return FoundGains(largest)
    multiple = largest_multiple(largest, task.box)
    for share in SHARES:
        starts = [float(f"{share * multiple * half:.2g}") for half in task.box]
        names = (v.name for v in task.plant.states)
        gains = find_gains(task.asking(initial=dict(zip(names, starts, strict=True))))
        if gains.design.found:
            break
    starts_in_words = ", ".join(
        f"{label.partition(' [')[0]} = {start:g} {label.partition('[')[2].rstrip(']')}"
        for label, start in zip(task.model.states, starts, strict=True)
    )
    note = f"no initial states were given: gains for a box of half-widths {starts_in_words}"
    return replace(gains, notes=(*gains.notes, note))


def _near_largest(ask: _Question) -> FoundGains:
    top = ask("max")
    if not top.found:
        return ask.gains(top)
    slower = ask(SHARE * top.decay_rate)
    number, unit = rate_in_file_units(ask.task.plant, float(top.decay_rate))
    note = f"the largest decay rate found is {number:.4g} {unit}; designed at {SHARE:.0%} of it"
    return ask.gains(slower if slower.found else top, note)


def _no_largest(ask: _Question) -> str:
    """Return why there is no largest rate, and the one number that is missing."""
    words = (
        'decay_rate is "max", but nothing bounds the gains: the larger they are, the faster the '
        "loop is; one number is missing: give gain_bound (--gain-bound)"
    )
    plain, _ = moderate(ask, ask.rates, for_set=False, price=PRICES["moderate"])
    if not plain.found:
        return words
    size = gain_size(plain)
    return f"{words}, for instance {2 * size:.2g}, which is twice the gains of a moderate rate"


def _smaller(ask: _Question, gains: FoundGains) -> FoundGains:
    """Return gains of a smaller norm at the same rate, if a small effort is wished for."""
    settings = ask.task.settings
    if settings.effort == "large" and settings.decay_rate is not None:
        note = "effort large changes nothing, because the decay rate is asked for"
        return replace(gains, notes=(*gains.notes, note))
    free = settings.gain_bound is None and not ask.limited and gains.design.found
    if settings.effort != "small" or not free:
        return gains
    size = gain_size(gains.design)
    for share in SMALLER:
        options = {**ask.options, "gain_bound": float(f"{share * size:.2g}")}
        smaller = replace(ask, options=options)(float(gains.design.decay_rate))
        if smaller.found:
            note = f"effort small: gains of a norm of at most {options['gain_bound']:g}"
            return replace(gains, design=smaller, notes=(*gains.notes, note), options=options)
    return replace(gains, notes=(*gains.notes, "effort small: no smaller gains have this rate"))


def _errorless(task: GainTask) -> tuple[GainTask, Indices] | None:
    """Return the task without errors, and for each rule of the model the rule that it takes.

    None where the model without errors has no premise in the share, or one that is not found in
    the model.
    """
    from takagi.models.blending.substitution import blended_model, blended_plant

    blending, settings = blend_of(task.model), task.settings
    if blending is None:
        return None
    sure = replace(
        blending,
        low=replace(blending.low, error=Fraction(0)),
        high=replace(blending.high, error=Fraction(0)),
    )
    nominal = blended_plant(sure)
    model = blended_model(nominal, choice=settings.choice, rest=settings.rest, share_apart=True)
    indices = _premise_indices(model, task.model)
    share = {BLEND_SHARE, f"delta_{BLEND_SHARE}"}
    if indices is None or not any(
        str(symbol) in share for e in _expressions(model) for symbol in e.free_symbols
    ):
        return None
    numbers = {rule: k for k, rule in enumerate(model.rules)}
    rules = [numbers[tuple(rule[index] for index in indices)] for rule in task.model.rules]
    return GainTask.of(nominal, model, settings), np.array(rules, dtype=np.intp)


def expanded(design: Design, rules: Indices) -> Design:
    """Return the design with the gain of ``rules[i]`` in rule i."""
    gains = np.asarray(design.require()[0])
    return replace(design, gains=gains[rules])


def _premise_indices(errorless_model: TSModel, model: TSModel) -> list[int] | None:
    """Return which premise of ``model`` is each one of the errorless model, up to a constant."""
    is_known = [not unknown for unknown in unknown_premises(model)]
    expressions = _expressions(model)
    indices = []
    pairs = zip(errorless_model.premises, _expressions(errorless_model), strict=True)
    for premise, expression in pairs:
        width = premise.upper - premise.lower
        same = [
            k
            for k, candidate in enumerate(expressions)
            if is_known[k]
            and not (candidate - expression).simplify().free_symbols
            and abs((model.premises[k].upper - model.premises[k].lower) - width) <= width / 10**6
        ]
        if not same:
            return None
        indices.append(same[0])
    return indices


def _expressions(model: TSModel) -> list[sp.Expr]:
    form = None if model.derivation is None else model.derivation.form
    return [] if form is None else list(form.factored.premises.values())
