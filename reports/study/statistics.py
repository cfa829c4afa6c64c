"""Intervals over seeds by the bootstrap, and a year's wind by a Weibull distribution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, gamma, isfinite

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats, Places
from takagi.models.errors import ModelError

CONFIDENCE = 0.95
RESAMPLES, SEED = 5000, 1
HOURS_A_YEAR = 8760.0


@dataclass(frozen=True, slots=True)
class Interval:
    """A figure and its interval of 95 %."""

    value: float
    low: float
    high: float

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves out 0."""
        return self.low > 0 or self.high < 0

    @classmethod
    def of(cls, value: float, resampled: NDArray[np.float64]) -> Interval:
        """Return the percentile interval of the values of all resamples."""
        tail = 50 * (1 - CONFIDENCE)
        low, high = np.percentile(resampled, [tail, 100 - tail])
        return cls(float(value), float(low), float(high))


def resampled_seeds(seeds: int) -> Places:
    """Return ``RESAMPLES`` draws of as many seeds with replacement, (RESAMPLES, seeds).

    All quantities, winds and laws use the same draws: a seed has the same turbulence in all of
    them, so that differences between laws are paired.
    """
    return np.random.default_rng(SEED).integers(0, seeds, (RESAMPLES, seeds))


def mean_interval(values: Floats) -> Interval:
    """Return the mean over the seeds and its interval; ``values`` is (seeds,).

    Source: Efron and Tibshirani (1993), An Introduction to the Bootstrap, ch. 13 (percentiles).
    """
    draws = resampled_seeds(len(values))
    return Interval.of(float(np.mean(values)), values[draws].mean(axis=1))


@dataclass(frozen=True, slots=True)
class Weibull:
    """A distribution of the ten-minute mean wind.

    mean : [m/s]: 10 in a place of IEC 61400-1 class I, 8.5 in class II.
    shape : [-]; 2 is Rayleigh's.

    Raises ModelError: a mean or shape that is not above 0.
    """

    mean: float = 8.5
    shape: float = 2.0

    def __post_init__(self) -> None:
        if not all(isfinite(v) and v > 0 for v in (self.mean, self.shape)):
            raise ModelError(
                f"a Weibull wind with mean {self.mean:g} m/s and shape {self.shape:g} was given; "
                "both must be above 0, such as 8.5:2"
            )

    @classmethod
    def read(cls, text: str) -> Weibull:
        """Return the distribution of MEAN:SHAPE."""
        try:
            mean, shape = (float(part) for part in text.split(":"))
        except ValueError as error:
            raise ModelError(
                f"--weibull {text} was given; MEAN:SHAPE is needed, such as 8.5:2 (m/s, and 2 for "
                "Rayleigh's distribution)"
            ) from error
        return cls(mean, shape)

    def below(self, wind: float) -> float:
        """Return the share of time with less wind [-]."""
        scale = self.mean / gamma(1 + 1 / self.shape)
        return 1 - exp(-((wind / scale) ** self.shape))

    def shares(self, means: Sequence[float], cut_in: float, cut_out: float) -> Floats:
        """Return the share of all time that each mean wind stands for, (winds,).

        A wind stands for all winds that are nearer to it than to another, as far beyond the first
        and the last as halfway to their neighbours, within cut-in and cut-out.
        """
        v = np.array(means)
        half = np.diff(v) / 2 if len(v) > 1 else np.ones(1)
        edges = np.concatenate([[v[0] - half[0]], v[:-1] + half[: len(v) - 1], [v[-1] + half[-1]]])
        below = np.array([self.below(e) for e in np.clip(edges, cut_in, cut_out)])
        return np.diff(below)


def lifetime_mean(values: Floats, shares: Floats) -> Interval:
    """Return the mean over all time of values (winds, seeds), 0 while the turbine stands."""
    draws = resampled_seeds(values.shape[1])
    over_winds = shares @ values
    return Interval.of(float(over_winds.mean()), over_winds[draws].mean(axis=1))


def lifetime_load(loads: Floats, shares: Floats, exponent: float) -> Interval:
    """Return the DEL at 1 Hz of all time, of the DELs (winds, seeds) by their damage."""
    draws = resampled_seeds(loads.shape[1])
    damage = shares @ loads**exponent
    return Interval.of(
        float(damage.mean() ** (1 / exponent)), damage[draws].mean(axis=1) ** (1 / exponent)
    )
