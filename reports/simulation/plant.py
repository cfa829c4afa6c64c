"""The nonlinear plant under a law, from chosen starts: tables, figures and results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.plant.plant import in_file_units
from takagi.models.plant_simulation.runs import SampledProgram
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
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
from takagi.reports.simulation.plant_figures import simulated_csv, simulated_figures
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
