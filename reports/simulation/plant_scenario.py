"""The signals that act on a simulated plant, the timing of its law, and the runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import floor, log10
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.plant.plant import in_file_units, time_in_file_units
from takagi.models.plant_simulation.signals import Noise, Pulse, Ramp, Signal, Signals, Sine, Step
from takagi.reports.loops.plant_motion import Outside

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.plant import Plant, Variable
    from takagi.models.plant_simulation.runs import Cut, SampledProgram
    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

# A value of noise without a given time is held for this share of the fastest time constant.
HELD_SHARE = 0.1
# If no pole differs from zero [s].
HELD_AT_REST = 0.01


@dataclass(frozen=True, slots=True)
class PlantScenario:
    """The options of a simulation; none by default.

    disturbances : (name, signal); several on one name are added.
    noise : (state, noise on its measurement).  If ``every`` is 0, ``resolved`` chooses the time for
        which a value is held.
    sample_time : T [s] of a sampled law, which holds its command; None for continuous time.
    """

    disturbances: tuple[tuple[str, Signal], ...] = ()
    noise: tuple[tuple[str, Noise], ...] = ()
    sample_time: float | None = None


def resolved(scenario: PlantScenario, loop: PlantLoop) -> PlantScenario:
    """Return the scenario with a time for each noise that has none.

    It is the law's sample time; of a law in continuous time a tenth of the fastest time constant
    at rest, to one digit.
    """
    hold = scenario.sample_time or loop.model.sample_time or _suited(loop)

    def held(signal: Signal) -> Signal:
        if isinstance(signal, Noise) and not signal.every:
            return replace(signal, every=hold)
        return signal

    return replace(
        scenario,
        disturbances=tuple((name, held(signal)) for name, signal in scenario.disturbances),
        noise=tuple((name, held(noise)) for name, noise in scenario.noise),  # type: ignore[misc]
    )


def outside(
    scenario: PlantScenario, loop: PlantLoop, program: Callable[[], SampledProgram] | None
) -> Outside:
    """Return the scenario, resolved, for the loop's plant.

    Raises ModelError: a name that the plant does not have, or a disturbance that moves the
        effectiveness of a blended actuator.
    """
    moving = moving_disturbances(scenario, loop.plant)
    names = [v.name for v in moving]
    states = [v.name for v in loop.plant.states]
    for name, _ in scenario.noise:
        if name not in states:
            raise ModelError(_unknown("state", name, states))
        if loop.blend is not None and name == states[-1]:
            raise ModelError(
                f"noise on {name}: it is not measured, for the law keeps the effort itself; leave "
                "it out, or put noise on a state of the plant"
            )
        if loop.observed is not None:
            shown = [states[k] for k in loop.observed.measured_states()]
            if name not in shown:
                raise ModelError(
                    f"noise on {name}: it is not measured by itself; noise can be put on "
                    f"{', '.join(shown) or 'no state of this plant'}"
                )
    return Outside(
        moving,
        Signals(len(names), tuple((names.index(n), s) for n, s in scenario.disturbances)),
        Signals(len(states), tuple((states.index(n), s) for n, s in scenario.noise)),
        program,
        scenario.sample_time,
    )


def moving_disturbances(scenario: PlantScenario, plant: Plant) -> tuple[Variable, ...]:
    """Return the disturbances that vary, in the order of the plant."""
    from takagi.models.blending.blending import blending_of

    blending = blending_of(plant)
    written = plant if blending is None else blending.plant
    known = {v.name: v for v in written.disturbances}
    for name, _ in scenario.disturbances:
        if name not in known:
            raise ModelError(_unknown("disturbance", name, list(known)))
    moved = {name for name, _ in scenario.disturbances}
    found = tuple(v for v in written.disturbances if v.name in moved)
    for actuator in () if blending is None else blending.actuators:
        for v in found:
            if v.symbol in actuator.effectiveness.free_symbols:
                raise ModelError(
                    f"disturbance {v.name}: it stands in the effectiveness of {actuator.name}, "
                    "which is simulated with its value at rest; leave it out, or write the "
                    "effectiveness without it"
                )
    return found


def in_words(scenario: PlantScenario, plant: Plant) -> list[str]:
    """Return a text for each signal, in the units of the plant's file."""
    from takagi.models.blending.blending import blending_of

    blending = blending_of(plant)
    variables = plant.variables + (() if blending is None else blending.plant.disturbances)
    known = {v.name: v for v in variables}
    found = [f"{name}: {_words(plant, known[name], s)}" for name, s in scenario.disturbances]
    return found + [
        f"{name} is measured with {_words(plant, known[name], noise)}"
        for name, noise in scenario.noise
    ]


