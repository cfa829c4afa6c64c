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

Gains for a norm from disturbances to performance, together with the other wishes.

One set of LMIs has the norm and, where they are asked for:

    wish                            hinf    h2      peak
    decay rate (settle)             yes     yes     yes, the rate of the ellipsoid itself
    damping, fastest                yes     yes     yes
    gain_bound                      yes     yes     yes
    input limits, state ranges      yes     no      yes

Limits hold on an ellipsoid x' P x <= 1 that contains the initial box and all states that
disturbances of a size reach from rest: an energy for hinf, a peak for peak.  The size is searched
for, because the norm that the LMIs show is about that of the ellipsoid over it: the larger the size
for which the limits have room, the less the initial box adds.  White noise leaves every ellipsoid,
so h2 has no such LMIs: there the norm is reduced as long as the gains keep the limits from the box.

The least norm is often approached only as the gains grow without bound.  So gains are designed for
a norm above the least one by a share (``ABOVE``), and of these with about the least input effort.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.plant.gain_task import FoundGains, GainTask
from takagi.certificates.design.plant.plain_words import in_file_rates
from takagi.certificates.design.plant.wishes import crossing_rates, held_from, pole_rates
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import NORMS, Norm
from takagi.models.plant.plant import file_unit

if TYPE_CHECKING:
    from takagi.certificates.requests.request import Request
    from takagi.lmi import Design, EigenvalueRegion
    from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
    from takagi.models.plant.design_settings import Effort, PlantSettings
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


# Of the least norm that was found, the norm that gains are designed for.
ABOVE: Mapping[Effort, float] = {"small": 1.5, "moderate": 1.1, "large": 1.02}
# Factors on the size of the disturbance, their number, and the norm that is better by another one.
GROWTH, MOST_SIZES, BETTER = 3.0, 6, 0.98
# Factor by which the norm of plain gains is reduced at first, how often at most, and the root of it
# at which the search ends.
REDUCED, MOST_REDUCED, NEARLY = 4.0, 16, 0.85
# The claim is about rounded gains, so the LMIs are posed a little below the norm that is asked for.
INSIDE = 0.999


@dataclass(frozen=True, slots=True, eq=False)
class NormQuestion:
    """One way to ask for gains with a norm.

    Attributes
    ----------
    plant : as the LMI layer takes it, with the region of the poles.
    relaxation : of the double sum.
    options : what is asked beside the norm, as the LMI layer names it.
    limited : whether limits hold on the ellipsoid, so that a size of the disturbance is needed.
    duration : time scale of the plant [s].
    """

    wish: NormWish
    plant: DisturbedPlant
    relaxation: str
    options: Mapping[str, Any]
    limited: bool
    duration: float

    @classmethod
    def of(cls, task: GainTask, wish: NormWish, relaxation: str) -> NormQuestion:
        """Return the question with all wishes that have LMIs beside the norm.

        Without an initial box, limits are not posed.  The last, fastest of the plant's rates gives
        the time scale.
        """
        model, box, limit, rate = task.model, task.box, task.input_limit, task.rate
        options: dict[str, Any] = {"gain_bound": task.settings.gain_bound}
        if rate:
            options["decay_rate"] = rate
        limited = any(task.initial) and wish.kind != "h2"
        if limited:
            options |= {"initial_box": task.initial, "input_limit": limit}
            options["state_box"] = box if np.isfinite(box).any() else None
        rates = pole_rates(model) if limit is None else crossing_rates(model, box, limit)
        duration = 1 / (rate or (rates[-1] if rates else 1.0))
        return cls(wish, wish.plant(model, task.region), relaxation, options, limited, duration)

    def asked(self, below: float | None, size: float) -> Design:
        """Return gains with a norm below a number, or the least; else the last attempt.

        ``size`` : of the disturbance for which limits hold, in its ranges.
        """
        from takagi.lmi import h2_pdc, hinf_pdc, peak_pdc

        function: Any = {"hinf": hinf_pdc, "h2": h2_pdc, "peak": peak_pdc}[self.wish.kind]
        sizes: dict[Norm, dict[str, float]] = {
            "hinf": {"disturbance_energy": (size * self.wish.size) ** 2 * self.duration},
            "peak": {"disturbance_peak": size * self.wish.size},
        }
        options = dict(self.options)
        if self.limited:
            options |= sizes[self.wish.kind]
        design: Design = function(
            self.plant, relaxation=self.relaxation, norm_below=below, **options
        )
        return design


