r"""The rotor-effective wind in turbulence, as a Gaussian process with a mean.

    y' = r,     r' = -(1/t_r + 1/t_L) r - y/(t_r t_L) + s W,     y = v - mean

W is white noise of intensity 1.  The averaging by the rotor (t_r) and the passage of eddies (t_L)
follow each other.  With the deviation of y and the rms of r, t_r t_L = (deviation / rate)^2 and
s^2 = 2 (1/t_r + 1/t_L) rate^2.

Deviation and rate are those of TurbSim fields of IEC class B on the rotor of the NREL 5-MW turbine,
126 m wide (Kaimal, 17 by 17 points, averaged over the disc, below 0.5 Hz, 660 s, one or two seeds).
Classes A and C have 16/14 and 12/14 of them, as IEC 61400-1 has of the reference intensity.  A
wider rotor averages more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.models.errors import ModelError

# Mean wind [m/s], deviation [m/s] and rms rate [m/s^2]; docs/turbulence-exit.md says more.
CLASS_B = (
    (5, 0.70, 0.05), (7, 1.14, 0.08), (9, 1.04, 0.10), (11, 1.22, 0.135), (13, 1.29, 0.165),
    (15, 1.64, 0.20), (17, 1.61, 0.24), (19, 1.74, 0.31), (21, 2.09, 0.35), (23, 2.15, 0.39),
)  # fmt: skip
CLASSES = {"A": 16 / 14, "B": 1.0, "C": 12 / 14}


@dataclass(frozen=True, slots=True)
class RotorWind:
    """The wind's process: its ``deviation`` [m/s], the rms ``rate`` [m/s^2], t_r [s]."""

    deviation: float
    rate: float
    rotor_time: float = 4.0

    def __post_init__(self) -> None:
        if not min(self.deviation, self.rate, self.rotor_time) > 0:
            raise ModelError(f"{self}: positive numbers are needed")

    @classmethod
    def of_class(cls, letter: str, mean: float) -> RotorWind:
        """Return the wind of a class at a mean wind [m/s], to four digits.

        Between the winds of the table the numbers are linear, beyond them constant.

        Raises
        ------
        ModelError : no such class.
        """
        if letter not in CLASSES:
            raise ModelError(f"turbulence class {letter!r}: one of {', '.join(CLASSES)} is needed")
        winds, *columns = np.array(CLASS_B, dtype=np.float64).T
        deviation, rate = (
            float(f"{CLASSES[letter] * np.interp(mean, winds, column):.4g}") for column in columns
        )
        return cls(deviation, rate)

    def stated(self) -> dict[str, float]:
        """Return the numbers as a certificate states them."""
        return {"deviation": self.deviation, "rate": self.rate, "rotor_time": self.rotor_time}