def _words(plant: Plant, variable: Variable, signal: Signal) -> str:
    much = in_file_units(variable, signal.size)

    def at(seconds: float) -> str:
        if not seconds:
            return "0 s"
        number, word = time_in_file_units(plant, seconds)
        return f"{1e3 * number:.4g} ms" if word == "s" and number < 0.1 else f"{number:.4g} {word}"

    match signal:
        case Step(start=start):
            return f"a step of {much} at {at(start)}"
        case Pulse(start=start, stop=stop):
            return f"a pulse of {much} from {at(start)} to {at(stop)}"
        case Ramp(start=start, stop=stop):
            return f"a ramp to {much} from {at(start)} to {at(stop)}, which stays"
        case Sine(period=period, start=start):
            return f"a sine of {much} with period {at(period)} from {at(start)}"
        case Noise(every=every, seed=seed):
            return (
                f"Gaussian noise of standard deviation {much}, each value held for {at(every)} "
                f"(seed {seed[0]})"
            )
    raise AssertionError(signal)


def _suited(loop: PlantLoop) -> float:
    matrices, K = loop.at_rest()
    poles = np.abs(np.linalg.eigvals(matrices.A if K is None else matrices.A - matrices.B @ K))
    fastest = float(poles.max())
    if not fastest > 0:
        return HELD_AT_REST
    held = HELD_SHARE / fastest
    return float(round(held, -floor(log10(held))))


def _unknown(what: str, name: str, known: list[str]) -> str:
    listed = ", ".join(known) or "none"
    return f"there is no {what} {name}{did_you_mean(name, known)}; the plant has {listed}"


# A deviation of this share of its start counts as settled.
SETTLED = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class PlantSimulation:
    """Motions of the loop, and the loop itself.  A simulation proves nothing.

    ``scale`` : factor by which the corners of the box were scaled into the ellipsoid of the
    certificate's function; 1 for given starts.  ``design`` : the design with its certificate.
    ``scenario`` : the signals that acted on the loop.
    """

    loop: PlantLoop
    motions: tuple[PlantMotion, ...]
    design: PlantDesign
    scale: float = 1.0
    scenario: PlantScenario = field(default_factory=PlantScenario)

    @property
    def all_ended(self) -> bool:
        """Whether no motion went to infinity, and none met a state without a value."""
        return all(motion.whole for motion in self.motions)


def cuts_by_command(loop: PlantLoop, motion: PlantMotion) -> dict[str, list[Cut]]:
    """Return command -> the spans outside its range; empty if there are none.

    Commands are those of inputs with a range, and of actuators behind a blend.
    """
    variables = commanded(loop)
    found: dict[str, list[Cut]] = {v.name: [] for v in variables if v.range is not None}
    for cut in motion.cuts:
        found[variables[cut.command].name].append(cut)
    return found


def commanded(loop: PlantLoop) -> list[Variable]:
    """Return the inputs of the loop, then the actuators behind a blend."""
    blended = () if loop.blend is None else loop.blend.blending.actuators
    return [*loop.plant.inputs, *(a.variable for a in blended)]


def in_proved_set(loop: PlantLoop, motion: PlantMotion) -> bool | None:
    """Return whether a motion starts in the set that is proved to be invariant; None without."""
    if not (loop.bounded and loop.level_proved):
        return None
    return start_share(loop, motion) <= 1 + 1e-9


def start_share(loop: PlantLoop, motion: PlantMotion) -> float:
    """Return V / level at the start of a motion; only where the loop is bounded.

    A program keeps its estimate to itself; at the start it follows from the state.
    """
    S, level = loop.start_ellipsoid
    start = motion.state[0]
    return float(motion.value[0] if motion.value.size else start @ S @ start / level)


def left_box(loop: PlantLoop, motion: PlantMotion) -> tuple[Variable, float] | None:
    """Return the state that first leaves its range, and the time [s]; None if none does."""
    found: tuple[Variable, float] | None = None
    for k, (label, variable) in enumerate(zip(loop.model.states, loop.plant.states, strict=True)):
        side = loop.model.box.get(label)
        if side is not None:
            low, high = (float(end) for end in side)
            slack = 1e-9 * (high - low)
            outside = (motion.state[:, k] < low - slack) | (motion.state[:, k] > high + slack)
            if outside.any():
                time = float(motion.time[np.flatnonzero(outside)[0]])
                if found is None or time < found[1]:
                    found = variable, time
    return found
