"""One simulation of a plant: LSODA integrates from one jump of a signal to the next.

Within a segment everything is continuous, so the integrator's error control is valid.  Where a
command reaches an end of its range, the right-hand side has a kink; the integrator finds this time
as an event.  ``cuts`` lists the spans in which a command is limited.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import rational
from takagi.models.plant.plant import explicit_rows
from takagi.models.plant_simulation.signals import Signals

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant, Variable


Rate = Callable[[Floats, Floats, Floats], Floats]


def right_side(
    plant: Plant,
    moving: Sequence[Variable] = (),
    *,
    fixed: Mapping[str, Fraction] | None = None,
    told: bool = False,
) -> Rate:
    """Return (x, u, w) -> x' of the plant, or x(t + T) in discrete time; all in SI.

    A blended plant is evaluated by the equations that its file states, with its two actuators,
    each limited to its range; the last entry of u is then the rate of the effort.

    Parameters
    ----------
    moving : the disturbances in w, in the order of w; all others keep their rest values.
    fixed : name -> value of disturbances, such as uncertain parameters, that replaces the rest
        value; not for a blended plant.
    told : for a blended plant, whether the last entries of u are the commands of its two
        actuators; if not, the commands follow from the state.
    """
    from takagi.models.blending.blending import RunTimeBlending, blending_of

    blending = blending_of(plant)
    if blending is not None:
        return RunTimeBlending(blending).disturbed_rate(moving, told=told)
    free = [v.symbol for v in moving]
    values = plant.rationals
    values |= {
        v.symbol: rational((fixed or {}).get(v.name, v.rest))
        for v in plant.disturbances
        if v.symbol not in free
    }
    symbols = [*(v.symbol for v in (*plant.states, *plant.inputs)), *free]
    right_sides = explicit_rows(plant, symbols, values)
    return lambda x, u, w: right_sides(*map(float, x), *map(float, u), *map(float, w))


# (measured x - x*, w) -> the inputs before their limits, then the commands of blended actuators.
Commands = Callable[[Floats, Floats], Floats]
# (measured x - x* and the law's states, u as it acts) -> the rate of the law's states, or the next.
LawRate = Callable[[Floats, Floats], Floats]


class SampledProgram(Protocol):
    """A sampled law with memory: it computes one command each sample time.

    ``missed`` : number of samples in which a formula had no value; the last command was kept.
    """

    missed: int

    def sample(self, state: Floats, signals: Floats) -> Floats:
        """Return the command, before limits, at a measured x - x* (n,) and signals w; SI."""
        ...


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Experiment:
    """A loop that is simulated from several starts, in SI units.

    States are deviations x - x* from rest, so that small deviations keep their digits where x
    itself is large, such as 350 K.  A law with states of its own, such as an observer, has them
    behind those of the plant.

    Attributes
    ----------
    rate : (x, u, w) -> x' of the values themselves, or x(t + step) in discrete time.
    commands : (measured x - x*, w) -> the commands before their limits: u (m,), then those of
        blended actuators.  ``rate`` computes the latter again itself.
    inputs : m, the number of inputs.
    limits : (number of commands, 2), the ends of each command's range; infinite where it has none.
    rest : x* (n,), the equilibrium.
    far_limits : (n,), the deviation from it at which a run ends.
    disturbances : w as deviations from ``disturbance_rest`` (p,).
    noise : on the measured states, (n,).
    program : returns a new sampled law for each run; None for a law in continuous time.
    step : sample time T [s] of the program or of a discrete-time plant; None if there is neither.
    discrete : whether the plant is in discrete time.
    law_rate : of a law with states of its own; None for other laws.
    """

    rate: Rate
    commands: Commands
    inputs: int
    limits: Floats
    rest: Floats
    far_limits: Floats
    disturbances: Signals
    disturbance_rest: Floats
    noise: Signals
    program: Callable[[], SampledProgram] | None = None
    step: float | None = None
    discrete: bool = False
    law_rate: LawRate | None = None

    def following(self, at: Floats, measured: Floats, commanded: Floats, w: Floats) -> Floats:
        """Return the rate of all states, or in discrete time the next ones, as deviations.

        Parameters
        ----------
        at, measured : all states, without and with noise.
        commanded : the commands before their limits.
        """
        u, n = self.held(commanded), len(self.rest)
        rates = self.rate(self.rest + at[:n], u, w)
        plant_rates = rates - self.rest if self.discrete else rates
        if self.law_rate is None:
            return plant_rates
        return np.concatenate([plant_rates, self.law_rate(measured, u)])

    def held(self, commanded: Floats) -> Floats:
        """Return the inputs (m,) that act: each command, limited to its range."""
        low, high = self.limits.T
        return np.asarray(np.clip(commanded, low, high)[: self.inputs], dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Cut:
    """A time span [s] in which a command is outside its range, so that the actuator saturates."""

    command: int
    begin: float
    end: float
    upper: bool


@dataclass(frozen=True, slots=True, eq=False)
class ExperimentRun:
    """One run.

    Attributes
    ----------
    time : (k,) [s]; at a jump there are two rows with one time.
    state : (k, n), x - x*; then the law's own states.
    commanded, sent : (k, number of commands), before and after the limits.
    disturbance : (k, p).
    cuts : the spans in which a command was limited, in the order of time.
    ended : "whole" for a complete run; "far" if a state went too far from rest; "undefined" if an
        equation or the law had no value; "stuck" if the integration failed.
    missed : number of samples in which the program had no value and kept its last command.
    """

    time: Floats
    state: Floats
    commanded: Floats
    sent: Floats
    disturbance: Floats
    cuts: tuple[Cut, ...]
    ended: str
    missed: int = 0


SAMPLES = 301
# Relative and absolute tolerance of LSODA.
RELATIVE, ABSOLUTE = 1e-7, 1e-9
# More segments than this take minutes.
MOST_SEGMENTS = 50_000
# Steps of a segment for each of its output times; a motion that slides into a pole of its equations
# takes shorter and shorter ones without end.
MOST_STEPS = 200
# Breaks that are closer together than this share of the run count as one.
_TOGETHER = 1e-12
COMPLETE, LEFT_RANGE, UNDEFINED, STUCK = "whole", "far", "undefined", "stuck"


def run(experiment: Experiment, start: Floats, end: float) -> ExperimentRun:
    """Return the run over ``end`` [s] from a deviation x - x* (n,), and the law's own states.

    Raises
    ------
    ModelError : more samples or jumps than can be simulated in minutes.
    """
    record = _Record(experiment)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        # The integrator warns when it fails, and numpy when a formula has no value.  The warnings
        # are not needed: the run then ends, and its record states the reason.
        warnings.simplefilter("ignore")
        ended = _iterate(record, start, end) if experiment.discrete else _integrate(
            record, start, end
        )  # fmt: skip
    return record.finished(ended)


@dataclass
class _Record:
    """The results of a run up to now."""

    experiment: Experiment
    time: list[Floats] = field(default_factory=list)
    state: list[Floats] = field(default_factory=list)
    commanded: list[Floats] = field(default_factory=list)
    disturbance: list[Floats] = field(default_factory=list)
    cuts: list[Cut] = field(default_factory=list)
    missed: int = 0

    def add(self, time: Floats, state: Floats, commanded: Floats, disturbance: Floats) -> None:
        self.time.append(time)
        self.state.append(state)
        self.commanded.append(commanded)
        self.disturbance.append(disturbance)

    def cut(self, begin: float, end: float, commanded: Floats) -> None:
        """Record which commands are outside their range during the whole of a time span."""
        low, high = self.experiment.limits.T
        for k in np.flatnonzero((commanded < low) | (commanded > high)):
            self.cuts.append(Cut(int(k), begin, end, bool(commanded[k] > high[k])))

    def finished(self, ended: str) -> ExperimentRun:
        commanded = np.concatenate(self.commanded)
        low, high = self.experiment.limits.T
        return ExperimentRun(
            np.concatenate(self.time),
            np.concatenate(self.state),
            commanded,
            np.clip(commanded, low, high),
            np.concatenate(self.disturbance),
            _joined(self.cuts),
            ended,
            self.missed,
        )


def _joined(cuts: list[Cut]) -> tuple[Cut, ...]:
    """Return the spans; spans that touch are joined."""
    spans: list[Cut] = []
    open_: dict[tuple[int, bool], int] = {}
    for cut in cuts:
        at = open_.get((cut.command, cut.upper))
        # One span may be found in two segments of the integration, whose times differ by rounding.
        if at is not None and cut.begin - spans[at].end <= 1e-9 * max(1e-3, cut.end):
            spans[at] = Cut(cut.command, spans[at].begin, cut.end, cut.upper)
        else:
            open_[cut.command, cut.upper] = len(spans)
            spans.append(cut)
    return tuple(spans)


def _integrate(record: _Record, start: Floats, end: float) -> str:
    experiment = record.experiment
    program = None if experiment.program is None else experiment.program()
    grid = np.linspace(0.0, end, SAMPLES)
    x, held_command = np.asarray(start, dtype=np.float64), np.zeros(0)
    for begin, stop, is_sample in _segments(experiment, end):
        segment = _Segment(experiment, begin, stop)
        if program is not None and is_sample:
            held_command = segment.sampled(program, x)
            record.missed = program.missed
        inside = grid[(grid > begin) & (grid < stop)]
        ended, x = segment.integrate(record, x, None if program is None else held_command, inside)
        if ended != COMPLETE:
            return ended
    return COMPLETE


def _lsoda(step_limit: int) -> Any:
    """Return scipy's LSODA, which fails after this number of steps."""
    from scipy.integrate import LSODA

    class LimitedLsoda(LSODA):
        steps = 0

        def step(self) -> str | None:
            self.steps += 1
            if self.steps > step_limit:
                self.status = "failed"
                return f"{step_limit} steps were not enough"
            return super().step()

    return LimitedLsoda


