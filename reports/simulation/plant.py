"""The nonlinear plant under a law, from chosen starts: tables, figures and results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.plant.plant import Variable, file_unit, in_file_units
from takagi.models.plant_simulation.runs import SampledProgram
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
from takagi.reports.figures.loops import Panel, motions_figure
from takagi.reports.figures.plant.captioned import numbers_csv
from takagi.reports.figures.plant.proved_set import phase_figure, planes
from takagi.reports.figures.style import GREY, figure_to_svg
from takagi.reports.loops.plant_claims import proved_jumps
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop
from takagi.reports.loops.plant_motion import (
    Outside,
    PlantMotion,
    ProgramLaw,
    horizon,
    motions,
    settling_time,
    uncertain_ends,
)
from takagi.reports.simulation.plant_words import (
    SETTLED,
    PlantScenario,
    PlantSimulation,
    as_markdown,
    cuts_by_command,
    in_proved_set,
    left_box,
    moving_disturbances,
    notes,
    outside,
    resolved,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Start = tuple[str, Floats]
# The number of corners of a box doubles with each state.
MOST_CORNERS = 16


def simulate_plant(
    design: PlantDesign,
    *,
    starts: Sequence[Mapping[str, float]] | None = None,
    references: Sequence[Mapping[str, float]] | None = None,
    duration: float | None = None,
    scenario: PlantScenario | None = None,
    program: ControllerProgram | None = None,
) -> PlantSimulation:
    """Return the motions of the plant itself under the design's law.

    Inputs are limited to their ranges, as by actuators.  Each start is simulated with uncertain
    parameters in the middle of their ranges, and again at the ends.

    Parameters
    ----------
    starts : state -> value in SI; other states start at rest.  None takes the corners of the box,
        scaled into the ellipsoid of the certificate's function, or rest if a signal acts.
    references : reference -> value in SI after its jump from rest, one mapping for each run; None
        takes, without starts, the largest jumps that the certificate proves.
    duration : in s; None takes some time constants of the slowest pole, after the last jump.
    scenario : disturbances, noise and sample time; None for none of them.
    program : the gain file's program, for a sampled law; None takes that of the design.

    Raises
    ------
    ModelError : a state or disturbance that the plant does not have, a duration that is not
        positive or ends before a disturbance begins, or a law in samples where there can be none.
    """
    if duration is not None and not 0 < duration < np.inf:
        raise ModelError(f"duration = {duration:g} s was given; it must be positive")
    loop = plant_loop(design)
    asked = resolved(scenario or PlantScenario(), loop)
    if duration is not None:
        require_begun(asked, duration)
    run_by = None
    if asked.sample_time is not None:
        run_by = _program_law(design, loop, asked, program)
    comes = outside(asked, loop, run_by)
    if starts is not None:
        begin, scale = [_start(loop, given) for given in starts], 1.0
    elif asked.disturbances or asked.noise:
        begin, scale = [_start(loop, {})], 1.0
    else:
        begin, scale = corner_starts(loop)
    if duration is None:
        last = max((signal.last for _, signal in asked.disturbances), default=0.0)
        duration = horizon(loop) + last
    run = motions(loop, begin, duration=duration, outside=comes)
    for jump in proved_jumps(design) if references is None and starts is None else references or ():
        run += _after_jump(loop, jump, duration, comes)
    for values in uncertain_ends(design.plant):
        named = [(f"{words}; {_values(values)}", x) for words, x in begin]
        run += motions(loop, named, duration=duration, outside=comes, uncertain=values)
    return PlantSimulation(loop, run, design, scale, asked)


def require_begun(scenario: PlantScenario, duration: float) -> None:
    """Refuse a disturbance that begins after the end of the run [s].

    Raises
    ------
    ModelError : there is one; names it.
    """
    for name, signal in scenario.disturbances:
        start = getattr(signal, "start", 0.0)
        if start >= duration:
            raise ModelError(
                f"disturbance {name} begins at {start:g} s, but the run ends at {duration:g} s; "
                f"let it begin earlier, or give a duration beyond {start:g} s"
            )


def _program_law(
    design: PlantDesign, loop: PlantLoop, scenario: PlantScenario, program: ControllerProgram | None
) -> Callable[[], SampledProgram]:
    from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file

    step = scenario.sample_time
    assert step is not None
    if loop.discrete:
        raise ModelError(
            f"plant {loop.plant.name!r} is in discrete time: its law runs every "
            f"{loop.model.sample_time:g} s already; leave the sample time out"
        )
    if loop.gains is None:
        raise ModelError(
            f"plant {loop.plant.name!r} has no inputs, so there is no law to be sampled; leave the "
            "sample time out"
        )
    if program is None:
        text = dump_gains(plant_gain_file(design))
        program = controller_program(json.loads(text, parse_float=Decimal, parse_int=Decimal))
    moving = moving_disturbances(scenario, loop.plant)
    found = program
    ProgramLaw(found, loop, moving, step)  # refused here, before the first run
    return lambda: ProgramLaw(found, loop, moving, step)


def jump_motions(design: PlantDesign, loop: PlantLoop) -> tuple[PlantMotion, ...]:
    """Return the motions of the nominal plant from rest after the largest proved jumps."""
    found: tuple[PlantMotion, ...] = ()
    for jump in proved_jumps(design):
        found += _after_jump(loop, jump, None, Outside())[:1]
    return found


def _after_jump(
    loop: PlantLoop, jump: Mapping[str, float], duration: float | None, comes: Outside
) -> tuple[PlantMotion, ...]:
    """Return the motions from rest after a jump, also at the ends of uncertain parameters."""
    names = [one.name for one in loop.plant.references]
    for name in jump:
        if name not in names:
            raise ModelError(
                f"reference {name}: there is no such reference; the plant has "
                f"{', '.join(names) or 'none'}"
            )
    to = {name: Fraction(repr(float(value))) for name, value in jump.items()}
    found: tuple[PlantMotion, ...] = ()
    for values in ({}, *uncertain_ends(loop.plant)):
        words = "; ".join(
            part for part in ("rest", f"jump to {_values(to)}", _values(values)) if part
        )
        start = [(words, np.zeros(len(loop.names)))]
        runs = motions(loop, start, duration=duration, outside=comes, uncertain={**values, **to})
        found += tuple(replace(run, rest=run.state[-1]) for run in runs)
    return found


def corner_starts(loop: PlantLoop) -> tuple[list[Start], float]:
    """Return the corners of the box, scaled into the ellipsoid, and the scale factor.

    A state without a range starts at rest.  Without an ellipsoid the factor is 1.
    """
    sides = [loop.model.box.get(label) for label in loop.model.states]
    bounded = [k for k, side in enumerate(sides) if side is not None]
    choices = [[float(end) for end in side] if side is not None else [0.0] for side in sides]
    if 2 ** len(bounded) > MOST_CORNERS:
        # Both ends of each side alone.
        corners = [
            np.array([end if j == k else 0.0 for j in range(len(sides))])
            for k in bounded
            for end in choices[k]
        ]
    else:
        corners = [np.array(corner) for corner in product(*choices)]
    corners = [corner for corner in corners if np.any(corner)]
    if not corners:
        raise ModelError(
            f"plant {loop.plant.name!r}: no state has a range, so there are no corners to start "
            "from; give starts (--start)"
        )
    scale = 1.0
    if loop.bounded:
        P, level = loop.start_ellipsoid
        worst = max(float(corner @ P @ corner) for corner in corners)
        scale = min(1.0, float(np.sqrt(level / worst)))
    return [(_words(loop, scale * corner), scale * corner) for corner in corners], scale


def simulation_files(found: PlantSimulation) -> dict[str, bytes | str]:
    """Return relative name -> content: ``responses.csv``, ``simulation.json``, ``summary.md``,
    ``figures/``.
    """
    figures = simulated_figures(found.loop, found.motions, found.scenario)
    return {
        "responses.csv": simulated_csv(found.loop, found.motions, found.scenario),
        "simulation.json": json.dumps(simulation_data(found), indent=2) + "\n",
        "summary.md": as_markdown(found, figures=[f"figures/{name}.svg" for name in figures]),
        **{f"figures/{name}.svg": file for name, file in figures.items()},
    }


def simulation_data(found: PlantSimulation) -> dict[str, Any]:
    """Return one row for each motion; deviations from rest, SI, unless the key says otherwise."""
    loop = found.loop
    return {
        "plant": loop.plant.name,
        "scale": found.scale,
        "sample_time": found.scenario.sample_time,
        "runs": [
            {
                "name": motion.name,
                "start": dict(zip(loop.names, map(float, motion.state[0]), strict=True)),
                "end": dict(zip(loop.names, map(float, motion.state[-1]), strict=True)),
                "duration": float(motion.time[-1]),
                "settled_after": _number(settling_time(motion, SETTLED)),
                "largest_state": dict(
                    zip(loop.names, map(float, np.abs(motion.state).max(axis=0)), strict=True)
                ),
                "largest_input": {
                    variable.name: _finite(np.abs(motion.input[:, k]).max())
                    for k, variable in enumerate(loop.plant.inputs)
                },
                "wanted_input": {
                    variable.name: _finite(np.abs(motion.wanted[:, k]).max())
                    for k, variable in enumerate(loop.plant.inputs)
                },
                **_actuators(loop, motion),
                "cut": {
                    name: {
                        "seconds": sum(cut.end - cut.begin for cut in cuts),
                        "spans": [
                            {"from": c.begin, "to": c.end, "end": "upper" if c.upper else "lower"}
                            for c in cuts
                        ],
                    }
                    for name, cuts in cuts_by_command(loop, motion).items()
                },
                "start_in_proved_set": in_proved_set(loop, motion),
                "left_the_box": left_box(loop, motion) is not None,
                "diverged": not motion.whole,
                "ended": motion.ended,
            }
            for motion in found.motions
        ],
        "notes": notes(found),
    }


def _actuators(loop: PlantLoop, motion: PlantMotion) -> dict[str, dict[str, list[float]]]:
    """Return the least and largest command of each blended actuator; nothing without a blend."""
    if loop.blend is None:
        return {}
    low, high = motion.acting.min(axis=0), motion.acting.max(axis=0)
    pairs = zip(loop.blend.blending.actuators, low, high, strict=True)
    return {"actuators": {a.name: [float(least), float(most)] for a, least, most in pairs}}


def _start(loop: PlantLoop, given: Mapping[str, float]) -> Start:
    own = [variable.name for variable in loop.plant.states]
    for name in given:
        if name not in own:
            raise ModelError(
                f"start {name}: there is no such state{did_you_mean(name, own)}; the plant has "
                f"{', '.join(own)}"
            )
    x = np.array([given.get(name, rest) for name, rest in zip(own, loop.state, strict=True)])
    return _words(loop, x - loop.state), x - loop.state


def _values(values: Mapping[str, Fraction]) -> str:
    return ", ".join(f"{name} = {float(value):.4g}" for name, value in values.items())


def _words(loop: PlantLoop, deviation: Floats) -> str:
    """Return the states off rest with their values themselves, in the units of the file."""
    parts = []
    for variable, rest, off in zip(loop.plant.states, loop.state, deviation, strict=True):
        if off:
            parts.append(f"{variable.name} {in_file_units(variable, float(rest + off))}")
    return ", ".join(parts) or "rest"


def _number(value: float) -> float | None:
    return None if np.isnan(value) else value


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


MOST_PANELS = 12
_SHADE = "#f3d9c8"


def simulated_figures(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> dict[str, str]:
    """Return name -> SVG: the responses over time and, for two states or more, planes of states."""
    about = f"{loop.plant.name}, simulated"
    found = {
        "responses": figure_to_svg(
            simulated_responses(loop, motions, scenario),
            name="figure-responses",
            description=f"{about}: states, inputs and disturbances over time",
        )
    }
    if planes(loop):
        found["phase"] = figure_to_svg(
            phase_figure(loop, motions),
            name="figure-phase",
            description=f"{about}: motions in planes of two states",
        )
    return {name: f"{svg}\n" for name, svg in found.items()}


def simulated_responses(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> Figure:
    """Return one panel per state, input, actuator and disturbance that moves, and one for V.

    Values themselves, not deviations, in the units of the plant's file.  Dotted: where a state
    rests.  Dashed: ends of a range.  Shaded: where a command was cut in any of the runs.
    """
    panels = _panels(loop, motions, scenario)[:MOST_PANELS]

    def finish(axes: Axes, k: int) -> None:
        if k == len(panels):
            axes.axhline(1.0, color=GREY, lw=0.9, ls="--")
            return
        _, series, ends, rest, command, _ = panels[k]
        if rest is not None:
            axes.axhline(rest, color=GREY, lw=0.7, ls=":")
        _limits(axes, series, ends)
        if command is not None:
            _cuts(axes, motions, command)

    shown = [Panel(label, series, held) for label, series, *_, held in panels]
    return motions_figure(motions, shown, finish, height=1.35, legend_columns=2)


def simulated_csv(loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario) -> str:
    """Return the numbers that the figure shows; at a jump there are two rows with one time.

    States and inputs themselves in the units of the file; ``wanted`` is a command before the cut.
    """
    parts = _panels(loop, motions, scenario)
    n, m = len(loop.names), len(loop.plant.inputs)
    uncut_commands = [f"{v.name} wanted [{file_unit(v)[1]}]" for v in loop.plant.inputs if v.range]
    heads = ["run [-]", "time [s]", *(label.replace("\n", " ") for label, *_ in parts)]
    heads[2 + n + m : 2 + n + m] = uncut_commands
    valued = bool(motions[0].value.size)
    rows: list[Floats] = []
    for k, motion in enumerate(motions):
        columns = [np.full(len(motion.time), k + 1), motion.time]
        columns += [series[k] for _, series, *_ in parts]
        columns[2 + n + m : 2 + n + m] = [
            motion.wanted[:, j] / file_unit(v)[0]
            for j, v in enumerate(loop.plant.inputs)
            if v.range
        ]
        columns += [motion.value] if valued else []
        rows.append(np.column_stack(columns))
    heads += ["V/level [-]"] * valued
    return numbers_csv(heads, np.concatenate(rows))


# Label, one series for each motion, ends of the range, rest, number of the command, held or not.
_Panel = tuple[str, list[Floats], tuple[float, float] | None, float | None, int | None, bool]


def _panels(
    loop: PlantLoop, motions: Sequence[PlantMotion], scenario: PlantScenario
) -> list[_Panel]:
    held = loop.discrete or scenario.sample_time is not None

    def panel(
        variable: Variable,
        values: Sequence[Floats],
        *,
        rest: float | None = None,
        command: int | None = None,
    ) -> _Panel:
        side, (size, unit) = variable.range, file_unit(variable)
        ends = None if side is None else (float(side.lower) / size, float(side.upper) / size)
        shown_rest = None if rest is None else rest / size
        series = [each / size for each in values]
        steps = loop.discrete if command is None else held
        return f"{variable.name}\n[{unit}]", series, ends, shown_rest, command, steps

    commanded = [(v, [motion.input[:, k] for motion in motions])
                 for k, v in enumerate(loop.plant.inputs)]  # fmt: skip
    for k, actuator in enumerate(() if loop.blend is None else loop.blend.blending.actuators):
        commanded.append((actuator.variable, [motion.acting[:, k] for motion in motions]))
    return [
        *(
            panel(v, [rest + motion.state[:, k] for motion in motions], rest=rest)
            for k, (v, rest) in enumerate(zip(loop.plant.states, loop.state, strict=True))
        ),
        *(panel(v, values, command=k) for k, (v, values) in enumerate(commanded)),
        *(
            panel(v, [motion.disturbance[:, k] for motion in motions])
            for k, v in enumerate(moving_disturbances(scenario, loop.plant))
        ),
    ]


def _limits(axes: Axes, series: Sequence[Floats], ends: tuple[float, float] | None) -> None:
    """Draw the ends of a range that are close to the series; others would flatten the curves."""
    if ends is None:
        return
    values = np.concatenate([one[np.isfinite(one)] for one in series])
    if not values.size:
        return
    low, high = float(values.min()), float(values.max())
    near = 0.6 * (high - low)
    for end in ends:
        if low - near <= end <= high + near:
            axes.axhline(end, color=GREY, lw=0.9, ls="--")


def _cuts(axes: Axes, motions: Sequence[PlantMotion], command: int) -> None:
    for motion in motions:
        for cut in motion.cuts:
            if cut.command == command:
                axes.axvspan(cut.begin, cut.end, color=_SHADE, lw=0, zorder=0)
