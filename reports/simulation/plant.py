"""The nonlinear plant under a law, from chosen starts: tables, figures and results."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

Start = tuple[str, Floats]
# The number of corners of a box doubles with each state.
MOST_CORNERS = 16
# A deviation of this share of its start counts as settled.
SETTLED = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class PlantSimulation:
    """Motions of the loop, and the loop itself.  A simulation proves nothing.

    ``scale`` : how far the corners of the box were drawn in, so that they lie in the ellipsoid of
    the certificate's function; 1 for starts that were given.
    """

    loop: PlantLoop
    motions: tuple[PlantMotion, ...]
    scale: float = 1.0

    @property
    def all_ended(self) -> bool:
        """Whether no motion went to infinity."""
        return all(motion.whole for motion in self.motions)


def simulate_plant(
    design: PlantDesign,
    *,
    starts: Sequence[Mapping[str, float]] | None = None,
    duration: float | None = None,
) -> PlantSimulation:
    """Return the motions of the plant itself under the design's law, disturbances at rest.

    Parameters
    ----------
    starts : state -> value in SI, not named ones at rest; None takes the corners of the box, drawn
        in to the ellipsoid of the certificate's function.
    duration : in s; None takes some time constants of the slowest pole.

    Raises
    ------
    ModelError : a state that the plant does not have, or a duration that is not positive.
    """
    from takagi.reports.loops.plant_loop import plant_loop
    from takagi.reports.loops.plant_motion import motions

    if duration is not None and not 0 < duration < np.inf:
        raise ModelError(f"duration = {duration:g} s was given; it must be positive")
    loop = plant_loop(design)
    if starts is None:
        begin, scale = corner_starts(loop)
    else:
        begin, scale = [_start(loop, given) for given in starts], 1.0
    return PlantSimulation(loop, motions(loop, begin, duration=duration), scale)


def corner_starts(loop: PlantLoop) -> tuple[list[Start], float]:
    """Return the corners of the box, drawn in by one factor to the ellipsoid, and the factor.

    A state without a range starts at rest.  Where there is no ellipsoid, the factor is 1.
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
            "from; give starts"
        )
    scale = 1.0
    if loop.bounded:
        P, level = loop.start_ellipsoid
        worst = max(float(corner @ P @ corner) for corner in corners)
        scale = min(1.0, float(np.sqrt(level / worst)))
    return [(_words(loop, scale * corner), scale * corner) for corner in corners], scale


def simulation_files(found: PlantSimulation) -> dict[str, bytes | str]:
    """Return relative name -> content: ``responses.csv``, ``simulation.json``, ``figures/``."""
    from takagi.reports.figures.plant.captioned import captioned_motion_figures

    drawn = captioned_motion_figures(found.loop, found.motions)
    files: dict[str, bytes | str] = {
        "responses.csv": drawn.data["responses.csv"],
        "simulation.json": json.dumps(simulation_data(found), indent=2) + "\n",
    }
    for plate in drawn.plates:
        files[f"figures/{plate.name}.svg"] = plate.file
    return files


def simulation_data(found: PlantSimulation) -> dict[str, Any]:
    """Return one row per motion as plain data; deviations from rest, SI."""
    from takagi.reports.loops.plant_motion import settling_time

    loop = found.loop
    return {
        "plant": loop.plant.name,
        "scale": found.scale,
        "runs": [
            {
                "start": dict(zip(loop.names, map(float, motion.state[0]), strict=True)),
                "end": dict(zip(loop.names, map(float, motion.state[-1]), strict=True)),
                "duration": float(motion.time[-1]),
                "settled_after": _number(settling_time(motion, SETTLED)),
                "largest_input": {
                    variable.name: float(np.abs(motion.input[:, k]).max())
                    for k, variable in enumerate(loop.plant.inputs)
                },
                **_actuators(loop, motion),
                "left_the_box": _left(loop, motion),
                "diverged": not motion.whole,
            }
            for motion in found.motions
        ],
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
                f"start {name}: there is no such state; the plant has {', '.join(own)}"
            )
    x = np.array([given.get(name, rest) for name, rest in zip(own, loop.state, strict=True)])
    return _words(loop, x - loop.state), x - loop.state


def _words(loop: PlantLoop, deviation: Floats) -> str:
    parts = zip(loop.names, deviation, strict=True)
    return ", ".join(f"{name} {value:.3g}" for name, value in parts if value) or "rest"


def _number(value: float) -> float | None:
    return None if np.isnan(value) else value


def _left(loop: PlantLoop, motion: PlantMotion) -> bool:
    for k, label in enumerate(loop.model.states):
        side = loop.model.box.get(label)
        if side is not None:
            low, high = (float(end) for end in side)
            slack = 1e-9 * (high - low)
            if np.any((motion.state[:, k] < low - slack) | (motion.state[:, k] > high + slack)):
                return True
    return False
