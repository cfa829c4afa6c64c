"""The nonlinear plant under its law, from inside the proved ellipsoid: simulations, not proofs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from fractions import Fraction
from functools import partial
from itertools import product

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant, Variable
from takagi.models.plant_simulation.runs import (
    COMPLETE,
    Commands,
    Cut,
    Experiment,
    ExperimentRun,
    SampledProgram,
    right_side,
    run,
)
from takagi.models.plant_simulation.signals import Signals
from takagi.reports.code.controller_program import Call, ControllerProgram
from takagi.reports.code.run import ProgramRun, value_of
from takagi.reports.loops.plant_loop import ObservedMotion, PlantLoop
from takagi.reports.page.text import name_of

# A start lies this far out in the ellipsoid, as a share of its level, or of the box without one.
INSIDE, SHARE = 0.98, 0.3
FEWEST_STEPS, STEPS = 20, 300
# The slowest pole has decayed to e^-7, a thousandth.
TIMES = 7.0
LONGEST = 1e3
# A motion is ended at this multiple of the box (or ellipsoid) size.
FAR = 20.0
# The number of corners doubles with each uncertain parameter.
MOST_ENDS = 4


@dataclass(frozen=True, slots=True, eq=False)
class PlantMotion:
    """One motion of the loop.

    Attributes
    ----------
    name : where it starts, in words.
    time : (k,) [s], or steps times the sample time.
    state : (k, n), deviations x - x* in SI units.
    input : (k, m), u itself, as it acts: cut at the ends of the inputs' ranges.
    value : (k,) V / level; empty where there is no proved function or no level.
    whole : False if the motion diverged, or reached a state where the plant is undefined.
    acting : (k, 2), the commands of the two actuators of a blend, cut likewise; empty without one.
    disturbance : (k, p), those of the disturbances that move, themselves in SI.
    wanted : (k, m), the command before it is cut.
    cuts : when a command was beyond its range; commands are numbered as the inputs, then the
        actuators of a blend.
    ended, missed : see ``takagi.models.plant_simulation.runs.ExperimentRun``.
    rest : (n,), the deviation at which it comes to rest, if that is not 0: the last state of a
        motion after a jump of a reference; empty for 0.
    estimate : (k, n) of the deviations, by a law with outputs; empty for one of all states.
    """

    name: str
    time: Floats
    state: Floats
    input: Floats
    value: Floats
    whole: bool = True
    acting: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    _: KW_ONLY
    disturbance: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    wanted: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    cuts: tuple[Cut, ...] = ()
    ended: str = COMPLETE
    missed: int = 0
    rest: Floats = field(default_factory=lambda: np.zeros(0))
    estimate: Floats = field(default_factory=lambda: np.zeros((0, 0)))


def starts(loop: PlantLoop) -> list[tuple[str, Floats]]:
    """Return (words, deviation): for each state the point of the ellipsoid where it is largest.

    Without a proved ellipsoid each boxed state starts at a share of its box, all others at rest.
    """
    n = len(loop.names)
    if loop.bounded:
        P, level = loop.start_ellipsoid
        inverse = np.linalg.inv(P)
        size = np.sqrt(INSIDE * level)
        return [
            (f"{name} largest", size * inverse[j] / np.sqrt(inverse[j, j]))
            for j, name in enumerate(loop.names)
        ]
    reach = _box(loop)
    return [
        (f"{name} = {SHARE * reach[j]:.3g}", SHARE * reach[j] * np.eye(n)[j])
        for j, name in enumerate(loop.names)
    ]


def around(loop: PlantLoop, count: int) -> list[tuple[str, Floats]]:
    """Return ``count`` starts around the ellipse (or box) of the first two states, others 0."""
    n = len(loop.names)
    shape: Floats = np.diag(SHARE * _box(loop))[:, :2]
    if loop.bounded:
        P, level = loop.start_ellipsoid
        root = np.linalg.cholesky(np.linalg.inv(P[:2, :2])) * np.sqrt(INSIDE * level)
        shape = np.eye(n)[:, :2] @ root
    turns = 2 * np.pi * (np.arange(count) + 0.5) / count
    return [("around", shape @ np.array([np.cos(a), np.sin(a)])) for a in turns]


def motions(
    loop: PlantLoop,
    begin: Sequence[tuple[str, Floats]],
    *,
    duration: float | None = None,
    outside: Outside | None = None,
    uncertain: Mapping[str, Fraction] | None = None,
) -> tuple[PlantMotion, ...]:
    """Return the motions from the given deviations, all over the same time [s].

    Parameters
    ----------
    outside : disturbances that move, noise, and a law in samples; None for none of them.
    uncertain : uncertain parameter or other signal -> its value in these motions; others rest.

    Raises
    ------
    ModelError : more samples than can be simulated.
    """
    end = horizon(loop) if duration is None else duration
    experiment = experiment_of(loop, outside or Outside(), uncertain=uncertain)
    simulated = []
    for name, deviation in begin:
        x0 = np.asarray(deviation, float)
        limited = replace(experiment, far_limits=_far(loop, x0))
        begin_of_law = np.zeros(0)
        if loop.observed is not None and limited.program is None:
            begin_of_law = loop.observed.start(x0)
        simulated.append(_motion(loop, name, run(limited, np.concatenate([x0, begin_of_law]), end)))
    return tuple(simulated)


@dataclass(frozen=True, slots=True, eq=False)
class Outside:
    """Disturbances and references of a loop, and how its law runs.

    Attributes
    ----------
    moving : the disturbances that move, and ``disturbances`` their deviations, in that order.
    noise : on the measured states; None for none.
    program : makes the law in samples of ``sample_time`` [s]; None for continuous time.
    """

    moving: tuple[Variable, ...] = ()
    disturbances: Signals | None = None
    noise: Signals | None = None
    program: Callable[[], SampledProgram] | None = None
    sample_time: float | None = None


def experiment_of(
    loop: PlantLoop, outside: Outside, *, uncertain: Mapping[str, Fraction] | None = None
) -> Experiment:
    """Return the loop as an experiment, see ``motions``."""
    # A program sends the commands of blended actuators too, and they are held like the others.
    with_actuators = loop.blend is not None and outside.program is not None
    rate = right_side(loop.plant, outside.moving, fixed=uncertain, told=with_actuators)
    n = len(loop.names)
    limits = [_ends(v) for v in loop.plant.inputs]
    if loop.blend is not None:
        limits += [_ends(a.variable) for a in loop.blend.blending.actuators]
    observed, law_rate = loop.observed, None
    if outside.program is None and observed is not None:
        law_rate = partial(_following, loop.state, observed)
    return Experiment(
        rate=rate,
        commands=_commands(loop, outside.moving),
        law_rate=law_rate,
        inputs=len(limits) if with_actuators else len(loop.plant.inputs),
        limits=np.array(limits, dtype=np.float64).reshape(-1, 2),
        rest=loop.state,
        far_limits=np.full(n, np.inf),
        disturbances=outside.disturbances or Signals(0),
        disturbance_rest=np.array([float(v.rest) for v in outside.moving]),
        noise=outside.noise or Signals(n),
        program=outside.program,
        step=loop.model.sample_time if loop.discrete else outside.sample_time,
        discrete=loop.discrete,
    )


def _following(rest: Floats, observed: ObservedMotion, z: Floats, u: Floats) -> Floats:
    """Return how the estimate of a law with measured outputs moves, at (x - x*, estimate) and u."""
    n = len(rest)
    return observed.following(rest + z[:n], z[n:], u)


def _commands(loop: PlantLoop, moving: Sequence[Variable]) -> Commands:
    """Return (x - x*, w) -> the commands of the law; it measures the signals of its premises.

    A law with measured outputs has its estimate behind x - x*.
    """
    observed, n = loop.observed, len(loop.names)
    if observed is not None:
        return lambda z, _: observed.command(loop.state + z[:n], z[n:])
    rests = [float(v.rest) for v in moving]
    positions = {v.name: k for k, v in enumerate(loop.plant.disturbances)}
    labels = [name_of(label) for label in loop.model.disturbances]
    scheduled = [labels[positions[v.name]] if v.schedules else None for v in moving]

    def commands(deviation: Floats, w: Floats) -> Floats:
        signals = {
            name: float(value - rest)
            for name, value, rest in zip(scheduled, w, rests, strict=True)
            if name is not None
        }
        command = loop.command(deviation, signals)
        if loop.blend is None:
            return command
        return np.concatenate([command, loop.blend.commands(loop.state + deviation)])

    return commands


def _ends(variable: Variable) -> tuple[float, float]:
    side = variable.range
    return (-np.inf, np.inf) if side is None else (float(side.lower), float(side.upper))


def uncertain_ends(plant: Plant) -> list[dict[str, Fraction]]:
    """Return values of the uncertain parameters at the corners of their ranges; [] without any.

    With many parameters: all at their lower, and all at their upper ends.
    """
    ends = {v.name: (v.range.lower, v.range.upper) for v in plant.uncertain if v.range is not None}
    if not ends:
        return []
    if 2 ** len(ends) > MOST_ENDS:
        return [{name: pair[k] for name, pair in ends.items()} for k in (0, 1)]
    return [dict(zip(ends, corner, strict=True)) for corner in product(*ends.values())]


def horizon(loop: PlantLoop, *, longest: float = LONGEST) -> float:
    """Return the duration [s] in which the slowest pole at equilibrium decays to a thousandth.

    Parameters
    ----------
    longest : s, where that would take longer, in continuous time.
    """
    matrices, K = loop.at_rest()
    poles = np.linalg.eigvals(matrices.A if K is None else matrices.A - matrices.B @ K)
    if loop.observed is not None:
        poles = loop.observed.poles_at(loop.memberships(np.zeros(len(loop.names))))
    step = loop.model.sample_time
    rates = -np.real(poles) if step is None else -np.log(np.maximum(np.abs(poles), 1e-9)) / step
    moving = np.abs(rates)[np.abs(rates) > 1e-6]
    settled = TIMES / float(moving.min()) if moving.size else 10.0
    if step is None:
        return min(settled, longest)
    # Poles near 0 settle within a sample, the nonlinear loop does not.
    return min(max(settled, FEWEST_STEPS * step), STEPS * step)


def settling_time(motion: PlantMotion, share: float = 0.01) -> float:
    """Return when every state stays within a share of the largest deviation it has had [s].

    nan if it does not.
    """
    size = np.abs(motion.state - motion.rest if motion.rest.size else motion.state)
    late = np.flatnonzero(np.any(size > share * size.max(axis=0), axis=1))
    if not motion.whole or (late.size and late[-1] == len(size) - 1):
        return float("nan")
    return float(motion.time[late[-1] + 1]) if late.size else 0.0


def _motion(loop: PlantLoop, name: str, result: ExperimentRun) -> PlantMotion:
    m, n = len(loop.plant.inputs), len(loop.names)
    state, estimate = result.state[:, :n], result.state[:, n:]
    value = _level(loop, state, estimate)
    acting = result.sent[:, m:] if loop.blend is not None else np.zeros((0, 2))
    return PlantMotion(
        name,
        result.time,
        state,
        result.sent[:, :m],
        value,
        result.ended == COMPLETE,
        acting,
        disturbance=result.disturbance,
        wanted=result.commanded[:, :m],
        cuts=result.cuts,
        ended=result.ended,
        missed=result.missed,
        estimate=estimate if estimate.size else np.zeros((0, 0)),
    )


def _level(loop: PlantLoop, state: Floats, estimate: Floats) -> Floats:
    """Return V / level (k,); empty where none is proved, or where V needs an estimate.

    Of a law with measured outputs V is proved of plant and estimate, and a program in samples keeps
    its estimate to itself.
    """
    if not loop.bounded:
        return np.zeros(0)
    P, level = loop.ellipsoid
    if loop.observed is None:
        return np.asarray(np.einsum("ki,ij,kj->k", state, P, state) / level)
    if loop.observed.P is None or not estimate.size:
        return np.zeros(0)
    z = loop.observed.coordinates(state, estimate)
    return np.asarray(np.einsum("ki,ij,kj->k", z, loop.observed.P, z) / level)


def _box(loop: PlantLoop) -> Floats:
    """Return how far each state may go from rest [SI]; 1 where the box leaves it out."""
    sides = [loop.model.box.get(label) for label in loop.model.states]
    return np.array([1.0 if s is None else min(abs(float(e)) for e in s) or 1.0 for s in sides])


def _far(loop: PlantLoop, x0: Floats) -> Floats:
    """Return per state the deviation at which a motion is ended."""
    reach = np.maximum(_box(loop), np.linalg.norm(x0) / np.sqrt(len(x0)))
    if loop.bounded:
        P, level = loop.ellipsoid
        reach = np.maximum(reach, np.sqrt(level * np.diag(np.linalg.inv(P))))
    return np.asarray(FAR * reach, dtype=np.float64)


class ProgramLaw:
    """One run of a program, sample by sample.

    Parameters
    ----------
    moving : the disturbances of the signals that ``sample`` is given, in that order.
    sample_time : [s].

    Raises
    ------
    ModelError : the program is not of this plant.

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
            formula = assignment.formula
            if isinstance(formula, Call) and formula.function == "limit":
                formula = formula.arguments[0]
            self.formulas[assignment.name] = formula
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
