"""The loop that is simulated: the plant by its own equations, law, actuator limits, signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Protocol

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant_simulation.signals import Signals

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

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
    import sympy as sp

    from takagi.models.blending.blending import blending_of
    from takagi.models.blending.run_time import RunTimeBlending, explicit_rows

    blending = blending_of(plant)
    if blending is not None:
        return RunTimeBlending(blending).disturbed_rate(moving, told=told)
    free = [v.symbol for v in moving]
    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    values |= {
        v.symbol: sp.Rational(*(fixed or {}).get(v.name, v.rest).as_integer_ratio())
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
