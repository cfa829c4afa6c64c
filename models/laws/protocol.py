"""The protocol of controller laws: a law is a value that maps state and measurement to a command.

    command = c(x_c, y),    x_c' = g(x_c, y),    y = (rotor speed, pitch, wind estimate)

Simulation, embedding of the closed loop, export and typesetting read laws through this protocol
alone.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple, Protocol

from takagi.models.arrays import Floats


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
        "paper": "published law",
        "paper-two-integrators": "published law with two integrators",
        "baseline": "baseline law",
    }
)


def law_words(name: str) -> str:
    """Return what a law is called in sentences, given its name in files; of others, the name."""
    return _WORDS.get(name, f"law {name}")
