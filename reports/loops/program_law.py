"""The program of a plant's gain file as a law in samples: what a controller would run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.code.formula import Call, Formula
from takagi.reports.code.run import ProgramRun, value_of

if TYPE_CHECKING:
    from takagi.models.plant.variables import Variable
    from takagi.reports.code.controller_program import ControllerProgram
    from takagi.reports.loops.plant_loop import PlantLoop


class ProgramLaw:
    """One run of a program, sample by sample.

    Parameters
    ----------
    moving : the disturbances of the signals that ``sample`` is given, in that order.
    sample_time : [s].

    Raises
    ------
    ModelError : the program is not of this plant, or one that keeps an effort for two actuators.
    """

    def __init__(
        self,
        program: ControllerProgram,
        loop: PlantLoop,
        moving: Sequence[Variable],
        sample_time: float,
    ) -> None:
        if program.kept:
            raise ModelError(
                f"the program of {program.name} keeps {program.kept[0].name} from sample to "
                "sample; a law in samples is simulated for plants without [blending]: leave "
                "--sample-time out"
            )
        self.run, self.loop, self.step = ProgramRun(program), loop, sample_time
        self.moving = [v.name for v in moving]
        self.formulas = {}
        for one in program.assignments:
            self.formulas[one.name] = _before_limit(one.formula)
        outputs = [v.name for v in loop.plant.inputs]
        known = {*loop_states(loop), *(v.name for v in loop.plant.disturbances)}
        missing = [name for name in outputs if name not in self.formulas]
        missing += [one.name for one in program.inputs if one.name not in known]
        if missing:
            raise ModelError(
                f"the gain file's program is of another plant: {missing[0]} is not the same "
                "there; give the gain file of this plant"
            )
        self.outputs = outputs
        self.rests = {one.name: float(one.rest or 0) for one in program.inputs}
        self.missed, self.last = 0, loop.input

    def sample(self, state: Floats, signals: Floats) -> Floats:
        """Return the command before it is limited.

        Where a formula has no value the last one is kept, at first the rest of the inputs: so does
        the code that `takagi export` writes.
        """
        named = dict(zip(loop_states(self.loop), self.loop.state + state, strict=True))
        named |= dict(zip(self.moving, signals, strict=True))
        given = {name: float(named.get(name, rest)) for name, rest in self.rests.items()}
        try:
            self.run.sample(self.step, given)
            values = [value_of(self.formulas[name], self.run.names) for name in self.outputs]
        except ModelError:
            raise
        except (ArithmeticError, ValueError):
            values = [np.nan]
        if np.all(np.isfinite(values)):
            self.last = np.array(values)
        else:
            self.missed += 1
        return self.last


def loop_states(loop: PlantLoop) -> list[str]:
    """Return the names of the plant's states."""
    return [v.name for v in loop.plant.states]


def _before_limit(formula: Formula) -> Formula:
    match formula:
        case Call("limit", (inner, *_)):
            return inner
    return formula
