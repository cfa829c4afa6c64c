"""The results of a plant's simulation in sentences and as a table; units of the plant's file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import floor, log10

import numpy as np

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.blending.blending import blending_of
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.plant.plant import (
    Plant,
    Variable,
    file_unit,
    in_file_units,
    range_in_file_units,
    time_in_file_units,
)
from takagi.models.plant_simulation.runs import Cut, SampledProgram
from takagi.models.plant_simulation.signals import Noise, Pulse, Ramp, Signal, Signals, Sine, Step
from takagi.reports.loops.plant_claims import withstood
from takagi.reports.loops.plant_loop import PlantLoop, proved_claims
from takagi.reports.loops.plant_motion import Outside, PlantMotion, settling_time
from takagi.reports.output import sentence
from takagi.reports.page.text import behind

WORDS = "simulation/words.toml"
# A value of noise without a given time is held for this share of the fastest time constant.
HELD_SHARE = 0.1
# If no pole differs from zero [s].
HELD_AT_REST = 0.01


@dataclass(frozen=True, slots=True)
class PlantScenario:
    """The options of a simulation; none by default.

    Attributes
    ----------
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

    Raises
    ------
    ModelError : a name that the plant does not have, or a disturbance that moves the effectiveness
        of a blended actuator.
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


# Largest number of states with a column of their own in the table.
MOST_STATES = 3
# Largest number of runs that are named in a sentence.
MOST_NAMED = 3
_ENDED = {
    "whole": "inside",
    "far": "diverged",
    "undefined": "no value",
    "stuck": "integration failed",
}


def columns(found: PlantSimulation) -> tuple[list[str], list[list[str]]]:
    """Return headings, with their units, and one row of texts for each run."""
    loop = found.loop
    states = [
        (k, v) for k, v in enumerate(loop.plant.states) if len(loop.plant.states) <= MOST_STATES
    ]
    actuators = commanded(loop)
    heads = ["start", *(f"largest\ndeviation\n{v.name} {_bracket(v)}" for _, v in states)]
    heads += [f"largest\n{v.name} {_bracket(v)}" for v in actuators]
    heads += [f"{v.name}\ncut for\n[s]" for v in actuators if v.range is not None]
    heads += ["settled\nafter\n[s]", "starts\nin the\nset", "ended as"]
    rows = []
    for motion in found.motions:
        row = [motion.name]
        row += [_figure(np.abs(motion.state[:, k]).max() / file_unit(v)[0]) for k, v in states]
        sent = np.hstack([motion.input, motion.acting]) if motion.acting.size else motion.input
        row += [
            _figure(np.abs(sent[:, k]).max() / file_unit(v)[0]) for k, v in enumerate(actuators)
        ]
        for cuts in cuts_by_command(loop, motion).values():
            spent = sum(cut.end - cut.begin for cut in cuts)
            row.append(f"{spent:.3g}" if cuts else "-")
        settled = settling_time(motion, SETTLED)
        row.append("-" if np.isnan(settled) else f"{settled:.3g}")
        row.append({True: "yes", False: "no", None: "none"}[in_proved_set(loop, motion)])
        left = motion.whole and left_box(loop, motion) is not None
        row.append("left the box" if left else _ENDED[motion.ended])
        rows.append(row)
    return heads, rows


def notes(found: PlantSimulation) -> list[str]:
    """Return sentences on signals, limited inputs, and what the certificate covers."""
    return [
        *_law(found), *_cut(found), *_runs(found), *_starts(found), *_covered(found),
        *_unsettled(found), sentence(WORDS, "settled"),
    ]  # fmt: skip


