"""The norm that is asked of a design: from which disturbances, of which outputs, and its unit.

The performance output z has a row for each name, in the unit that the plant's file gives it:

    output   C_i x + D_i u of the model, rule by rule; an output is in SI units
    state    x_k - x_k*
    input    u_k - u_k*, minus the law's gains times x
    neither  x_k over the half-width of its range, for every state with a range

The norm's unit is that of z over that of w, also as the file has them; for white noise w has an
intensity, and its root the unit of w times sqrt(s).  Of several disturbances in different units the
numbers are those of SI units.  A claim has one scale for all w, so z is multiplied by it: the
number in the claim, in the report and in ``norm_below`` is the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import NORMS, Norm
from takagi.models.plant.plant import file_unit

if TYPE_CHECKING:
    from takagi.certificates.requests.request import Request
    from takagi.lmi import EigenvalueRegion
    from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

QUANTITIES: dict[Norm, str] = {
    "hinf": "energy gain",
    "h2": "response to white noise",
    "peak": "peak gain",
}
STATES = "states over their ranges"


@dataclass(frozen=True, slots=True, eq=False)
class NormWish:
    """A norm that is asked for.

    Attributes
    ----------
    kind : which norm.
    sources : numbers of the disturbances that it is about.
    C, D : (r, p, n) and (r, p, m) of z, scaled as the module says.
    size : about the largest |w|, in the model's units: the ends of the ranges, and one unit of the
        file for a disturbance without a range.
    below : the norm that is enough; None for the least.
    label : what the number is, with its unit, e.g. ``"energy gain from gust to height [m/(m/s)]"``.
    """

    kind: Norm
    sources: tuple[int, ...]
    C: Floats
    D: Floats
    size: float
    below: float | None
    label: str

    def request(self, value: float | None = None) -> Request:
        """Return the claim that is asked for, with a norm of at most the value, or the least."""
        from takagi.certificates.requests.channel_norms import H2Norm, L2Gain, Peak

        # A matrix for each rule only where the rules differ: a secant embedding has no others.
        C, D = (stack[:1] if (stack == stack[0]).all() else stack for stack in (self.C, self.D))
        output = (C, D) if self.D.any() else (C,)
        channel: Any = {"output": output, "entering": self.sources, "name": self.label}
        if self.kind == "h2":
            return H2Norm(value, **channel)
        if self.kind == "peak":
            return Peak(value, **channel)
        return L2Gain(value, energy_bound="largest", **channel)

    def plant(self, model: TSModel, region: EigenvalueRegion | None) -> DisturbedPlant:
        """Return the plant as the LMI layer takes it, from the named disturbances to z."""
        from takagi.lmi.gains.disturbance.disturbed_plant import plant_of

        plant = plant_of(model, (self.C, self.D))
        columns = list(self.sources)
        return replace(plant, E=plant.E[:, :, columns], D11=plant.D11[:, :, columns], region=region)


def norm_wish(plant: Plant, model: TSModel, settings: PlantSettings) -> NormWish | None:
    """Return what is asked of a norm; None where no norm is.

    Raises
    ------
    ModelError : an unknown name; a plant without disturbance, or without anything to keep small;
        a plant whose law has an observer or follows references.
    """
    if settings.objective is None or settings.objective not in NORMS:
        return None
    kind: Norm = settings.objective
    sources = _sources(plant, model, settings)
    rows, names, units = _performance(plant, model, settings)
    size, below_unit, widest = _disturbance(plant, sources)
    if kind == "h2" and model.sample_time is None:
        # The root of the intensity, in units of w sqrt(s).
        below_unit = "s^0.5" if below_unit == "-" else f"{below_unit} s^0.5"
    unit = _quotient(units[0] if len(set(units)) == 1 else f"({', '.join(units)})", below_unit)
    others = ", ".join(n for k, n in enumerate(_names(plant)) if k in sources)
    C, D = (size * stack for stack in rows)
    label = f"{QUANTITIES[kind]} from {others} to {', '.join(names)} [{unit}]"
    return NormWish(kind, sources, C, D, widest, settings.norm_below, label)


def _names(plant: Plant) -> tuple[str, ...]:
    return tuple(v.name for v in plant.disturbances)


def _sources(plant: Plant, model: TSModel, settings: PlantSettings) -> tuple[int, ...]:
    names, moved = _names(plant), np.abs(model.E).max(axis=(0, 1)) > 0
    moving = [name for name, moves in zip(names, moved, strict=True) if moves]
    if not moving:
        raise ModelError(
            f"objective {settings.objective}: no disturbance moves a state of plant {plant.name!r};"
            " write one in [disturbances] and in an equation, or ask for decay or effort"
        )
    idle = [name for name in settings.disturbances if name in names and name not in moving]
    if idle:
        raise ModelError(
            f"disturbances: {idle[0]} moves no state, so nothing is to be kept from it; those that "
            f"do are {', '.join(moving)}"
        )
    return tuple(names.index(name) for name in settings.disturbances or moving)


def _performance(
    plant: Plant, model: TSModel, settings: PlantSettings
) -> tuple[tuple[Floats, Floats], list[str], list[str]]:
    """Return C and D of z in the file's units, the rows' names, and their units."""
    (r, n, m), names = model.B.shape, settings.performance
    outputs = {y.name: k for k, y in enumerate(plant.outputs)}
    states = {v.name: k for k, v in enumerate(plant.states)}
    inputs = {v.name: k for k, v in enumerate(plant.inputs)}
    if not names and not outputs:
        return _states_over_ranges(plant, model), [STATES], ["-"]
    C, D, units = [], [], []
    for name in names or tuple(outputs):
        row_C, row_D = np.zeros((r, n)), np.zeros((r, m))
        # A measured state is an output of the same name, without the unit of the file.
        shown = name not in states or (
            name in outputs
            and plant.outputs[outputs[name]].expression != plant.states[states[name]].symbol
        )
        if name in outputs and shown:
            size, unit = 1.0, plant.outputs[outputs[name]].unit
            row_C = model.C[:, outputs[name]]
            row_D = model.D[:, outputs[name]] if model.D.size else row_D
        elif name in states:
            row_C[:, states[name]] = 1.0
            size, unit = file_unit(plant.states[states[name]])
        else:
            row_D[:, inputs[name]] = 1.0
            size, unit = file_unit(plant.inputs[inputs[name]])
        C.append(row_C / size)
        D.append(row_D / size)
        units.append(unit)
    return (np.stack(C, axis=1), np.stack(D, axis=1)), list(names or outputs), units


def _states_over_ranges(plant: Plant, model: TSModel) -> tuple[Floats, Floats]:
    r, n, m = model.B.shape
    halves = [model.box.get(label) for label in model.states]
    rows = [k for k, side in enumerate(halves) if side is not None]
    if not rows:
        raise ModelError(
            f"performance: plant {plant.name!r} has no output and no state with a range, so nothing"
            " says what is to be kept small; name states or inputs in performance"
        )
    C = np.zeros((len(rows), n))
    for row, k in enumerate(rows):
        low, high = model.box[model.states[k]]
        C[row, k] = float(f"{1 / float(min(-low, high)):.12g}")
    return np.broadcast_to(C, (r, *C.shape)).copy(), np.zeros((r, len(rows), m))


def _disturbance(plant: Plant, sources: tuple[int, ...]) -> tuple[float, str, float]:
    """Return the common scale of w, its unit, and about the largest |w| in SI."""
    variables = [plant.disturbances[k] for k in sources]
    units = [file_unit(v) for v in variables]
    halves = [
        size if v.range is None else float(max(v.range.upper - v.rest, v.rest - v.range.lower))
        for v, (size, _) in zip(variables, units, strict=True)
    ]
    widest = float(np.linalg.norm(halves))
    if len(set(units)) == 1:
        return units[0][0], units[0][1], widest
    si_units = {v.unit for v in variables}
    listed = ", ".join(v.unit for v in variables)
    return 1.0, si_units.pop() if len(si_units) == 1 else f"({listed})", widest


def _quotient(above: str, below: str) -> str:
    if below == "-":
        return above
    bottom = f"({below})" if set(below) & set("/ ") and below[-1] != ")" else below
    top = f"({above})" if "/" in above and above[0] != "(" else above
    return f"{'1' if above == '-' else top}/{bottom}"
