r"""What the law asks the generator for at least, while the measured speed is at least some speed.

In an eighth of an interval of the tables, with s = speed - (limit of x) - max omega* and
U = min q* + gamma s, gamma the value that makes it least,

    torque >= T_rated - E (psi(-U) + g), held within 0 and T_rated.

The page is docs/turbulence-speed.md.
"""

from __future__ import annotations

from flint import fmpq

from takagi.certificates.cross_check.turbine.effort_ramp import ramp
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

EIGHT = 8


class Asked:
    """The law's tables from a schedule wind on, in eighths of their intervals.

    Raises
    ------
    Outside : no schedule wind of the tables is at or above ``first``.
    """

    def __init__(self, rotor: Rotor, first: fmpq) -> None:
        self.rotor = rotor
        self.eighths: list[tuple[NumberRange, NumberRange, NumberRange, fmpq]] = []
        nodes = rotor.wind
        for k in range(len(nodes) - 1):
            low, high = max(nodes[k], first), nodes[k + 1]
            for i in range(EIGHT if low < high else 0):
                ends = [low + (high - low) * j / EIGHT for j in (i, i + 1)]
                omega, q, gamma = (
                    NumberRange.of(*(self._line(column, k, v) for v in ends))
                    for column in (rotor.speed, rotor.effort, rotor.proportional)
                )
                self.eighths.append((omega, q, gamma, rotor.ahead_limit[k]))
        if not self.eighths:
            raise Outside("no schedule wind is left")

    def _line(self, column: list[fmpq], k: int, wind: fmpq) -> fmpq:
        a, b = self.rotor.wind[k], self.rotor.wind[k + 1]
        found: fmpq = (column[k] * (b - wind) + column[k + 1] * (wind - a)) / (b - a)
        return found

    def torque(self, speed: fmpq) -> fmpq:
        """Return the least torque, high-speed shaft, while the measured speed is at least this."""
        rotor, found = self.rotor, []
        for omega, q, gamma, fed in self.eighths:
            s = speed - rotor.integral_limit - omega.high
            U = q.low + min(gamma.low * s, gamma.high * s)
            braked = rotor.torque - rotor.per_effort * (ramp(-U, rotor.overlap) + fed)
            found.append(min(max(braked, fmpq(0)), rotor.torque))
        return min(found)