def norm_gains(task: GainTask, wish: NormWish, plain: Design) -> FoundGains:
    """Return gains with the norm that is asked for, or near the least one.

    Where the LMIs do not reach the norm that is asked for, the gains are those with the least norm
    that was found; the claim, which is about the loop, may still be proved.

    Parameters
    ----------
    plain : gains with all wishes but the norm, which is then reduced from theirs where the least
        is not found, or where its LMIs lack the limits of inputs.
    """
    if not plain.found:
        return FoundGains(plain)
    question = NormQuestion.of(task, wish, plain.relaxation)
    below, size = wish.below, 1.0
    limits, notes = task.input_limit, tuple[str, ...]()
    # Without limits in the LMIs, gains have to keep those of the inputs from the initial box.
    reduced = limits is not None and not question.limited
    if limits is not None and reduced:
        keeps = partial(held_from, task.model, task.initial, limits)
        design, note = _reduced(question, plain, keeps)
    else:
        design, size = _least(question)
        notes = (_size_note(question, size),) if question.limited and design.found else ()
        note = f"the least norm of the LMIs with all wishes is {_gain(design):.4g}"
        if not design.found and not question.limited:
            design, note = _reduced(question, plain, lambda gains: True)
    if design.found and (below is not None or not reduced):
        above = ABOVE[task.settings.effort] * _gain(design)
        target = INSIDE * below if below is not None else above
        asked = question.asked(target, size)
        design = asked if asked.found else design
        if below is None and asked.found:
            note += f"; designed for {target:.4g}, where the gains are smaller"
        elif below is not None and asked.found:
            note = ""
        elif below is not None:
            note += f", above norm_below = {below:g}: these gains have about that; allow more, or "
            note += "relax another wish"
    words = filter(None, (*notes, note))
    return FoundGains(design, tuple(in_file_rates(n, task.plant) for n in words))


def _reduced(
    question: NormQuestion, plain: Design, keeps_limits: Callable[[Floats], bool]
) -> tuple[Design, str]:
    """Return the gains with the least norm, from that of plain gains on, for which limits hold."""
    norm = _norm_of(question, np.asarray(plain.gains))
    best, factor, step = replace(plain, answer=replace(plain.answer, gain=norm)), 1.0, 1 / REDUCED
    for _ in range(MOST_REDUCED):
        design = question.asked(factor * step * norm, 1.0)
        if design.found and keeps_limits(np.asarray(design.gains)):
            best, factor = design, factor * step
        else:
            step = float(np.sqrt(step))
        if step > NEARLY:
            break
    words = f"a norm of {_gain(best):.4g} was reached from that of gains without regard to it"
    return best, f"{words}, {norm:.4g}"


def _norm_of(question: NormQuestion, gains: Floats) -> float:
    """Return the norm that one quadratic function shows of the loop with gains (r, m, n)."""
    from takagi.lmi import h2_norm, hinf_norm, peak_gain

    plant = question.plant
    first, second = np.triu_indices(len(plant.A))
    pairs = list(zip(first.tolist(), second.tolist(), strict=True))
    A = [_mean(plant.A, plant.B, gains, i, j) for i, j in pairs]
    C = [_mean(plant.C, plant.D12, gains, i, j) for i, j in pairs]
    E, D = ((stack[first] + stack[second]) / 2 for stack in (plant.E, plant.D11))
    functions: dict[Norm, Any] = {"hinf": hinf_norm, "h2": h2_norm, "peak": peak_gain}
    function = functions[question.wish.kind]
    answer = function(np.array(A), E, np.array(C), D, sample_time=plant.sample_time)
    return np.inf if answer.gain is None else float(answer.gain)


def _mean(X: Floats, Y: Floats, K: Floats, i: int, j: int) -> Floats:
    return np.asarray((X[i] - Y[i] @ K[j] + X[j] - Y[j] @ K[i]) / 2)


def _least(question: NormQuestion) -> tuple[Design, float]:
    """Return the gains with the least norm, and the size of the disturbance in its ranges.

    A larger disturbance in the LMIs loosens the bound, until the limits leave no room for it.
    """
    size = 1.0
    best = question.asked(None, size)
    if not question.limited:
        return best, size
    step = GROWTH if best.found else 1 / GROWTH
    for _ in range(MOST_SIZES):
        other = question.asked(None, step * size)
        if best.found and not _gain(other) < BETTER * _gain(best):
            break
        best, size = other, step * size
    return best, size


def _gain(design: Design) -> float:
    return np.inf if design.answer.gain is None else float(design.answer.gain)


def _size_note(question: NormQuestion, size: float) -> str:
    lasting = f" during {question.duration:.3g} s" if question.wish.kind == "hinf" else ""
    return (
        f"the limits were posed for starts in the initial box and disturbances of {size:.3g} times "
        f"the range (without a range, the unit){lasting}"
    )