def as_markdown(found: PlantSimulation, *, figures: Sequence[str]) -> str:
    """Return the table, the sentences and the figures."""
    heads, rows = columns(found)
    flat = [head.replace("\n", " ") for head in heads]
    lines = [f"# {found.loop.plant.name}, simulated", ""]
    lines += ["| " + " | ".join(flat) + " |", "|" + "---|" * len(flat)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    lines += ["", *(f"- {note}" for note in notes(found)), ""]
    if figures:
        lines += ["Dashed: ends of a range. Shaded: a command is cut in one of the runs.", ""]
    for name in figures:
        lines += [f"![{name}]({name})", ""]
    return "\n".join(lines)


def _law(found: PlantSimulation) -> Iterator[str]:
    if told := in_words(found.scenario, found.loop.plant):
        yield f"From outside: {'; '.join(told)}."
    step, missed = found.scenario.sample_time, sum(motion.missed for motion in found.motions)
    if step is not None:
        yield sentence(WORDS, "sampled law", step=step)
        if missed:
            yield sentence(WORDS, "missed samples", count=missed, s="s" * (missed > 1))


def _cut(found: PlantSimulation) -> Iterator[str]:
    for k, variable in enumerate(commanded(found.loop)):
        named = []
        for motion in found.motions:
            if cuts := cuts_by_command(found.loop, motion).get(variable.name):
                begin, end = cuts[0].begin, max(cut.end for cut in cuts)
                spent = sum(cut.end - cut.begin for cut in cuts)
                words = sentence(
                    WORDS, "cut once" if len(cuts) == 1 else "cut often",
                    begin=_time(found, begin), end=_time(found, end),
                    times=len(cuts), spent=_time(found, spent),
                )  # fmt: skip
                named.append(f"{words} in the run from {motion.name}")
        if named:
            side, wanted = range_in_file_units(variable), _most_wanted(found, k, variable)
            yield sentence(
                WORDS, "cut", name=variable.name, range=side, wanted=wanted, runs=_first_runs(named)
            )


def _first_runs(named: Sequence[str]) -> str:
    more = f"; and in {len(named) - MOST_NAMED} more runs" if len(named) > MOST_NAMED else ""
    return "; ".join(named[:MOST_NAMED]) + more


def _most_wanted(found: PlantSimulation, k: int, variable: Variable) -> str:
    if k >= len(found.loop.plant.inputs):
        return ""
    wanted = np.concatenate([motion.wanted[:, k] for motion in found.motions])
    most = float(wanted[np.nanargmax(np.abs(wanted))])
    return f" (the law commanded up to {in_file_units(variable, most)})"


def _runs(found: PlantSimulation) -> Iterator[str]:
    left = [(motion.name, left_box(found.loop, motion)) for motion in found.motions]
    named = [f"{x[0].name} at {_time(found, x[1])} in the run from {run}" for run, x in left if x]
    if named:
        yield sentence(WORDS, "left", runs=_first_runs(named))
    for motion in found.motions:
        if not motion.whole:
            time = _time(found, float(motion.time[-1]))
            yield sentence(WORDS, f"ended {motion.ended}", run=motion.name, time=time)


def _unsettled(found: PlantSimulation) -> Iterator[str]:
    # Noise and disturbances may keep a motion from settling for ever.
    short = [m for m in found.motions if m.whole and np.isnan(settling_time(m, SETTLED))]
    if short and not found.scenario.disturbances and not found.scenario.noise:
        longest = max(m.time[-1] for m in short)
        yield sentence(WORDS, "unsettled", count=len(short), of=len(found.motions), longest=longest)


def _starts(found: PlantSimulation) -> Iterator[str]:
    if 0 < found.scale < 1:
        yield sentence(WORDS, "corners", scale=found.scale)
        return
    inside = [(motion, in_proved_set(found.loop, motion)) for motion in found.motions]
    outer = [
        f"{motion.name} (V is {start_share(found.loop, motion):.3g} times its level)"
        for motion, known in inside
        if known is False
    ]
    if outer:
        yield sentence(WORDS, "outer", starts=", ".join(outer))
    elif any(known is None for _, known in inside) and found.loop.gains is not None:
        yield sentence(WORDS, "no set")


def _covered(found: PlantSimulation) -> Iterator[str]:
    """Yield the parts of the scenario that the certificate does not cover."""
    lines, scenario = [], found.scenario
    if scenario.noise:
        lines.append("measurement noise")
    step = scenario.sample_time
    if step is not None:
        held = [
            float(str(claim["sample_time"]))
            for claim in proved_claims(found.design.document, found.design.checked, "sampled-loop")
        ]
        if not any(step <= proved * (1 + 1e-12) for proved in held):
            lines.append(
                f"a law in samples of {step:.4g} s (--sample-time of 'takagi design' proves one)"
            )
    known = {one.variable.name: one.proved for one in withstood(found.design)}
    for name in dict.fromkeys(name for name, _ in scenario.disturbances):
        lines += _uncovered(found, name, known.get(name))
    if lines:
        yield f"Not covered by the certificate's sets: {'; '.join(lines)}."
    sampling = found.design.document.get("controller", {}).get("sampling") or {}
    longest = sampling.get("longest")
    if step is not None and longest is not None and step > longest:
        yield sentence(WORDS, "long sample", longest=longest, reason=sampling["reason"])


def _uncovered(found: PlantSimulation, name: str, proved: float | None) -> list[str]:
    variable = next((v for v in found.loop.plant.disturbances if v.name == name), None)
    if variable is None:
        return []
    size, unit = file_unit(variable)
    moving = moving_disturbances(found.scenario, found.loop.plant)
    moved = [v.name for v in moving].index(name)
    values = np.concatenate([motion.disturbance[:, moved] for motion in found.motions])
    off = float(np.abs(values - float(variable.rest)).max())
    side = variable.range
    if side is not None and (values.min() < float(side.lower) or values.max() > float(side.upper)):
        ends = f"[{float(side.lower) / size:.4g}, {float(side.upper) / size:.4g}]"
        return [
            f"{name} from {values.min() / size:.4g} to {values.max() / size:.4g}{behind(unit)}, "
            f"outside its range {ends}"
        ]
    if variable.schedules:
        return []
    if not proved:
        return [f"{name} away from rest (no invariant set is proved for it)"]
    if off > proved * (1 + 1e-9):
        return [
            f"{name} up to {in_file_units(variable, off)} from rest (an invariant set is proved "
            f"for {in_file_units(variable, proved)})"
        ]
    return []


def _figure(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"


def _time(found: PlantSimulation, seconds: float) -> str:
    if not seconds:
        return "0 s"
    number, unit = time_in_file_units(found.loop.plant, seconds)
    return f"{number:.3g} {unit}"


def _bracket(variable: Variable) -> str:
    return f"[{file_unit(variable)[1]}]"
