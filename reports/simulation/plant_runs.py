"""The runs of a simulated plant, and quantities that are computed from them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.simulation.plant_scenario import PlantScenario

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.variables import Variable
    from takagi.models.plant_simulation.experiment import Cut
    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

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
    return bool(motion.value[0] <= 1 + 1e-9)


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
