"""Signals over time, as deviations from rest: step, pulse, ramp, sine and band-limited noise.

A loop with signals is integrated segment by segment.  ``breaks`` has the times at which a signal
jumps or has a kink; between two breaks it is the smooth function that ``on`` returns.  A jump
belongs to the segment that begins at its time, so the integrator never evaluates the other value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, pi, sin
from typing import Protocol

import numpy as np

from takagi.models.arrays import Floats

Function = Callable[[float], float]
# Random numbers are drawn in blocks, so that a longer run begins with those of a shorter one.
_BLOCK = 1024


class Signal(Protocol):
    """A deviation from rest over time, in SI units.  It is 0 before its first break."""

    @property
    def size(self) -> float:
        """The largest deviation [SI]; of noise its standard deviation."""
        ...

    @property
    def last(self) -> float:
        """The time [s] after which it repeats or stays as it is."""
        ...

    def breaks(self, end: float) -> list[float]:
        """Return the times in (0, end) at which it jumps or has a kink."""
        ...

    def on(self, begin: float, end: float) -> Function:
        """Return the function of time on [begin, end], an interval without a break inside."""
        ...


@dataclass(frozen=True, slots=True)
class Step:
    """``size`` from ``start`` [s] on."""

    size: float
    start: float

    @property
    def last(self) -> float:
        """The time of the step [s]."""
        return self.start

    def breaks(self, end: float) -> list[float]:
        """Return the time of the step."""
        return _inside([self.start], end)

    def on(self, begin: float, end: float) -> Function:
        """Return a constant."""
        return _constant(self.size if (begin + end) / 2 > self.start else 0.0)


@dataclass(frozen=True, slots=True)
class Pulse:
    """``size`` from ``start`` to ``stop`` [s], 0 before and after."""

    size: float
    start: float
    stop: float

    @property
    def last(self) -> float:
        """The time of its end [s]."""
        return self.stop

    def breaks(self, end: float) -> list[float]:
        """Return its two edges."""
        return _inside([self.start, self.stop], end)

    def on(self, begin: float, end: float) -> Function:
        """Return a constant."""
        return _constant(self.size if self.start < (begin + end) / 2 < self.stop else 0.0)


@dataclass(frozen=True, slots=True)
class Ramp:
    """A line from 0 at ``start`` to ``size`` at ``stop`` [s], which it keeps."""

    size: float
    start: float
    stop: float

    @property
    def last(self) -> float:
        """The time at which it reaches its size [s]."""
        return self.stop

    def breaks(self, end: float) -> list[float]:
        """Return the times of its two kinks."""
        return _inside([self.start, self.stop], end)

    def on(self, begin: float, end: float) -> Function:
        """Return a constant or the line."""
        middle = (begin + end) / 2
        if middle < self.start:
            return _constant(0.0)
        if middle > self.stop:
            return _constant(self.size)
        slope = self.size / (self.stop - self.start)
        return lambda time: slope * (time - self.start)


@dataclass(frozen=True, slots=True)
class Sine:
    """size sin(2 pi (t - start) / period) from ``start`` [s] on."""

    size: float
    period: float
    start: float = 0.0

    @property
    def last(self) -> float:
        """The time after a few periods [s]."""
        return self.start + 3 * self.period

    def breaks(self, end: float) -> list[float]:
        """Return where it starts."""
        return _inside([self.start], end)

    def on(self, begin: float, end: float) -> Function:
        """Return 0 or the sine."""
        if (begin + end) / 2 < self.start:
            return _constant(0.0)
        rate = 2 * pi / self.period
        return lambda time: self.size * sin(rate * (time - self.start))


@dataclass(frozen=True, slots=True)
class Noise:
    """Independent Gaussian values of standard deviation ``size``, each held for ``every`` [s].

    The spectrum of such held values is flat up to about 1/(2 every) in cycles per second.  The
    same ``seed`` gives the same values, however long the run is.
    """

    size: float
    every: float
    seed: tuple[int, ...] = (0,)

    @property
    def last(self) -> float:
        """Infinite: noise neither repeats nor ends."""
        return 0.0

    def breaks(self, end: float) -> list[float]:
        """Return the times at which a new value is drawn."""
        return _inside([k * self.every for k in range(1, ceil(end / self.every) + 1)], end)

    def on(self, begin: float, end: float) -> Function:
        """Return a constant."""
        number = int((begin + end) / 2 / self.every)
        draws = _draws(self.seed, number // _BLOCK + 1)
        return _constant(self.size * float(draws[number]))


@dataclass(frozen=True, slots=True)
class Signals:
    """Several signals as a vector; signals on the same entry are added.

    Attributes
    ----------
    count : the length of the vector.
    placed : (index in the vector, signal).
    """

    count: int
    placed: tuple[tuple[int, Signal], ...] = ()

    @property
    def last(self) -> float:
        """The time [s] after which all of them repeat or stay."""
        return max((signal.last for _, signal in self.placed), default=0.0)

    def breaks(self, end: float) -> list[float]:
        """Return the breaks of all, unsorted."""
        return [time for _, signal in self.placed for time in signal.breaks(end)]

    def on(self, begin: float, end: float) -> Callable[[float], Floats]:
        """Return (time) -> the vector (count,), on a segment without a break inside."""
        parts = [(place, signal.on(begin, end)) for place, signal in self.placed]

        def vector(time: float) -> Floats:
            found = np.zeros(self.count)
            for place, part in parts:
                found[place] += part(time)
            return found

        return vector


def _inside(times: list[float], end: float) -> list[float]:
    return [time for time in times if 0 < time < end]


def _constant(value: float) -> Function:
    return lambda time: value


@lru_cache(maxsize=32)
def _draws(seed: tuple[int, ...], blocks: int) -> Floats:
    return np.random.default_rng(list(seed)).standard_normal(blocks * _BLOCK)
