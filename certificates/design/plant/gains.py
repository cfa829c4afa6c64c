"""Gains for a plant: translates the settings into a problem for the solver layer.

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

from takagi.certificates.design.plant.fixed_order_gains import fixed_order_gains
from takagi.certificates.design.plant.fuzzy_gains import fuzzy_gains, premise_rates
from takagi.certificates.design.plant.norm_gains import norm_gains, question_of
from takagi.certificates.design.plant.norm_wish import NormWish, norm_wish
from takagi.certificates.design.plant.plain_words import in_file_rates
from takagi.certificates.design.plant.static_gains import (
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
    Price,
    crossing_rates,
    gain_size,
    held_from,
    largest_multiple,
    largest_set,
    moderate,
    needs_starts,
    pole_rates,
    reach_rates,
    slowest_mode,
)
from takagi.certificates.document.model_data import inner_decimal
from takagi.certificates.document.plant_embedding import blend_of, unknown_premises
from takagi.models.arrays import Floats, Indices
from takagi.models.blending.blending import SHARE as BLEND_SHARE
from takagi.models.errors import ModelError
from takagi.models.plant.plant import rate_in_file_units

if TYPE_CHECKING:
    import sympy as sp

    from takagi.certificates.claims.certification import ClaimRequirements
    from takagi.lmi import Design, EigenvalueRegion
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Fraction of the largest decay rate: at the maximum itself gains have no margin for rounding.
SHARE = 0.9
# Of the initial box, and the accuracy of the least share of the inputs' limits, relative.
ROOM, SHARE_STEP = 1.005, 0.03
ALL_PAIRS, ONE_GAIN = "wang-tanaka-griffin", "common-gain"
GAIN_OF_EACH_REGION = "one gain for each region, sought without the actuators' errors"
# Where limits leave no gains to all pairs; of more rules it takes minutes.
RICHER, MOST_RICHER = "liu-zhang", 8


@dataclass(frozen=True, slots=True)
class FoundGains:
    """The design, or the last attempt at one; ``notes`` says what was chosen and why.

    ``options`` are those of ``pdc``, so that it can be asked again; ``explainable`` says whether
    it was ``pdc`` that was asked.  ``sizes`` of states (n,) and inputs (m,) make the weights of the
    regulator that the law was chosen beside; None where it was not.  ``input_share`` is the share
    of the inputs' limits that is to be proved, on the set of the design.
    """

    design: Design
    notes: tuple[str, ...]
    options: Mapping[str, Any]
    explainable: bool = True
    sizes: tuple[Floats, Floats] | None = None
    input_share: float = 1.0


def find_gains(plant: Plant, model: TSModel, settings: PlantSettings) -> FoundGains:
    """Return gains for the model as ``asked``; where there are none, the answer that says so.

    Raises
    ------
    ModelError : what is asked makes no sense for this plant: names, a region in discrete time,
        "max" without bounded gains.
    """
    settings.require_names(
        states=tuple(v.name for v in plant.states),
        inputs=tuple(v.name for v in plant.inputs),
        disturbances=tuple(v.name for v in plant.disturbances),
        outputs=tuple(y.name for y in plant.outputs),
    )
    if settings.objective == "decay":
        settings = replace(settings, objective=None, decay_rate="max")
    limits, box = input_limits(plant, model, settings), state_box(model)
    input_limit = np.array([limits[v.name] for v in plant.inputs]) if limits else None
    if needs_starts(settings) and input_limit is not None and not settings.feedback:
        return _from_assumed_starts(plant, model, settings, box, input_limit)
    wish = norm_wish(plant, model, settings)
    if settings.feedback:
        return _static(plant, model, settings, wish, box, input_limit)
    if wish is not None:
        return _for_norm(wish, plant, model, settings, box, input_limit)
    if settings.objective == "effort":
        return _of_least_effort(plant, model, settings, box, input_limit)
    ask = _question(plant, model, settings, box, input_limit)
    price = PRICES[settings.effort]
    if settings.decay_rate == "max":
        if settings.gain_bound is None and input_limit is None:
            raise ModelError(_no_largest(ask))
        return _near_largest(ask, plant)
    if settings.decay_rate is not None:
        return _smaller(ask, ask.gains(ask(settings.decay_rate)), settings)
    rates = ask.rates
    if settings.effort == "large" and not ask.limited:
        rates = [*rates, *(2.0**k * rate for rate in rates[-1:] for k in (1, 2))]
    ranged = np.isfinite(box)
    counted = ranged if ranged.any() else None
    design, note = moderate(ask, rates, for_set=ask.limited, price=price, counted=counted)
    if ask.limited and not design.found and settings.relaxation is None:
        return _richer(plant, model, settings, ask.gains(design))
    if ask.limited and not rates and design.found:
        design, note = _not_absurdly_slow(ask, plant, box, price, design, note)
    notes = [in_file_rates(note, plant)] if note else []
    return _smaller(ask, ask.gains(design, *notes), settings)


def _for_norm(
    wish: NormWish,
    plant: Plant,
    model: TSModel,
    settings: PlantSettings,
    box: Floats,
    input_limit: Floats | None,
) -> FoundGains:
    """Return gains for a norm, with all other wishes that have LMIs beside it."""
    settings, gain_notes = one_gain(model, settings)
    initial = [settings.initial.get(v.name, 0.0) for v in plant.states]
    rate = settings.decay_rate if isinstance(settings.decay_rate, float | int) else 0.0
    # Gains with a norm exist only if gains exist, which is known sooner.
    plain = _question(plant, model, settings, box, input_limit)(rate)
    if not plain.found:
        return FoundGains(plain, gain_notes, {}, explainable=False)
    question = question_of(
        wish,
        wish.plant(model, _region(model, settings)),
        settings,
        relaxation=plain.relaxation,
        box=box,
        input_limit=input_limit,
        initial=initial,
        rates=pole_rates(model) if input_limit is None else crossing_rates(model, box, input_limit),
    )
    keeps_limits = None
    if input_limit is not None and not question.limited:
        keeps_limits = partial(held_from, model, initial, input_limit)
    design, notes = norm_gains(question, settings, plain, keeps_limits)
    notes = (*gain_notes, *notes)
    return FoundGains(design, tuple(in_file_rates(n, plant) for n in notes), {}, explainable=False)


def _static(
    plant: Plant,
    model: TSModel,
    settings: PlantSettings,
    wish: NormWish | None,
    box: Floats,
    input_limit: Floats | None,
) -> FoundGains:
    """Return gains on the measured states alone, or a controller of them."""
    if settings.order:
        design, notes = fixed_order_gains(
            plant, model, settings, wish, box=box, input_limit=input_limit
        )
        return FoundGains(design, notes, {}, explainable=False)
    settings, gain_notes = one_gain(model, settings)
    measured = {model.states[k] for k in measured_states(plant, settings)}
    hidden = [name for name in _scheduling(model) if name in model.states and name not in measured]
    if hidden:
        names = ", ".join(label.partition(" [")[0] for label in hidden)
        gain_notes = (*gain_notes, f"{names} is in a premise and not measured: one gain")
    plain = replace(settings.without_objective, feedback=())
    design, notes = static_gains(
        plant,
        model,
        settings,
        wish,
        relaxation=ONE_GAIN if hidden else settings.relaxation or ALL_PAIRS,
        box=box,
        input_limit=input_limit,
        unstructured=find_gains(plant, model, plain).design,
    )
    return FoundGains(design, (*gain_notes, *notes), {}, explainable=False)


def _scheduling(model: TSModel) -> tuple[str, ...]:
    """Return the labels of what the premises depend on."""
    from takagi.certificates.document.plant_embedding import plant_and_claim
    from takagi.certificates.requests.loop.loop import ClaimedLoop

    data, _, _ = plant_and_claim(model)
    return ClaimedLoop.of(model, model_data=data).exact.scheduled_by or model.states


def _of_least_effort(
    plant: Plant, model: TSModel, settings: PlantSettings, box: Floats, input_limit: Floats | None
) -> FoundGains:
    """Return gains with the least share of the inputs' limits from the initial box, at its rate.

    Raises
    ------
    ModelError : the inputs have no limits.
    """
    if input_limit is None:
        raise ModelError(
            "objective effort makes the share of the inputs' limits small that is used, but the "
            "inputs have neither range nor input_limit; give one, or bound the gains by gain_bound"
        )
    plain = settings.without_objective
    gains = find_gains(plant, model, plain)
    if not gains.design.found:
        return gains
    # What is claimed is about rounded gains and a rounded set, so the box gets a little room.
    initial = {name: ROOM * half for name, half in settings.initial.items()}
    wider = replace(plain, initial=initial)
    rate = gains.design.decay_rate or 0.0 if plain.decay_rate is None else plain.decay_rate
    low, high = 0.0, 1.0
    while high - low > SHARE_STEP * high:
        share = (low + high) / 2
        design = _question(plant, model, wider, box, share * input_limit)(rate)
        if design.found:
            high, gains = share, replace(gains, design=design, input_share=share)
        else:
            low = share
    note = f"the least share of the inputs' limits from the initial box is about {high:.2g}"
    return replace(gains, notes=(*gains.notes, note), explainable=False)


def _richer(
    plant: Plant, model: TSModel, settings: PlantSettings, without: FoundGains
) -> FoundGains:
    """Return gains by a richer relaxation, where limits leave none to all pairs of rules."""
    if not 1 < len(model.A) <= MOST_RICHER or without.design.relaxation == ONE_GAIN:
        return without
    gains = find_gains(plant, model, replace(settings, relaxation=RICHER))
    if not gains.design.found:
        return without
    note = f"all pairs of rules have no gains, the relaxation {RICHER} has"
    return replace(gains, notes=(*gains.notes, note))


def scheduled_gains(plant: Plant, model: TSModel, settings: PlantSettings) -> FoundGains | None:
    """Return gains by a function that depends on the weights; None without any, or with limits."""
    if input_limits(plant, model, settings) or any(unknown_premises(model)):
        return None
    found = None if _commanded_premises(model) else fuzzy_gains(plant, model, settings)
    return None if found is None else FoundGains(*found, {}, explainable=False)


def _not_absurdly_slow(
    ask: _Question, plant: Plant, box: Floats, price: Price, slowest: Design, note: str
) -> tuple[Design, str]:
    """Return the design with a rate by what the inputs can do; ``slowest`` unless it is absurd."""
    if np.isfinite(box).all() or not np.isfinite(box).any():
        return slowest, note
    rates, time = reach_rates(ask.model, box, np.asarray(ask.options["input_limit"]))
    if not rates or slowest_mode(ask.model, slowest) * time * ABSURD > 1:
        return slowest, note
    faster, choice = moderate(ask, rates, for_set=True, price=price, counted=np.isfinite(box))
    if faster.decay_rate == 0:
        return slowest, note
    free = ", ".join(v.name for v, half in zip(plant.states, box, strict=True) if np.isinf(half))
    return faster, (
        f"{choice}; {TRIED_RATES} follow from {time:.3g} s, in which the inputs bring "
        f"the states with a range to their ends, because {free} have none: give them ranges, or "
        "--settle"
    )


def regional_gains(plant: Plant, model: TSModel, settings: PlantSettings) -> FoundGains | None:
    """Return gains that go with the share of a blend, sought without the actuators' errors.

    None where nothing is unknown to the law, where a relaxation was asked for, where both
    actuators act alike so that there is nothing to schedule, or where there are no such gains.
    Only the certificate decides whether they are valid with the errors.
    """
    if not any(unknown_premises(model)) or settings.relaxation is not None:
        return None
    nominal = errorless(model, settings)
    if nominal is None:
        return None
    nominal_plant, nominal_model, rules = nominal
    design = find_gains(nominal_plant, nominal_model, settings)
    if not design.design.found:
        return None
    notes = (*design.notes, GAIN_OF_EACH_REGION)
    return replace(design, design=expanded(design.design, rules), notes=notes)


def requirements_of(plant: Plant, model: TSModel, settings: PlantSettings) -> ClaimRequirements:
    """Return what is asked of the gains, to be proved of them.

    Raises
    ------
    ModelError : what is asked makes no sense for this plant.
    """
    from takagi.certificates.claims.certification import ClaimRequirements

    limits, noise = input_limits(plant, model, settings), settings.noise
    if settings.feedback:
        require_states(plant, settings)
    if settings.objective is not None and (plant.references or plant.measured is not None):
        cause = "follows references" if plant.references else "has an observer, for measured"
        raise ModelError(
            f"objective {settings.objective}: the law of plant {plant.name!r} {cause}, and an "
            "objective is for gains of all states; leave objective out, or that part of the file"
        )
    wish = norm_wish(plant, model, settings)
    return ClaimRequirements(
        decay_rate=settings.decay_rate if isinstance(settings.decay_rate, float | int) else None,
        input_limits=np.array([limits[v.name] for v in plant.inputs]) if limits else None,
        region=_region(model, settings),
        sample_time=settings.sample_time,
        noise={v.label: noise[v.name] for v in plant.disturbances if v.name in noise},
        horizon=settings.horizon,
        norm=None if wish is None else wish.request,
        norm_below=settings.norm_below,
        polynomial_region=_polynomial_region(plant, model, settings),
        premise_rates=partial(premise_rates, plant, model),
    )


def _polynomial_region(plant: Plant, model: TSModel, settings: PlantSettings) -> bool:
    """Return whether a polynomial region of attraction is asked for.

    Raises
    ------
    ModelError : it is, and the plant is no polynomial, or its law has states of its own.
    """
    if settings.safe_start != "polynomial":
        return False
    if plant.references or plant.measured is not None or plant.blending is not None:
        raise ModelError(
            f"safe_start polynomial: the law of plant {plant.name!r} has states of its own, and "
            "such a set is for a law of the plant's states alone; leave safe_start out"
        )
    from takagi.certificates.document.plant_embedding import plant_and_claim
    from takagi.certificates.requests.attraction_region import require_polynomial

    require_polynomial(plant_and_claim(model)[0], model.name)
    return True


def input_limits(plant: Plant, model: TSModel, settings: PlantSettings) -> dict[str, float]:
    """Return input -> largest deviation from its rest; empty where none has a limit.

    The rest is the model's, which may have been solved for.

    The rates of a controller's states have none: inf beside limits of other inputs.

    Raises
    ------
    ModelError : an input that rests at the end of its range; or some have limits and
        others have not.
    """
    limits: dict[str, float] = {}
    for variable, label in zip(plant.inputs, model.inputs, strict=True):
        if variable.name in settings.input_limit:
            limits[variable.name] = settings.input_limit[variable.name]
        elif variable.range is not None:
            low, high = model.box[label]
            share = Fraction(PRICES[settings.effort].room)
            room = inner_decimal(share * min(-low, high), -1)
            if room <= 0:
                raise ModelError(
                    f"input {variable.label} rests at the end of its range {variable.range}; a "
                    "linear law needs room to either side: move the rest, or widen the range"
                )
            limits[variable.name] = room
    rates = {rate for _, rate in plant.integrators}
    unlimited = [v.name for v in plant.inputs if v.name not in {*limits, *rates}]
    if limits:
        limits |= dict.fromkeys(rates, np.inf)
    if limits and unlimited:
        raise ModelError(
            f"input {', '.join(unlimited)} has neither range nor input_limit, but others have; "
            "give a limit for every input, or for none"
        )
    return limits


@dataclass(frozen=True, slots=True)
class _Question:
    """One way to ask for gains at a decay rate."""

    by: Callable[..., Design]
    model: TSModel
    options: Mapping[str, Any]
    relaxations: tuple[str, ...]
    limited: bool
    rates: list[float]
    notes: tuple[str, ...] = ()

    def __call__(self, rate: float | str) -> Design:
        for relaxation in self.relaxations:
            design = self.by(self.model, decay_rate=rate, relaxation=relaxation, **self.options)
            if design.found:
                break
        return design

    def gains(self, design: Design, *notes: str) -> FoundGains:
        if design.found and design.relaxation != self.relaxations[0] != "auto":
            richer = f"all pairs of rules have no gains at this rate, {design.relaxation} has"
            notes = (*notes, richer)
        return FoundGains(design, (*self.notes, *notes), self.options, explainable=not self.limited)


def _question(
    plant: Plant, model: TSModel, settings: PlantSettings, box: Floats, input_limit: Floats | None
) -> _Question:
    from takagi.lmi import attraction_pdc, pdc

    settings, gain_notes = one_gain(model, settings)
    region = _region(model, settings)
    options: dict[str, Any]
    rates = pole_rates(model)
    if input_limit is not None:
        rates = crossing_rates(model, box, input_limit)
    if input_limit is not None and not settings.initial:
        options = {"input_limit": input_limit, "state_box": box, "saturation": None}
        note = "inputs are limited: gains with the largest ellipsoid in which all limits hold"
        names = (settings.relaxation or ALL_PAIRS,)
        notes = (*gain_notes, note)
        return _Question(attraction_pdc, model, options, names, True, rates, notes)
    options = {"region": region, "gain_bound": settings.gain_bound}
    if settings.initial:
        options["initial_box"] = [settings.initial.get(v.name, 0.0) for v in plant.states]
        options["input_limit"] = input_limit
        options["state_box"] = box if np.any(np.isfinite(box)) else None
    # The largest rate by every relaxation takes minutes: one is enough for it.
    fallback = () if settings.decay_rate == "max" else ("auto",)
    names = (ALL_PAIRS, *fallback) if settings.relaxation is None else (settings.relaxation,)
    return _Question(pdc, model, options, names, False, rates, gain_notes)


def _region(model: TSModel, settings: PlantSettings) -> EigenvalueRegion | None:
    from takagi.lmi import EigenvalueRegion

    if settings.damping is None and settings.fastest is None:
        return None
    if model.sample_time is not None:
        raise ModelError(
            "damping and fastest are about poles in continuous time; the plant is of discrete "
            f"time (sample time {model.sample_time:g} s): give a decay_rate instead"
        )
    regions = []
    if settings.damping is not None:
        regions.append(EigenvalueRegion.sector(float(np.arccos(settings.damping))))
    if settings.fastest is not None:
        regions.append(EigenvalueRegion.disc(settings.fastest))
    return regions[0] if len(regions) == 1 else regions[0] & regions[1]


def state_box(model: TSModel) -> Floats:
    """Return the half-width of the box about the origin for each state; inf where it has none."""
    return np.array(
        [
            inner_decimal(min(-model.box[label][0], model.box[label][1]), -1)
            if label in model.box
            else np.inf
            for label in model.states
        ]
    )


def weights_at_rest(model: TSModel) -> Floats:
    """Return h (r,) where every state and signal is at rest."""
    if not model.premises:
        return np.full(len(model.A), 1.0 / len(model.A))
    labels = (*model.states, *model.inputs, *model.disturbances)
    point = {label.split(" [")[0]: 0.0 for label in labels}
    return model.memberships(model.premise_values(**point), clip=True)


def _from_assumed_starts(
    plant: Plant, model: TSModel, settings: PlantSettings, box: Floats, input_limit: Floats
) -> FoundGains:
    """Return gains for wishes that need starts, where inputs are limited and none were given."""
    largest = largest_set(model, box, input_limit)
    if not largest.found:
        return FoundGains(largest, (), {}, explainable=False)
    multiple = largest_multiple(largest, box)
    for share in SHARES:
        starts = [float(f"{share * multiple * half:.2g}") for half in box]
        initial = dict(zip((v.name for v in plant.states), starts, strict=True))
        gains = find_gains(plant, model, replace(settings, initial=initial))
        if gains.design.found:
            break
    starts_in_words = ", ".join(
        f"{label.partition(' [')[0]} = {start:g} {label.partition('[')[2].rstrip(']')}"
        for label, start in zip(model.states, starts, strict=True)
    )
    note = f"no initial states were given: gains for a box of half-widths {starts_in_words}"
    return replace(gains, notes=(*gains.notes, note))


def _near_largest(ask: _Question, plant: Plant) -> FoundGains:
    top = ask("max")
    if not top.found:
        return ask.gains(top)
    slower = ask(SHARE * top.decay_rate)
    number, unit = rate_in_file_units(plant, float(top.decay_rate))
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


def _smaller(ask: _Question, gains: FoundGains, settings: PlantSettings) -> FoundGains:
    """Return gains of a smaller norm at the same rate, if a small effort is wished for."""
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


def rounded_gains(gains: Floats, digits: int) -> Floats:
    """Return the gains; each entry keeps ``digits`` digits of its largest value over the rules."""
    largest = np.abs(gains).max(axis=0)
    # An entry that is noise compared with its row has no effect on the command.
    floor = np.where(largest > 0, largest, 1.0)
    decimals = digits - 1 - np.floor(np.log10(floor)).astype(int)
    rounded = [
        [[round(float(v), int(p)) + 0.0 for v, p in zip(row, row_decimals, strict=True)]
         for row, row_decimals in zip(K, decimals, strict=True)]
        for K in gains
    ]  # fmt: skip
    return np.array(rounded)


def errorless(model: TSModel, settings: PlantSettings) -> tuple[Plant, TSModel, Indices] | None:
    """Return the plant without errors, its model, and for each rule of ``model`` the rule it takes.

    None where the model without errors has no premise in the share, or one that is not found in
    ``model``.
    """
    from takagi.models.blending.substitution import blended_model, blended_plant

    blending = blend_of(model)
    if blending is None:
        return None
    sure = replace(
        blending,
        low=replace(blending.low, error=Fraction(0)),
        high=replace(blending.high, error=Fraction(0)),
    )
    nominal = blended_plant(sure)
    choice, rest = settings.choice, settings.rest
    errorless_model = blended_model(nominal, choice=choice, rest=rest, share_apart=True)
    indices = _premise_indices(errorless_model, model)
    if indices is None or not any(
        str(symbol) in (BLEND_SHARE, f"delta_{BLEND_SHARE}")
        for expression in _expressions(errorless_model)
        for symbol in expression.free_symbols
    ):
        return None
    numbers = {rule: k for k, rule in enumerate(errorless_model.rules)}
    rules = [numbers[tuple(rule[index] for index in indices)] for rule in model.rules]
    return nominal, errorless_model, np.array(rules, dtype=np.intp)


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


def _unknown(model: TSModel) -> str:
    return "uncertain parameters" if blend_of(model) is None else "the errors of the actuators"


def one_gain(model: TSModel, settings: PlantSettings) -> tuple[PlantSettings, tuple[str, ...]]:
    """Return the settings, with one gain for all rules where a premise is not known to the law.

    Raises
    ------
    ModelError : another relaxation was asked for.
    """
    if any(unknown_premises(model)):
        cause = f"{_unknown(model)} are not known to a law"
        note = f"{_unknown(model)} are not measured: one gain for all rules"
    elif commanded := _commanded_premises(model):
        cause = f"{', '.join(commanded)} depends on an input, which the law knows only afterwards"
        note = f"{cause}: one gain for all rules"
    else:
        return settings, ()
    if settings.relaxation not in (None, ONE_GAIN):
        raise ModelError(
            f"relaxation {settings.relaxation!r} makes a gain for each rule, but {cause}; leave it "
            f"out, or give {ONE_GAIN!r}"
        )
    return replace(settings, relaxation=ONE_GAIN), (note,)


def _commanded_premises(model: TSModel) -> list[str]:
    """Return the names of the premises that depend on an input."""
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return []
    inputs = set(form.problem.equations.inputs)
    premises = form.factored.premises.items()
    return [symbol.name for symbol, e in premises if inputs & e.free_symbols]
