"""Gains to find: a plant, its model, what is asked, and what limits them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.plant.wishes import PRICES
from takagi.certificates.document.model_data import inner_decimal
from takagi.certificates.document.plant_embedding import blend_of, unknown_premises
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi import Design, EigenvalueRegion
    from takagi.models.equilibrium_line import ConstantObserver
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

ALL_PAIRS, ONE_GAIN = "wang-tanaka-griffin", "common-gain"


@dataclass(frozen=True, slots=True)
class FoundGains:
    """What a search returns: gains, or its last attempt, with what was chosen and why.

    Attributes
    ----------
    design : the gains with P and the answer, or the answer that says why there are none.
    notes : what was chosen, and why.
    options : those of ``pdc``, so that it can be asked again; None where another was asked.
    sizes : of states (n,) and inputs (m,), which make the weights of the regulator that the law was
        chosen beside; None where it was not.
    input_share : the share of the inputs' limits that is to be proved, on the set of the design.
    observer : of a law with references and measured outputs; None for a law of all states.
    jump : of a law with references, the least jump over the width of its reference's range that
        stays in all ranges, in floating point; 0 where no set was found.
    """

    design: Design
    notes: tuple[str, ...] = ()
    options: Mapping[str, Any] | None = None
    sizes: tuple[Floats, Floats] | None = None
    input_share: float = 1.0
    observer: ConstantObserver | None = None
    jump: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class GainTask:
    """Gains to find for a plant; each search takes a task and returns ``FoundGains``.

    Attributes
    ----------
    box : (n,) half-widths of the states' ranges about rest, inf for none.
    input_limit : (m,) largest deviations of the inputs from rest; None without limits.
    """

    plant: Plant
    model: TSModel
    settings: PlantSettings
    box: Floats
    input_limit: Floats | None

    @classmethod
    def of(cls, plant: Plant, model: TSModel, settings: PlantSettings) -> GainTask:
        """Return the task.

        Raises
        ------
        ModelError : as ``input_limits``.
        """
        limits = input_limits(plant, model, settings)
        limit = np.array([limits[v.name] for v in plant.inputs]) if limits else None
        return cls(plant, model, settings, state_box(model), limit)

    def asking(self, **changes: Any) -> GainTask:
        """Return the task with other settings."""
        return GainTask.of(self.plant, self.model, replace(self.settings, **changes))

    def with_model(self, model: TSModel) -> GainTask:
        """Return the same for another model of the plant."""
        return GainTask.of(self.plant, model, self.settings)

    @property
    def rate(self) -> float | None:
        """The decay rate that is asked for as a number [1/s]; None where none is."""
        rate = self.settings.decay_rate
        return rate if isinstance(rate, float | int) else None

    @property
    def initial(self) -> list[float]:
        """(n,) half-widths of the box of initial states; 0 for one that is not given."""
        return [self.settings.initial.get(v.name, 0.0) for v in self.plant.states]

    @property
    def region(self) -> EigenvalueRegion | None:
        """The region that is asked for the poles; None for none.

        Raises
        ------
        ModelError : one is asked for in discrete time.
        """
        from takagi.lmi import EigenvalueRegion

        damping, fastest, model = self.settings.damping, self.settings.fastest, self.model
        if damping is None and fastest is None:
            return None
        if model.sample_time is not None:
            raise ModelError(
                "damping and fastest are about poles in continuous time; the plant is of discrete "
                f"time (sample time {model.sample_time:g} s): give a decay_rate instead"
            )
        sector = None if damping is None else EigenvalueRegion.sector(float(np.arccos(damping)))
        if fastest is None:
            return sector
        disc = EigenvalueRegion.disc(fastest)
        return disc if sector is None else sector & disc

    def with_one_gain(self) -> tuple[GainTask, tuple[str, ...]]:
        """Return the task, with one gain for all rules where a premise is not known to the law.

        Raises
        ------
        ModelError : another relaxation was asked for.
        """
        unknown = "uncertain parameters" if blend_of(self.model) is None else (
            "the errors of the actuators"
        )  # fmt: skip
        if any(unknown_premises(self.model)):
            cause = f"{unknown} are not known to a law"
            note = f"{unknown} are not measured: one gain for all rules"
        elif commanded := commanded_premises(self.model):
            names = ", ".join(commanded)
            cause = f"{names} depends on an input, which the law knows only afterwards"
            note = f"{cause}: one gain for all rules"
        else:
            return self, ()
        if self.settings.relaxation not in (None, ONE_GAIN):
            raise ModelError(
                f"relaxation {self.settings.relaxation!r} makes a gain for each rule, but {cause}; "
                f"leave it out, or give {ONE_GAIN!r}"
            )
        return replace(self, settings=replace(self.settings, relaxation=ONE_GAIN)), (note,)


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


def commanded_premises(model: TSModel) -> list[str]:
    """Return the names of the premises that depend on an input."""
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return []
    inputs = set(form.problem.equations.inputs)
    premises = form.factored.premises.items()
    return [symbol.name for symbol, e in premises if inputs & e.free_symbols]


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
