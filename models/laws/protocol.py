"""The protocol of controller laws: a law is a value that maps state and measurement to a command.

    command = c(x_c, y),    x_c' = g(x_c, y),    y = (rotor speed, pitch, wind estimate)

Simulation, embedding of the closed loop, export and typesetting read laws through this protocol
alone.

A law as the discrete program that a turbine controller runs, every 10 to 20 ms.

At t_k = k T the program reads its measurements, computes, and sends; a command that was sent is
held until the next sample:

    c_k     = the law's command at (state_k, measurement_k)
    sent_k  = sent_{k-1} + (c_k - sent_{k-1} held within +- rate limit times T)
    state_k+1 = the law's states T later, the measurement held

and the plant sees sent_k from t_k + T_c to t_{k+1} + T_c, with T_c the computation time.  Sampling
and holding delay a command by T / 2 on average, computing by T_c.

A law that has ``sample`` discretises itself: the effort-sharing law its filter exactly, feeding
forward the mean rate of the filter until the next sample.  Any other one takes an Euler step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import inf, isfinite
from types import MappingProxyType
from typing import NamedTuple, Protocol, cast, runtime_checkable

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


class Measurement(NamedTuple):
    """The inputs of a law: rotor speed [rad/s], pitch [rad], wind estimate [m/s]."""

    rotor_speed: float
    pitch: float
    wind_estimate: float


class Command(NamedTuple):
    """The outputs of a law: generator torque on the high-speed shaft [N m], pitch [rad]."""

    torque: float
    pitch: float


class Law(Protocol):
    """A controller law as a value; it stores no state, because the state is an argument.

    ``command`` and ``state_rate`` are pure.  A law need not limit its commands: the plant limits
    torque, its rate, and the pitch drive.
    """

    @property
    def name(self) -> str:
        """Word for tables and legends."""
        ...

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the controller's states with their units, e.g. ``"integral [rad]"``."""
        ...

    def initial_state(self, wind: float) -> Floats:
        """Return the state in which the law rests at the trim of a constant wind [m/s]."""
        ...

    def command(self, state: Floats, measurement: Measurement) -> Command:
        """Return the command at this state and measurement."""
        ...

    def state_rate(self, state: Floats, measurement: Measurement) -> Floats:
        """Return the time derivative of the state, same shape and order as ``state_names``."""
        ...


# By the name that a law has in files.
_WORDS = MappingProxyType(
    {
        "coherent": "effort-sharing law",
        "paper": "Schulte's law",
        "switched": "switched law",
        "baseline": "reference controller (K w^2 + PI)",
    }
)


def law_words(name: str) -> str:
    """Return what a law is called in sentences, given its name in files; of others, the name."""
    return _WORDS.get(name, f"law {name}")


@runtime_checkable
class Sampling(Protocol):
    """A law that discretises itself, better than by an Euler step."""

    def sample(
        self, state: Floats, measurement: Measurement, time: float
    ) -> tuple[Command, Floats]:
        """Return the command at a sample, and the state at the next one, ``time`` [s] later."""
        ...


class ProgramState(NamedTuple):
    """The program's memory between two samples: the law's states, and the last command sent."""

    law_state: Floats
    sent: Command


@dataclass(frozen=True, slots=True)
class SampledLaw:
    """A law, its sample time, and limits on the rates of its commands.

    Attributes
    ----------
    law : any law.
    sample_time : T [s].
    computation_time : T_c [s], from reading to sending; at most T.
    torque_rate_limit [N m/s, high-speed shaft], pitch_rate_limit [rad/s] : of what is sent; inf
        leaves them to the actuators.

    Raises
    ------
    ModelError : a time or limit that is not allowed.
    """

    law: Law
    sample_time: float
    computation_time: float = 0.0
    torque_rate_limit: float = inf
    pitch_rate_limit: float = inf

    def __post_init__(self) -> None:
        require_times(self.sample_time, self.computation_time)
        for name in ("torque_rate_limit", "pitch_rate_limit"):
            if not getattr(self, name) > 0:
                raise ModelError(
                    f"{name} = {getattr(self, name)!r} was given; it must be above 0, or inf for "
                    "none"
                )

    @property
    def name(self) -> str:
        """The law's word for tables."""
        return self.law.name

    @property
    def state_names(self) -> tuple[str, ...]:
        """The law's states with their units."""
        return self.law.state_names

    def start(self, wind: float, sent: Command) -> ProgramState:
        """Return the program's equilibrium at a constant wind [m/s], ``sent`` being in force."""
        state = np.asarray(self.law.initial_state(wind), dtype=np.float64)
        return ProgramState(state, sent)

    def step(self, state: ProgramState, measurement: Measurement) -> tuple[Command, ProgramState]:
        """Return what is sent at this sample, and the program's state at the next one."""
        command, later = sampled(self.law, state.law_state, measurement, self.sample_time)
        sent = Command(
            _within(command.torque, state.sent.torque, self.torque_rate_limit * self.sample_time),
            _within(command.pitch, state.sent.pitch, self.pitch_rate_limit * self.sample_time),
        )
        return sent, ProgramState(later, sent)


def require_times(sample_time: float, computation_time: float) -> None:
    """Refuse times [s] that are not possible for a program.

    Raises
    ------
    ModelError : a sample time that is not positive, a computation time below 0 or beyond it.
    """
    if not (isfinite(sample_time) and sample_time > 0):
        raise ModelError(
            f"sample time {sample_time!r} s was given; a positive time is needed, such as 0.02"
        )
    if not 0 <= computation_time <= sample_time:
        raise ModelError(
            f"computation time {computation_time!r} s was given with a sample time of "
            f"{sample_time:g} s; 0 up to the sample time is needed"
        )


def sampled(
    law: Law, state: Floats, measurement: Measurement, time: float
) -> tuple[Command, Floats]:
    """Return a law's command at a sample, and its states at the next one, ``time`` [s] later.

    By the law's own ``sample`` where it has one, else state + time times its rate.
    """
    if _discretises_itself(type(law)):
        return cast(Sampling, law).sample(state, measurement, time)
    later = np.asarray(state + time * law.state_rate(state, measurement), dtype=np.float64)
    return law.command(state, measurement), later


@cache
def _discretises_itself(law: type) -> bool:
    """Return whether laws of a class have ``sample``; cached, because every sample calls this."""
    return issubclass(law, Sampling)


def _within(value: float, previous: float, largest_step: float) -> float:
    """Return the wanted value, or the nearest one that the rate limit allows after ``previous``."""
    return float(min(max(value, previous - largest_step), previous + largest_step))