def _segments(experiment: Experiment, end: float) -> Iterator[tuple[float, float, bool]]:
    """Yield (begin, stop, whether the program computes at ``begin``)."""
    step = experiment.step if experiment.program is not None else None
    times = experiment.disturbances.breaks(end) + experiment.noise.breaks(end)
    # A duration that is a multiple of the sample time must not get one more sample by rounding.
    samples = int(np.ceil(end / step - 1e-9)) if step is not None else 0
    if len(times) + samples > MOST_SEGMENTS:
        raise ModelError(
            f"the run of {end:g} s has {len(times) + samples} samples and jumps of signals; at "
            f"most {MOST_SEGMENTS} are simulated: take a shorter duration, a longer sample time, "
            "or hold values of noise for longer"
        )
    together = _TOGETHER * max(end, 1e-3)
    ours = [] if step is None else [k * step for k in range(samples)]
    marked = sorted([(t, 0) for t in ours] + [(t, 1) for t in times])
    breaks: list[tuple[float, bool]] = [(0.0, step is not None)]
    for time, program_acts in marked:
        if time - breaks[-1][0] > together and end - time > together:
            breaks.append((time, not program_acts))
        elif not program_acts and time <= end - together:
            breaks[-1] = (breaks[-1][0], True)
    edges = [*breaks, (end, False)]
    for (begin, sampled), (stop, _) in pairwise(edges):
        yield begin, stop, sampled


