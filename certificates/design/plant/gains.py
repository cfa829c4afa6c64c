"""Gains for a plant: translates the settings into a problem for the solver layer.

Where no decay rate is asked for, rates are tried that double, from 1/128 to 1/2 of the plant's own
fastest pole at a vertex (in discrete time, of 1/T).  The last is taken before a doubling that
costs too much: with gains K and V = x' P x of the slower rate, the command of rule i to input k on
{x' P x <= 1} is at most |K_ik P^(-1/2)|, and for the faster rate the largest of these over the
rules may at most be doubled.  This measure does not depend on units.  Where inputs are limited,
the ellipsoid in which the limits hold may shrink to half its mean semi-axis at the slowest rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.plant.blend_regions import errorless, expanded, one_gain
from takagi.certificates.document.plant_blend import unknown_premises
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.claims.plant.certificate import ClaimRequirements
    from takagi.lmi import Design, EigenvalueRegion
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

EFFORT = 2.0
SIZE = 0.5
HALVINGS = 7
# Fraction of the largest decay rate: at the maximum itself gains have no margin for rounding.
SHARE = 0.9
ALL_PAIRS = "wang-tanaka-griffin"


@dataclass(frozen=True, slots=True)
class FoundGains:
    """The design, or the last attempt at one; ``notes`` says what was chosen and why.

    ``options`` are those of ``pdc``, so that it can be asked again; ``explainable`` says whether
    it was ``pdc`` that was asked.
    """

    design: Design
    notes: tuple[str, ...]
    options: Mapping[str, Any]
    explainable: bool = True


def find_gains(plant: Plant, model: TSModel, asked: PlantSettings) -> FoundGains:
    """Return gains for the model as ``asked``; where there are none, the answer that says so.

    Raises
    ------
    ModelError : what is asked makes no sense for this plant: names, a region in discrete time,
        "max" without bounded gains.
    """
    ask = _question(plant, model, asked)
    if asked.decay_rate == "max":
        return _near_largest(ask)
    if asked.decay_rate is not None:
        return ask.found(ask(asked.decay_rate))
    return _moderate(ask, model)


def regional_gains(plant: Plant, model: TSModel, asked: PlantSettings) -> FoundGains | None:
    """Return gains that go with the share of a blend, sought without the actuators' errors.

    None where nothing is unknown to the law, where a relaxation was asked for, where both
    actuators act alike so that there is nothing to schedule, or where there are no such gains.
    Only the certificate decides whether they are valid with the errors.
    """
    if not any(unknown_premises(model)) or asked.relaxation is not None:
        return None
    found = errorless(plant, model, asked)
    if found is None:
        return None
    nominal, rules = found
    design = find_gains(nominal.plant, nominal.model, asked)
    if not design.design.found:
        return None
    note = "one gain for each region, sought without the actuators' errors"
    return replace(design, design=expanded(design.design, rules), notes=(*design.notes, note))


def requirements_of(plant: Plant, model: TSModel, asked: PlantSettings) -> ClaimRequirements:
    """Return what is asked of the gains, to be proved of them.

    Raises
    ------
    ModelError : what is asked makes no sense for this plant.
    """
    from takagi.certificates.claims.plant.certificate import ClaimRequirements

    limits = input_limits(plant, model, asked)
    return ClaimRequirements(
        decay_rate=asked.decay_rate if isinstance(asked.decay_rate, float | int) else None,
        input_limits=np.array([limits[v.name] for v in plant.inputs]) if limits else None,
        region=_region(model, asked),
        sample_time=asked.sample_time,
    )


def input_limits(plant: Plant, model: TSModel, asked: PlantSettings) -> dict[str, float]:
    """Return input -> largest deviation from its rest; empty where none has a limit.

    The rest is the model's, which may have been solved for.

    Raises
    ------
    ModelError : an input that rests at the end of its range has no room; or some have limits and
        others have not.
    """
    found: dict[str, float] = {}
    for variable, label in zip(plant.inputs, model.inputs, strict=True):
        if variable.name in asked.input_limit:
            found[variable.name] = asked.input_limit[variable.name]
        elif variable.range is not None:
            low, high = model.box[label]
            room = _rounded_down(min(-low, high))
            if room <= 0:
                raise ModelError(
                    f"input {variable.label} rests at the end of its range {variable.range}; a "
                    "linear law needs room to either side: move the rest, or widen the range"
                )
            found[variable.name] = room
    unlimited = [v.name for v in plant.inputs if v.name not in found]
    if found and unlimited:
        raise ModelError(
            f"input {', '.join(unlimited)} has neither range nor input_limit, but others have; "
            "give a limit for every input, or for none"
        )
    return found


def _rounded_down(value: Fraction) -> float:
    """Return a float whose shortest decimal is not above the value."""
    found = float(value)
    return found if Fraction(repr(found)) <= value else math.nextafter(found, -math.inf)


@dataclass(frozen=True, slots=True)
class _Question:
    """One way to ask for gains at a decay rate."""

    by: Callable[..., Design]
    model: TSModel
    options: Mapping[str, Any]
    relaxations: tuple[str, ...]
    limited: bool
    notes: tuple[str, ...] = ()

    def __call__(self, rate: float | str) -> Design:
        for relaxation in self.relaxations:
            design = self.by(self.model, decay_rate=rate, relaxation=relaxation, **self.options)
            if design.found:
                break
        return design

    def found(self, design: Design, *notes: str) -> FoundGains:
        return FoundGains(design, (*self.notes, *notes), self.options, explainable=not self.limited)


def _question(plant: Plant, model: TSModel, asked: PlantSettings) -> _Question:
    from takagi.lmi import attraction_pdc, pdc

    asked.require_names(
        states=tuple(v.name for v in plant.states), inputs=tuple(v.name for v in plant.inputs)
    )
    asked, told = one_gain(model, asked)
    limits = input_limits(plant, model, asked)
    region = _region(model, asked)
    box = _state_box(model)
    input_limit = None
    options: dict[str, Any]
    if limits:
        input_limit = [limits[v.name] for v in plant.inputs]
    if limits and not asked.initial:
        if region is not None or asked.gain_bound is not None:
            raise ModelError(
                "damping, fastest and gain_bound go with limited inputs only where the initial "
                "states are given; add initial = { state = half-width, ... }, or leave them out"
            )
        options = {"input_limit": input_limit, "state_box": box, "saturation": None}
        note = "inputs are limited: gains with the largest ellipsoid in which all limits hold"
        names = (asked.relaxation or ALL_PAIRS,)
        return _Question(attraction_pdc, model, options, names, limited=True, notes=(*told, note))
    options = {"region": region, "gain_bound": asked.gain_bound}
    if asked.initial:
        options["initial_box"] = [asked.initial[v.name] for v in plant.states]
        options["input_limit"] = input_limit
        options["state_box"] = box if np.any(np.isfinite(box)) else None
    # The largest rate by every relaxation takes minutes: one is enough for it.
    again = () if asked.decay_rate == "max" else ("auto",)
    names = (ALL_PAIRS, *again) if asked.relaxation is None else (asked.relaxation,)
    return _Question(pdc, model, options, names, limited=False, notes=told)


def _region(model: TSModel, asked: PlantSettings) -> EigenvalueRegion | None:
    from takagi.lmi import EigenvalueRegion

    if asked.damping is None and asked.fastest is None:
        return None
    if model.sample_time is not None:
        raise ModelError(
            "damping and fastest are about poles in continuous time; the plant is of discrete "
            f"time (sample time {model.sample_time:g} s): give a decay_rate instead"
        )
    parts = []
    if asked.damping is not None:
        parts.append(EigenvalueRegion.sector(float(np.arccos(asked.damping))))
    if asked.fastest is not None:
        parts.append(EigenvalueRegion.disc(asked.fastest))
    return parts[0] if len(parts) == 1 else parts[0] & parts[1]


def _state_box(model: TSModel) -> Floats:
    """Return the half-width of the box about the origin for each state; inf where it has none."""
    return np.array(
        [
            _rounded_down(min(-model.box[label][0], model.box[label][1]))
            if label in model.box
            else np.inf
            for label in model.states
        ]
    )


def _near_largest(ask: _Question) -> FoundGains:
    if ask.limited:
        raise ModelError(
            'decay_rate is "max" with limited inputs, but nothing says from where; give initial = '
            "{ state = half-width, ... }, or a number for decay_rate"
        )
    top = ask("max")
    if not top.found:
        return ask.found(top)
    found = ask(SHARE * top.decay_rate)
    note = (
        f"the largest decay rate found is {top.decay_rate:.4g} 1/s; designed at {SHARE:.0%} of it"
    )
    return ask.found(found if found.found else top, note)


def _moderate(ask: _Question, model: TSModel) -> FoundGains:
    best = slowest = ask(0.0)
    if not slowest.found:
        return ask.found(slowest)
    rates = _rates(model)
    for rate in rates:
        faster = ask(rate)
        if not faster.found or (best.decay_rate > 0 and not _worth(ask, faster, best, slowest)):
            break
        slowest = faster if best.decay_rate == 0 else slowest
        best = faster
    if best.decay_rate == 0:
        why = "none that was tried has gains" if rates else "its poles give the plant no time scale"
        return ask.found(best, f"no decay rate was asked for: rate 0, {why}")
    price = "costs half the ellipsoid" if ask.limited else "more than doubles the commands"
    note = f"no decay rate was asked for: {best.decay_rate:.4g} 1/s"
    if faster is not best:
        note += f"; twice as fast {price if faster.found else 'has no gains'}"
    return ask.found(best, note)


def _rates(model: TSModel) -> list[float]:
    """Return rates to try, slowest first; none for a plant whose poles are all at zero."""
    if model.sample_time is not None:
        top = 1.0 / model.sample_time
    else:
        top = float(np.abs(np.linalg.eigvals(np.asarray(model.A, dtype=np.float64))).max())
    # Two digits are enough, because the rate is a choice and not a result.
    return [float(f"{top / 2**k:.2g}") for k in range(HALVINGS, 0, -1)] if top > 0 else []


def _worth(ask: _Question, faster: Design, slower: Design, slowest: Design) -> bool:
    if ask.limited:
        return _mean_axis(faster) >= SIZE * _mean_axis(slowest)
    reach = np.linalg.inv(np.asarray(slower.require()[1]))
    sizes = [
        np.sqrt(np.einsum("rmi,ij,rmj->rm", K, reach, K)).max(axis=0)
        for K in (faster.require()[0], slower.require()[0])
    ]
    return bool(np.all(sizes[0] <= EFFORT * sizes[1]))


def _mean_axis(design: Design) -> float:
    P = np.asarray(design.require()[1])
    return float(np.exp(-np.linalg.slogdet(P)[1] / (2 * len(P))))
