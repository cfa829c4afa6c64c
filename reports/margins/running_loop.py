"""The loop that runs, linearised: validation plant, observer and law at a steady wind, sampled.

The plant's own right-hand side is differenced at rest and held between samples by the matrix
exponential; the program (observer, filters, law) is differenced as it runs, sample by sample.  So
sampling and computation time are in the loop exactly, and no delay is approximated.

The loops are broken where commands leave the program.  The observer reads the torque that the
program asks for, so it belongs to the program: a factor at the break is a generator or a pitch
drive that gives more or less than it was told, which the observer does not know.

Everything here is floating point: it is measured, and not proved.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.linalg import expm

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Law, Measurement, SampledLaw, law_words, sampled
from takagi.models.simulation.closed_loop import Observer, measured_speed, observed
from takagi.models.simulation.turbine_plant import (
    SimulatedTurbine,
    SpeedFilter,
    plant_rate,
    validation_plant,
)
from takagi.models.turbine.data import Turbine, rotor_torque_gradient
from takagi.models.turbine.trim import trim

# Largest accepted rate of a state at rest, as a share of the state's size per second.
AT_REST = 1e-9
# Lengths of implicit steps [s]: Newton's, and what is tried where these lead nowhere.
NEWTON = np.full(20, np.inf)
PATIENT = np.concatenate([np.full(40, 3.0), np.geomspace(3.0, 1e9, 30), np.full(10, np.inf)])


class NoEquilibrium(ModelError):
    """The loop has no rest at a wind: there is nothing to linearise at."""


class LoopEquilibrium(NamedTuple):
    """The states of plant, law and observer at rest, and the commands (torque, pitch) there."""

    plant: Floats
    law: Floats
    observer: Floats
    commands: Floats


def loop_equilibrium(
    plant: SimulatedTurbine, law: Law, observer: Observer, wind: float
) -> LoopEquilibrium:
    """Return where the loop rests: near the turbine's trim, where the law and its tables say.

    It depends on neither inertia nor sampling nor the wake's time.

    Raises
    ------
    NoEquilibrium : a ModelError; none is found from the trim.
    ModelError : a wind outside cut-in to cut-out, or a rest at which more wind gives no more
        torque: there the observer cannot estimate it.
    """
    trim(plant.turbine, wind)
    start, point = plant.initial_state(wind)
    at, n, k = measured_speed(plant), len(start), len(law.state_names)
    rate, low, high = plant_rate(plant), plant.turbine.pitch_min, plant.turbine.pitch_max
    estimate = observer.initial_state(float(start[at]), wind)
    state = np.concatenate([start, law.initial_state(wind), estimate])

    def commands(s: Floats) -> tuple[Measurement, Floats]:
        seen = Measurement(float(s[at]), float(s[1]), observer.wind_estimate(s[n + k :]))
        return seen, np.array(law.command(s[n : n + k], seen), dtype=np.float64)

    def moving(s: Floats) -> Floats:
        seen, sent = commands(s)
        estimated = observer.state_rate(s[n + k :], seen.rotor_speed, seen.pitch, float(sent[0]))
        moved = rate(s[:n], float(sent[0]), float(sent[1]), wind)
        return np.concatenate([moved, law.state_rate(s[n : n + k], seen), estimated])

    size = np.maximum(np.abs(state), 0.1)
    for times in (NEWTON, PATIENT):
        found = _at_rest(moving, state, size, times, (low, high))
        if found is not None:
            _require_seen(plant, found, wind)
            return LoopEquilibrium(found[:n], found[n : n + k], found[n + k :], commands(found)[1])
    raise NoEquilibrium(
        f"at {wind:g} m/s the loop of the {law_words(law.name)} has no rest near the turbine's "
        f"trim (torque {point.torque:.6g} N m, pitch {point.pitch:.6g} rad): leave this wind out"
    )


def _at_rest(
    moving: Callable[[Floats], Floats],
    state: Floats,
    size: Floats,
    times: Floats,
    pitch: tuple[float, float],
) -> Floats | None:
    """Return where nothing moves, or None: one implicit Euler step for each time [s].

    Long steps are Newton's; short ones follow the motion of the loop, past kinks too.
    """
    for time in times:
        left = moving(state)
        if float((np.abs(left) / size).max()) < AT_REST:
            return state
        bends = slopes(moving, state, np.ones(len(state))).matrix
        system = (np.eye(len(state)) / time - bends) * size
        state = state + np.linalg.lstsq(system / size[:, None], left / size, rcond=1e-12)[0] * size
        state[1] = min(max(state[1], pitch[0]), pitch[1])
        for stop in pitch:
            if abs(state[1] - stop) < AT_REST:
                state[1] = stop
    return None


def _require_seen(plant: SimulatedTurbine, state: Floats, wind: float) -> None:
    speed, pitch = float(state[0]), float(state[1])
    slope = float(rotor_torque_gradient(plant.turbine, speed, pitch, wind)[2])
    if slope <= 0:
        raise ModelError(
            f"at {wind:g} m/s more wind gives no more torque (dT/dv = {slope:.3g} N m s/m at "
            f"{speed:.4g} rad/s): the rotor stalls and the observer cannot see the wind; raise the "
            "speed set-point, or leave this wind out"
        )


# Of a value's own size, at least of FLOOR: the step of a difference.
STEP, FLOOR = 1e-5, 1e-1
# At a kink the jump of the slopes stays while the step is halved; a bend's jump halves.
STAYS, VISIBLE = 0.75, 1e-5


class Slopes(NamedTuple):
    """A Jacobian (m, n), and at which coordinates the function has a kink.

    There the two one-sided slopes differ, and ``matrix`` has those of the side that was asked.
    """

    matrix: Floats
    kinks: tuple[int, ...]


def slopes(function: Callable[[Floats], Floats], at: Floats, sides: Floats) -> Slopes:
    """Return the slopes of a function at a point.

    Parameters
    ----------
    sides : (n,) +1 or -1, the side on which a kink is read; elsewhere differences are central.
    """
    steps = STEP * np.maximum(np.abs(at), FLOOR)
    here = function(at)

    def one_sided(size: float) -> Floats:
        """Slopes to the second order in the step, (m, n)."""
        found = []
        for unit, step in zip(np.eye(len(at)), steps, strict=True):
            near, far = (function(at + share * size * step * unit) for share in (0.5, 1.0))
            found.append((4 * near - 3 * here - far) / (size * step))
        return np.array(found).T

    # A jump of the second-order slopes is a kink's alone, up to terms of the step squared.
    up, down = one_sided(1.0), one_sided(-1.0)
    jump, still = np.abs(up - down), np.abs(one_sided(0.5) - one_sided(-0.5))
    size = np.maximum(np.abs(up), np.abs(down)) * steps
    seen = jump * steps > VISIBLE * size.max(axis=1, keepdims=True)
    kinked = np.flatnonzero((seen & (still > STAYS * jump)).any(axis=0))
    matrix = (up + down) / 2
    matrix[:, kinked] = np.where(sides[kinked] > 0, up[:, kinked], down[:, kinked])
    return Slopes(matrix, tuple(int(k) for k in kinked))


# What the wake does: as it is, always in equilibrium, or not at all; the answers of torque to
# pitch at the two ends are those between which a certificate holds.
WAKES = ("dynamic", "equilibrium", "frozen")
# A multiplier of one sample below this is gone.
GONE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class RunningLoop:
    """The sampled loop x+ = A x + B u, u = -L's answer, broken at both commands.

    Attributes
    ----------
    wind : [m/s].   sample_time : [s].
    A, B, C : of the broken loop: commands (torque, pitch reference) in, minus what the program
        answers out, so that the closed loop is x+ = (A - B C) x.
    scale : of each state, for well-conditioned numbers.
    kinks : names of the states at which plant or program have two slopes; they are read on one
        side.
    rest : what it is linearised at.
    """

    wind: float
    sample_time: float
    A: Floats
    B: Floats
    C: Floats
    scale: Floats
    kinks: tuple[str, ...]
    rest: LoopEquilibrium

    @property
    def multipliers(self) -> Complex:
        """Eigenvalues of one sample of the closed loop, largest first."""
        values = np.linalg.eigvals(self.A - self.B @ self.C).astype(np.complex128)
        return values[np.argsort(-np.abs(values))]

    @property
    def poles(self) -> Complex:
        """log(multipliers) / T [1/s], slowest first, without what is gone after a sample."""
        return continuous(self.multipliers, self.sample_time)


def continuous(multipliers: Complex, sample_time: float) -> Complex:
    """Return log(multipliers) / T [1/s], without those that are gone after a sample."""
    kept = multipliers[np.abs(multipliers) > GONE]
    return np.asarray(np.log(kept) / sample_time, dtype=np.complex128)


@lru_cache(maxsize=8)
def with_inertia(plant: SimulatedTurbine, factor: float) -> SimulatedTurbine:
    """Return the plant with both inertias times a factor; the torsion mode keeps its frequency."""
    turbine: Turbine = plant.turbine
    rotor, generator = factor * turbine.rotor_inertia, factor * turbine.generator_inertia
    changed = replace(turbine, rotor_inertia=rotor, generator_inertia=generator)
    return replace(plant, turbine=changed)


# Factor on the nominal inertia, and one of ``WAKES``.
PlantChoice: TypeAlias = tuple[float, str]
# The machine as its file says.
NOMINAL: PlantChoice = (1.0, "dynamic")
# How often the law runs where nothing else is said [s].
SAMPLE = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class RunningLoops:
    """The loop that runs, at any wind and for any plant; where it rests is found once for a wind.

    Attributes
    ----------
    plant : with the filter of the measured speed.
    program : the law, sampled.
    rests : wind [m/s] -> where the loop rests, or why it does not.  It depends on neither inertia
        nor wake.
    """

    plant: SimulatedTurbine
    program: SampledLaw
    observer: Observer
    rests: dict[float, LoopEquilibrium | NoEquilibrium] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        turbine: Turbine,
        law: Law,
        observer: Observer,
        *,
        speed_filter: SpeedFilter | float | None,
        sample_time: float = SAMPLE,
        computation_time: float = 0.0,
    ) -> RunningLoops:
        """Return the loop of the validation plant.

        Parameters
        ----------
        speed_filter : on the measured speed: band-stop and low-pass, or the corner of a low-pass
            alone [rad/s]; None for none.
        sample_time, computation_time : of the program [s], see ``SampledLaw``.
        """
        plant = replace(validation_plant(turbine), speed_filter=speed_filter)
        return cls(plant, SampledLaw(law, sample_time, computation_time), observer)

    def other(
        self, *, plant: SimulatedTurbine | None = None, law: Law | None = None
    ) -> RunningLoops:
        """Return the loop with another plant or law, of which no equilibrium is known yet."""
        program = replace(self.program, law=law or self.program.law)
        return RunningLoops(plant or self.plant, program, self.observer)

    def rest(self, wind: float) -> LoopEquilibrium:
        """Return where the loop rests; see ``loop_equilibrium``."""
        if wind not in self.rests:
            try:
                found = loop_equilibrium(self.plant, self.program.law, self.observer, wind)
                self.rests[wind] = found
            except NoEquilibrium as missing:
                self.rests[wind] = missing
        rest = self.rests[wind]
        if isinstance(rest, NoEquilibrium):
            raise rest
        return rest

    def at(self, wind: float, plant: PlantChoice = NOMINAL, side: int | None = None) -> RunningLoop:
        """Return the loop at a wind [m/s].

        ``side`` : see ``linearised_loop``; None for the first of ``sides``.
        """
        factor, wake = plant
        return linearised_loop(
            self.plant if factor == 1 else with_inertia(self.plant, factor),
            self.program,
            self.observer,
            wind,
            rest=self.rest(wind),
            wake=wake,
            side=self.sides(wind)[0] if side is None else side,
        )

    def sides(self, wind: float) -> tuple[int, ...]:
        """Return on which sides kinks are read: at the ends of the winds, inwards alone."""
        if wind <= self.plant.turbine.cut_in:
            return (1,)
        return (-1,) if wind >= self.plant.turbine.cut_out else (1, -1)


def linearised_loop(
    plant: SimulatedTurbine,
    program: SampledLaw,
    observer: Observer,
    wind: float,
    *,
    rest: LoopEquilibrium | None = None,
    wake: str = "dynamic",
    side: int = 1,
) -> RunningLoop:
    """Return the loop at a steady wind [m/s].

    Parameters
    ----------
    rest : where the loop rests; None looks for it (``loop_equilibrium``).
    wake : one of ``WAKES``.
    side : +1 or -1, on which a kink is read that is no stop, such as a node of the law's tables.
        At a stop (pitch, torque) it is read on the side where the machine can go.

    Raises
    ------
    ModelError : an unknown wake, or what ``loop_equilibrium`` refuses.
    """
    if wake not in WAKES:
        raise ModelError(f"wake {wake!r} is not known; choose one of {WAKES}")
    rest = rest or loop_equilibrium(plant, program.law, observer, wind)
    n, k = len(rest.plant), len(rest.law)
    at, rate = np.concatenate([rest.plant, rest.commands]), plant_rate(plant)
    found = slopes(
        lambda x: rate(x[:n], float(x[n]), float(x[n + 1]), wind), at, _sides(plant, at, n, side)
    )
    names = [*plant.state_names, "torque command", "pitch reference"]
    kinks = [names[place] for place in found.kinks]
    A, B = found.matrix[:, :n], found.matrix[:, n:]
    kept, A, B = _with_wake(plant, A, B, wake)
    places = (kept.index(measured_speed(plant)), kept.index(1))
    held_A, held_B, late_B = _held(A, B, program)
    speed, pitch = rest.plant[measured_speed(plant)], rest.plant[1]
    inside = np.concatenate([rest.law, rest.observer, [rest.commands[0], speed, pitch]])
    step = _program_step(program, observer, k)
    answer = slopes(step, inside, _sides(plant, inside, len(inside) - 2, side, pitch_last=True))
    inner = [*program.state_names, "estimated speed", "estimated wind", "torque", "speed", "pitch"]
    kinks += [inner[place] for place in answer.kinks]
    scale = np.concatenate([rest.plant[kept], inside[:-2]])
    if late_B.any():
        scale = np.concatenate([scale, rest.commands])
    A, B, C = _broken(held_A, held_B, late_B, places, answer.matrix)
    size = np.maximum(np.abs(scale), 1e-3)
    return RunningLoop(wind, program.sample_time, A, B, C, size, tuple(dict.fromkeys(kinks)), rest)


def _program_step(program: SampledLaw, observer: Observer, k: int) -> Callable[[Floats], Floats]:
    """Return (law, observer, torque before, speed, pitch) -> (the first three later, commands).

    As ``takagi.models.simulation.closed_loop`` runs it, without the limits of rate.
    """
    period = program.sample_time
    late = program.computation_time / period

    def step(x: Floats) -> Floats:
        inner, estimator, before = x[:k], x[k:-3], float(x[-3])
        seen = Measurement(float(x[-2]), float(x[-1]), observer.wind_estimate(estimator))
        command, later = sampled(program.law, inner, seen, period)
        torques = before, command.torque
        estimated = observed(observer, estimator, seen, torques, late, period)
        return np.concatenate([later, estimated, [command.torque], command])

    return step


def _sides(
    plant: SimulatedTurbine, at: Floats, n: int, side: int, *, pitch_last: bool = False
) -> Floats:
    """Return on which side each coordinate is read at a kink.

    Pitch and its reference at their lower stop go up alone, at the upper one down alone.
    """
    turbine, found = plant.turbine, np.full(len(at), float(side))
    for place in (len(at) - 1,) if pitch_last else (1, n + 1):
        if at[place] <= turbine.pitch_min:
            found[place] = 1.0
        elif at[place] >= turbine.pitch_max:
            found[place] = -1.0
    return found


def _with_wake(
    plant: SimulatedTurbine, A: Floats, B: Floats, wake: str
) -> tuple[list[int], Floats, Floats]:
    """Return the states that are kept, and the plant with this wake."""
    place, everything = plant.index("induced wind"), list(range(len(A)))
    if wake == "dynamic" or place is None:
        return everything, A, B
    kept = [k for k in everything if k != place]
    inner, across = A[np.ix_(kept, kept)], A[np.ix_(kept, [place])]
    if wake == "frozen":
        return kept, inner, B[kept]
    settled = -across / A[place, place]
    return kept, inner + settled @ A[[place]][:, kept], B[kept] + settled @ B[[place]]


def _held(A: Floats, B: Floats, program: SampledLaw) -> tuple[Floats, Floats, Floats]:
    """Return (A, B, B of the commands before) of one sample, both commands held.

    For the first computation_time of a sample the commands before act.
    """
    n, m = B.shape

    def over(time: float) -> tuple[Floats, Floats]:
        block = np.zeros((n + m, n + m))
        block[:n, :n], block[:n, n:] = A, B
        grown = expm(time * block)
        return grown[:n, :n], grown[:n, n:]

    first, late = over(program.computation_time)
    rest, soon = over(program.sample_time - program.computation_time)
    return rest @ first, soon, rest @ late


def _broken(
    A: Floats, B: Floats, late: Floats, places: tuple[int, ...], program: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the loop, broken at both commands: states plant, program, commands before."""
    n, inner = len(A), program.shape[1] - 2
    before = 2 if late.any() else 0
    size = n + inner + before
    whole, entry, answer = np.zeros((size, size)), np.zeros((size, 2)), np.zeros((2, size))
    C = np.eye(n)[list(places)]
    whole[:n, :n], entry[:n] = A, B
    whole[n : n + inner, n : n + inner] = program[:inner, :inner]
    whole[n : n + inner, :n] = program[:inner, inner:] @ C
    if before:
        whole[:n, n + inner :], entry[n + inner :] = late, np.eye(2)
    answer[:, :n], answer[:, n : n + inner] = program[inner:, inner:] @ C, program[inner:, :inner]
    return whole, entry, -answer