class _Segment:
    """A part of the run without a jump of a signal."""

    def __init__(self, experiment: Experiment, begin: float, stop: float) -> None:
        self.experiment, self.begin, self.stop = experiment, begin, stop
        disturbance_change = experiment.disturbances.on(begin, stop)
        self.disturbance: Callable[[float], Floats] = lambda t: (
            experiment.disturbance_rest + disturbance_change(t)
        )
        self.noise = experiment.noise.on(begin, stop)
        self._last: tuple[float, Floats, Floats] | None = None

    def sampled(self, program: SampledProgram, x: Floats) -> Floats:
        """Return the program's command at the beginning."""
        return program.sample(self.measured(self.begin, x), self.disturbance(self.begin))

    def measured(self, time: float, x: Floats) -> Floats:
        """Return all states as the law has them: those of the plant with noise."""
        noise = self.noise(time)
        return np.concatenate([x[: len(noise)] + noise, x[len(noise) :]])

    def wanted(self, time: float, x: Floats, held_command: Floats | None) -> Floats:
        if held_command is not None:
            return held_command
        last = self._last
        if last is not None and last[0] == time and np.array_equal(last[1], x):
            return last[2]
        command = self.experiment.commands(self.measured(time, x), self.disturbance(time))
        self._last = (time, x.copy(), command)
        return command

    def integrate(
        self, record: _Record, x: Floats, held_command: Floats | None, inside: Floats
    ) -> tuple[str, Floats]:
        """Add the segment to the record; return how it ended, and the last state."""
        from scipy.integrate import solve_ivp

        experiment, disturbance = self.experiment, self.disturbance

        def slope(time: float, at: Floats) -> Floats:
            commanded = self.wanted(time, at, held_command)
            return experiment.following(at, self.measured(time, at), commanded, disturbance(time))

        def leaves(_: float, at: Floats) -> float:
            return float(np.min(experiment.far_limits - np.abs(at[: len(experiment.far_limits)])))

        leaves.terminal = True  # type: ignore[attr-defined]
        ends = [] if held_command is not None else self.ends(held_command)
        times = np.array([self.begin, *inside, self.stop])
        broke = False
        try:
            solution: Any = solve_ivp(
                slope, (self.begin, self.stop), x, method=_lsoda(MOST_STEPS * (len(times) + 10)),
                rtol=RELATIVE, atol=ABSOLUTE,
                t_eval=times, events=[leaves, *ends], dense_output=bool(ends),
            )  # fmt: skip
        except ModelError:
            raise
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            broke = True
        if broke or not solution.t.size or not np.all(np.isfinite(solution.y)):
            commanded = self.tried(x, held_command)
            record.add(
                np.array([self.begin]), x[None], commanded[None], disturbance(self.begin)[None]
            )
            return UNDEFINED, x
        states = solution.y.T
        commanded = np.array(
            [self.wanted(t, y, held_command) for t, y in zip(solution.t, states, strict=True)]
        )
        record.add(solution.t, states, commanded, np.array([disturbance(t) for t in solution.t]))
        if held_command is not None:
            record.cut(self.begin, float(solution.t[-1]), held_command)
        elif ends:
            crossed = np.concatenate(solution.t_events[1:])
            edges = np.unique(np.concatenate([solution.t, crossed[crossed <= solution.t[-1]]]))
            for begin, stop in pairwise(edges):
                middle = (begin + stop) / 2
                record.cut(begin, stop, self.wanted(middle, solution.sol(middle), held_command))
        ended = {0: COMPLETE, 1: LEFT_RANGE}.get(int(solution.status), STUCK)
        return ended, states[-1]

    def tried(self, x: Floats, held_command: Floats | None) -> Floats:
        try:
            return self.wanted(self.begin, x, held_command)
        except ModelError:
            raise
        except (ArithmeticError, ValueError):
            return np.full(len(self.experiment.limits), np.nan)

    def ends(self, held_command: Floats | None) -> list[Callable[[float, Floats], float]]:
        """Return a function for each end of a range, 0 where the command meets it."""
        events: list[Callable[[float, Floats], float]] = []
        for k, side in np.argwhere(np.isfinite(self.experiment.limits)):
            limit = float(self.experiment.limits[k, side])

            def meets(time: float, x: Floats, k: int = int(k), limit: float = limit) -> float:
                return float(self.wanted(time, x, held_command)[k] - limit)

            events.append(meets)
        return events


