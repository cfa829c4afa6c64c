"""What is run: a plant, a law, the limits of its actuators, and signals from outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant_simulation.right_side import Rate
from takagi.models.plant_simulation.signals import Signals

# (measured x - x*, w) -> the command that is wanted, then those of the actuators behind a blend.
Commands = Callable[[Floats, Floats], Floats]


class SampledProgram(Protocol):
    """A law that computes once a sample and remembers.

    ``missed`` : samples in which a formula had no value, so that the last command was kept.
    """

    missed: int

    def sample(self, state: Floats, signals: Floats) -> Floats:
        """Return the command that is wanted at a measured x - x* (n,) and signals w; SI."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """A loop to be run from several starts, in SI.  States are deviations x - x* from rest.

    Small deviations keep their digits so, where x itself is large, such as 350 K.

    Attributes
    ----------
    rate : (x, u, w) -> x' of the values themselves, or x(t + step) in discrete time.
    commands : (measured x - x*, w) -> what is wanted: u (m,), then the commands of actuators
        behind a blend, which ``rate`` computes for itself.
    inputs : m.
    limits : (number of commands, 2), the ends of each command's range; infinite where it has none.
    rest : x* (n,), where the plant rests, and ``far`` (n,): the deviation from it at which a run is
        ended.
    disturbances : w as deviations from ``disturbance_rest`` (p,).
    noise : on the measured states, (n,).
    program : makes the law in samples, a new one for each run; None for the law in continuous time.
    step : T [s], of the program, or of a plant in discrete time; None for neither.
    discrete : whether the plant is one in discrete time.
    """

    rate: Rate
    commands: Commands
    inputs: int
    limits: Floats
    rest: Floats
    far: Floats
    disturbances: Signals
    disturbance_rest: Floats
    noise: Signals
    program: Callable[[], SampledProgram] | None = None
    step: float | None = None
    discrete: bool = False

    def held(self, wanted: Floats) -> Floats:
        """Return the inputs (m,) that act: what is wanted, cut at the ends of its range."""
        low, high = self.limits.T
        return np.asarray(np.clip(wanted, low, high)[: self.inputs], dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Cut:
    """A time span [s] in which a command is beyond an end of its range, and the actuator at it."""

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
    state : (k, n), x - x*.
    wanted : (k, number of commands) before, ``sent`` the same after the cut.
    disturbance : (k, p).
    cuts : in the order of time.
    ended : "whole"; "far" if it went too far; "undefined" where an equation or the law has no
        value; "stuck" if the integration failed.
    missed : samples in which the program had no value and kept its last command.
    """

    time: Floats
    state: Floats
    wanted: Floats
    sent: Floats
    disturbance: Floats
    cuts: tuple[Cut, ...]
    ended: str
    missed: int = 0
