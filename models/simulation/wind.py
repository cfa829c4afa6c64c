"""Wind over time as the rotor feels it: the series, and the shapes without randomness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

TIME_STEP = 0.05
# IEC 61400-1 (ed. 3), table 1: the NREL 5-MW is a class I B machine.
REFERENCE_WIND = 50.0
REFERENCE_INTENSITY = 0.14
GUST_DURATION = 10.5
LONGITUDINAL_SCALE = 42.0


@dataclass(frozen=True, slots=True, eq=False)
class WindSeries:
    """Rotor-effective wind speed over time, linear between its samples.

    Attributes
    ----------
    time : (n,) increasing, n >= 2 [s].
    speed : (n,) above 0 [m/s].
    name : word for tables and legends.

    Raises
    ------
    ModelError : sizes that differ, fewer than 2 samples, NaN, unsorted time, or wind <= 0.
    """

    time: Floats
    speed: Floats
    name: str = "wind"

    def __post_init__(self) -> None:
        for field in ("time", "speed"):
            array = np.array(getattr(self, field), dtype=np.float64)
            array.flags.writeable = False
            object.__setattr__(self, field, array)
        if self.time.ndim != 1 or self.time.shape != self.speed.shape or len(self.time) < 2:
            raise ModelError(
                f"wind {self.name!r}: time has shape {self.time.shape}, speed {self.speed.shape}; "
                "both must be vectors of one length, at least 2"
            )
        if not (np.all(np.isfinite(self.time)) and np.all(np.diff(self.time) > 0)):
            raise ModelError(f"wind {self.name!r}: time must be finite and increase strictly")
        wrong = np.flatnonzero(~((self.speed > 0) & np.isfinite(self.speed)))
        if len(wrong):
            raise ModelError(
                f"wind {self.name!r}: speed is {self.speed[wrong[0]]:.6g} m/s at "
                f"{self.time[wrong[0]]:.6g} s; a finite wind above 0 is needed at every sample"
            )

    @property
    def duration(self) -> float:
        """Last time minus first [s]."""
        return float(self.time[-1] - self.time[0])

    def at(self, time: ArrayLike) -> Floats:
        """Return the speed at these times [m/s]; the end values are held outside."""
        asked = np.asarray(time, dtype=np.float64)
        return np.asarray(np.interp(asked, self.time, self.speed), dtype=np.float64)


def constant_wind(speed: float, duration: float, *, name: str | None = None) -> WindSeries:
    """Return v(t) = speed [m/s] over the duration [s]."""
    _check_duration(duration, 0.0)
    return WindSeries(
        np.array([0.0, duration]), np.array([speed, speed]), name or f"constant {speed:g} m/s"
    )


def step_wind(
    before: float, after: float, duration: float, *, begin: float = 30.0, name: str | None = None
) -> WindSeries:
    """Return ``before`` until ``begin`` [s], then ``after`` [m/s], within 1 ms.

    Raises
    ------
    ModelError : the step does not lie inside the duration, or a wind not above 0.
    """
    # A wind series is linear between its times, so a step needs a short ramp.
    _check_duration(duration, begin + 1e-3)
    return WindSeries(
        np.array([0.0, begin, begin + 1e-3, duration]),
        np.array([before, before, after, after]),
        name or f"step {before:g} to {after:g} m/s",
    )


def ramp_wind(
    before: float,
    after: float,
    duration: float,
    *,
    rate: float,
    begin: float = 30.0,
    name: str | None = None,
) -> WindSeries:
    """Return a wind that leaves ``before`` at ``begin`` [s] and reaches ``after`` at ``rate``.

    Parameters
    ----------
    rate : size of the slope [m/s^2], above 0; its sign follows from the two winds.

    Raises
    ------
    ModelError : rate not above 0, or the ramp does not end inside the duration.
    """
    if not rate > 0 or before == after:
        raise ModelError(
            f"ramp from {before:g} to {after:g} m/s at {rate:g} m/s^2: two different winds and a "
            "rate above 0 are needed (the direction follows from the winds)"
        )
    end = begin + abs(after - before) / rate
    _check_duration(duration, end)
    return WindSeries(
        np.array([0.0, begin, end, duration]),
        np.array([before, before, after, after]),
        name or f"ramp {before:g} to {after:g} m/s at {rate:g} m/s^2",
    )


def gust_wind(
    mean: float,
    duration: float,
    *,
    rotor_radius: float,
    begin: float = 30.0,
    amplitude: float | None = None,
    name: str | None = None,
) -> WindSeries:
    """Return the extreme operating gust: dip, peak, dip within 10.5 s.

        v = V - 0.37 V_gust sin(3 pi s / T) (1 - cos(2 pi s / T)),  s = t - begin in [0, T]
        V_gust = min(1.35 (V_e1 - V), 3.3 sigma_1 / (1 + 0.1 D / Lambda_1))

    with T = 10.5 s, V_e1 = 0.8 * 1.4 * 50 m/s, sigma_1 = 0.14 (0.75 V + 5.6 m/s) and
    Lambda_1 = 42 m (hub at or above 60 m): class I B.

    Parameters
    ----------
    mean : V [m/s].   rotor_radius : D / 2 [m].
    amplitude : V_gust [m/s]; None computes it as above.

    Raises
    ------
    ModelError : the gust does not end inside the duration, or wind would not stay above 0.

    Source: IEC 61400-1 (ed. 3, 2005), 6.3.2.2, eqs. 16 to 18.
    """
    _check_duration(duration, begin + GUST_DURATION)
    sigma = REFERENCE_INTENSITY * (0.75 * mean + 5.6)
    yearly = 0.8 * 1.4 * REFERENCE_WIND
    size = min(1.35 * (yearly - mean), 3.3 * sigma / (1 + 0.2 * rotor_radius / LONGITUDINAL_SCALE))
    if amplitude is not None:
        size = amplitude

    def shape(time: Floats) -> Floats:
        s = np.clip(time - begin, 0.0, GUST_DURATION) / GUST_DURATION
        wave = np.sin(3 * pi * s) * (1 - np.cos(2 * pi * s))
        return np.asarray(mean - 0.37 * size * wave, dtype=np.float64)

    return _sampled(shape, duration, name or f"gust at {mean:g} m/s")


def _sampled(shape: Callable[[Floats], Floats], duration: float, name: str) -> WindSeries:
    time = np.linspace(0.0, duration, max(2, round(duration / TIME_STEP) + 1))
    return WindSeries(time, shape(time), name)


def _check_duration(duration: float, needed: float) -> None:
    if not (np.isfinite(duration) and duration > needed):
        raise ModelError(
            f"duration {duration:g} s was given; more than {needed:g} s is needed here: give a "
            "longer duration or an earlier begin"
        )
