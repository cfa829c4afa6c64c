"""The program of a plant's gain file as a law in samples: what a controller would run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import Call, Formula
from takagi.reports.code.run import ProgramRun, value_of

if TYPE_CHECKING:
    from takagi.models.plant.plant import Variable
    from takagi.reports.code.controller_program import ControllerProgram
    from takagi.reports.loops.plant_loop import PlantLoop


class ProgramLaw:
    """One run of a program, sample by sample.

    moving : the disturbances of the signals that ``sample`` is given, in that order.
    sample_time : [s].

    Raises ModelError: the program is not of this plant.

    The program of a blended plant keeps the effort from sample to sample; it begins with the effort
    of the state that it is given first, and sends the commands of both actuators.
    """

    def __init__(
        self,
        program: ControllerProgram,
        loop: PlantLoop,
        moving: Sequence[Variable],
        sample_time: float,
    ) -> None:
        self.run, self.loop, self.step = ProgramRun(program), loop, sample_time
        self.moving = [v.name for v in moving]
        self.formulas = {}
        for assignment in program.assignments:
            self.formulas[assignment.name] = _before_limit(assignment.formula)
        blended = () if loop.blend is None else loop.blend.blending.actuators
        rates = {rate for _, rate in loop.plant.integrators}
        outputs = [
            # A controller's program computes the rates of its states, and sends them to nobody.
            f"{v.name}_wanted" if v.name in rates else v.name
            for v in (*loop.plant.inputs, *(a.variable for a in blended))
        ]
        self.measured = {signal.name: _output_of(signal.name, loop) for signal in program.inputs}
        available = {*loop_states(loop), *(v.name for v in loop.plant.disturbances)}
        available |= {name for name, index in self.measured.items() if index is not None}
        missing = [name for name in outputs if name not in self.formulas]
        missing += [signal.name for signal in program.inputs if signal.name not in available]
        if missing:
            raise ModelError(
                f"the gain file's program is of another plant: {missing[0]} is not the same "
                "there; give the gain file of this plant"
            )
        self.outputs = outputs
        self.rests = {signal.name: float(signal.rest or 0) for signal in program.inputs}
        self.missed, self.last = 0, loop.input
        if loop.blend is not None:
            self.last = np.concatenate([loop.input, loop.blend.at_rest])

    def sample(self, state: Floats, signals: Floats) -> Floats:
        """Return the command before it is limited.

        Where a formula has no value the last one is kept, at first the rest of the inputs: so does
        the code that `takagi export` writes.
        """
        named = dict(zip(loop_states(self.loop), self.loop.state + state, strict=True))
        named |= dict(zip(self.moving, signals, strict=True))
        named |= self._seen(state)
        inputs = {name: float(named.get(name, rest)) for name, rest in self.rests.items()}
        if self.loop.blend is not None and self.run.program.kept and not self.run.kept:
            # The effort, the last of the states: no other value is kept by a law by rules.
            effort = float(self.loop.state[-1] + state[-1])
            self.run.kept = {variable.name: effort for variable in self.run.program.kept}
        try:
            self.run.sample(self.step, inputs)
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

    def _seen(self, state: Floats) -> dict[str, float]:
        """Return the measured outputs by the program's names for them; u as it was sent last."""
        observed = self.loop.observed
        if observed is None:
            return {}
        limits = [v.range for v in self.loop.plant.inputs]
        sent = np.array(
            [
                value if side is None else min(max(value, float(side.lower)), float(side.upper))
                for value, side in zip(self.last, limits, strict=True)
            ]
        )
        y = observed.outputs(self.loop.state + state, sent)
        return {name: float(y[index]) for name, index in self.measured.items() if index is not None}


def _output_of(name: str, loop: PlantLoop) -> int | None:
    """Return which measured output an input of the program is; None for another signal."""
    measured = loop.plant.measured or ()
    bare = name.rstrip("_").removesuffix("_measured")
    return measured.index(bare) if bare in measured and bare != name else None


def loop_states(loop: PlantLoop) -> list[str]:
    """Return the names of the plant's states."""
    return [v.name for v in loop.plant.states]


def _before_limit(formula: Formula) -> Formula:
    match formula:
        case Call("limit", (inner, *_)):
            return inner
    return formula
