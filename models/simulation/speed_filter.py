r"""What is done to the measured speed before observer and law read it.

    a' = w (y - a)        b' = w (a - b)        z = y - 2 (1 - p) (a - b)        m' = c (z - m)

y is the measured speed, m what is read.  The first part is the band-stop

    z / y = (s^2 + 2 p w s + w^2) / (s + w)^2,

which passes the share p at its frequency w, everything far from it, and turns the phase forward
above it.  It keeps a mode of the drivetrain out of the loop.  The second part is a low-pass.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from takagi.models.errors import ModelError

# What a band-stop lets through at its frequency. Less makes its phase turn faster around it, so
# that a mode that is softer than the file says loses its margin (docs/laws.md).
PASSED = 0.2


@dataclass(frozen=True, slots=True)
class SpeedFilter:
    """A low-pass of one pole on the measured speed, and a band-stop before it.

    Attributes
    ----------
    corner : c, of the low-pass [rad/s].
    stop : w, frequency of the band-stop [rad/s]; 0 for none.
    passed : p, the share of that frequency that passes the band-stop [-].

    Raises
    ------
    ModelError : a corner not above 0, a frequency below 0, a share outside 0 to 1.
    """

    corner: float
    stop: float = 0.0
    passed: float = PASSED

    def __post_init__(self) -> None:
        if not (isfinite(self.corner) and self.corner > 0):
            raise ModelError(
                f"speed_filter = {self.corner:g} rad/s was given; it must be above 0"
                + (", for a band-stop needs a low-pass behind it" if self.stop else "")
            )
        if not (isfinite(self.stop) and self.stop >= 0):
            raise ModelError(
                f"torsion_filter = {self.stop:g} rad/s was given; a frequency above 0 is needed, "
                "or 0 for none"
            )
        if not 0 <= self.passed <= 1:
            raise ModelError(
                f"the share that passes the band-stop was given as {self.passed:g}; 0 to 1 "
                "is needed"
            )

    @classmethod
    def of(cls, value: SpeedFilter | float | None) -> SpeedFilter | None:
        """Return a filter as it is, a number as the corner of a low-pass alone; None for none."""
        return value if value is None or isinstance(value, SpeedFilter) else cls(value)