def _iterate(record: _Record, start: Floats, end: float) -> str:
    experiment = record.experiment
    step = experiment.step or 1.0
    count = max(int(np.ceil(end / step)), 1)
    if count > MOST_SEGMENTS:
        raise ModelError(
            f"the run of {end:g} s has {count} samples of {step:g} s; at most {MOST_SEGMENTS} are "
            "simulated: take a shorter duration"
        )
    x = np.asarray(start, dtype=np.float64)
    for k in range(count + 1):
        time = k * step
        # A jump within a sample takes effect at the next sample.
        soon = time + 1e-6 * step
        sample = _Segment(experiment, time, soon)
        w, measured = sample.disturbance(time), sample.measured(time, x)
        commanded, following = np.full(len(experiment.limits), np.nan), x
        try:
            commanded = experiment.commands(measured, w)
            if k < count:
                following = experiment.following(x, measured, commanded, w)
        except ModelError:
            raise
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            following = np.full(len(x), np.nan)
        record.add(np.array([time]), x[None], commanded[None], w[None])
        if not np.all(np.isfinite(following)):
            return UNDEFINED
        if k < count:
            record.cut(time, time + step, commanded)
        if np.any(np.abs(following[: len(experiment.far_limits)]) > experiment.far_limits):
            return LEFT_RANGE
        x = following
    return COMPLETE
