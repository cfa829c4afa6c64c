"""Signals over time, as deviations from rest: step, pulse, ramp, sine and band-limited noise.

A loop with signals is integrated segment by segment.  ``breaks`` has the times at which a signal
jumps or has a kink; between two breaks it is the smooth function that ``on`` returns.  A jump
belongs to the segment that begins at its time, so the integrator never evaluates the other value.

A user writes a signal as a kind, a size with its unit, and times with their units:

    step 0.2 at 1s                     pulse 3 N from 1s to 1.5s    pulse 3 N at 1s for 500ms
    ramp 5 deg from 1s to 3s           ramp 5 deg at 1s for 2s      constant 0.2
    sine 0.1 period 2s                 sine 0.1 frequency 3 rad/s from 1s
    noise 0.1 every 10ms seed 3

A size without a unit is in the unit of the variable in the plant's file; a time without a unit is
in s.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import ceil, isfinite, pi, sin

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import Unit, parse_unit

Function = Callable[[float], float]
# Random numbers are drawn in blocks, so that a longer run begins with those of a shorter one.
_BLOCK = 1024


@dataclass(frozen=True)
class Signal(ABC):
    """A deviation from rest over time, in SI units.  It is 0 before its first break.

    ``size`` : the largest deviation [SI]; of noise its standard deviation.
    """

    size: float

    @property
    def edges(self) -> tuple[float, ...]:
        """The times [s] at which it jumps or has a kink; 0 where ``breaks`` gives them."""
        return (0.0,)

    @property
    def last(self) -> float:
        """The time [s] after which it repeats or stays as it is."""
        return self.edges[-1]

    def breaks(self, end: float) -> list[float]:
        """Return the times in (0, end) at which it jumps or has a kink."""
        return [time for time in self.edges if 0 < time < end]

    @abstractmethod
    def on(self, begin: float, end: float) -> Function:
        """Return the function of time on [begin, end], an interval without a break inside."""


@dataclass(frozen=True)
class Step(Signal):
    """``size`` from ``start`` [s] on."""

    start: float

    @property
    def edges(self) -> tuple[float, ...]:
        return (self.start,)

    def on(self, begin: float, end: float) -> Function:
        return _constant(self.size if (begin + end) / 2 > self.start else 0.0)


@dataclass(frozen=True)
class Pulse(Signal):
    """``size`` from ``start`` to ``stop`` [s], 0 before and after."""

    start: float
    stop: float

    @property
    def edges(self) -> tuple[float, ...]:
        return self.start, self.stop

    def on(self, begin: float, end: float) -> Function:
        return _constant(self.size if self.start < (begin + end) / 2 < self.stop else 0.0)


@dataclass(frozen=True)
class Ramp(Signal):
    """A line from 0 at ``start`` to ``size`` at ``stop`` [s], which it keeps."""

    start: float
    stop: float

    @property
    def edges(self) -> tuple[float, ...]:
        return self.start, self.stop

    def on(self, begin: float, end: float) -> Function:
        middle = (begin + end) / 2
        if middle < self.start:
            return _constant(0.0)
        if middle > self.stop:
            return _constant(self.size)
        slope = self.size / (self.stop - self.start)
        return lambda time: slope * (time - self.start)


@dataclass(frozen=True)
class Sine(Signal):
    """size sin(2 pi (t - start) / period) from ``start`` [s] on."""

    period: float
    start: float = 0.0

    @property
    def edges(self) -> tuple[float, ...]:
        return (self.start,)

    @property
    def last(self) -> float:
        """The time after a few periods [s]."""
        return self.start + 3 * self.period

    def on(self, begin: float, end: float) -> Function:
        if (begin + end) / 2 < self.start:
            return _constant(0.0)
        rate = 2 * pi / self.period
        return lambda time: self.size * sin(rate * (time - self.start))


@dataclass(frozen=True)
class Noise(Signal):
    """Independent Gaussian values of standard deviation ``size``, each held for ``every`` [s].

    The spectrum of such held values is flat up to about 1/(2 every) in cycles per second.  The
    same ``seed`` gives the same values, however long the run is.
    """

    every: float
    seed: tuple[int, ...] = (0,)

    def breaks(self, end: float) -> list[float]:
        """Return the times at which a new value is drawn; noise neither repeats nor ends."""
        times = [k * self.every for k in range(1, ceil(end / self.every) + 1)]
        return [time for time in times if 0 < time < end]

    def on(self, begin: float, end: float) -> Function:
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
        functions = [(position, signal.on(begin, end)) for position, signal in self.placed]

        def vector(time: float) -> Floats:
            values = np.zeros(self.count)
            for position, function in functions:
                values[position] += function(time)
            return values

        return vector


def _constant(value: float) -> Function:
    return lambda time: value


@lru_cache(maxsize=32)
def _draws(seed: tuple[int, ...], blocks: int) -> Floats:
    return np.random.default_rng(list(seed)).standard_normal(blocks * _BLOCK)


KINDS: Mapping[str, str] = {
    "step": "step 0.2 at 1s",
    "pulse": "pulse 0.2 from 1s to 1.5s",
    "ramp": "ramp 0.2 from 1s to 3s",
    "sine": "sine 0.2 period 2s",
    "noise": "noise 0.2 every 10ms",
    "constant": "constant 0.2",
}
# Kind -> the words that may follow its size.
_WORDS: Mapping[str, tuple[str, ...]] = {
    "step": ("at",),
    "pulse": ("at", "from", "to", "for"),
    "ramp": ("at", "from", "to", "for"),
    "sine": ("period", "frequency", "at", "from"),
    "noise": ("every", "seed"),
    "constant": (),
}
_ALL_WORDS = ("at", "from", "to", "for", "period", "frequency", "every", "seed")
_SPLIT = re.compile(rf"(?<![A-Za-z])({'|'.join(_ALL_WORDS)})(?![A-Za-z])")
_NUMBER = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*")
_LARGEST_SEED = 2**63


def parse_signal(
    text: str,
    unit: Unit,
    *,
    place: str,
    seed: tuple[int, ...] = (0,),
    every: Callable[[], float] | None = None,
) -> Signal:
    """Return the signal of a text, in SI units.

    Parameters
    ----------
    unit : unit of the disturbed variable, as in the plant's file.
    place : the first words of each message, such as the option's name.
    seed : seed of noise if the text has none.
    every : the time [s] for which a value of noise is held, if the text has none.

    Raises
    ------
    ModelError : an unknown kind or word, a number or unit that does not fit, a time below 0, or an
        end before its start.
    """
    return _Reader(text, unit, place, seed, every).signal()


class _Reader:
    """The parts of one text."""

    def __init__(
        self,
        text: str,
        unit: Unit,
        owner: str,
        seed: tuple[int, ...],
        every: Callable[[], float] | None,
    ) -> None:
        self.text, self.unit, self.seed, self.every = text.strip(), unit, seed, every
        self.place = f"{owner} {self.text!r}"
        kind, _, behind = re.sub(r"^white\s+", "", self.text).partition(" ")
        if kind not in KINDS:
            examples = "; ".join(KINDS.values())
            raise ModelError(
                f"{self.place}: {kind!r} is no kind of signal{did_you_mean(kind, KINDS)}; write "
                f"one of: {examples}"
            )
        self.kind, self.example = kind, KINDS[kind]
        first, *words = _SPLIT.split(behind)
        self.size_text = first
        self.given: dict[str, str] = {}
        for word, value in zip(words[::2], words[1::2], strict=True):
            if word not in _WORDS[kind]:
                words_known = ", ".join(_WORDS[kind]) or "nothing"
                raise self.error(f"{word!r} does not belong to a {kind}; behind its size it has "
                                 f"{words_known}")  # fmt: skip
            if word in self.given:
                raise self.error(f"{word!r} stands there twice")
            self.given[word] = value

    def error(self, words: str) -> ModelError:
        return ModelError(f"{self.place}: {words}; write for instance '{self.example}'")

    def signal(self) -> Signal:
        size = self.size()
        match self.kind:
            case "step":
                return Step(size, self.time("at"))
            case "constant":
                # From the first instant on.
                return Step(size, 0.0)
            case "pulse":
                return Pulse(size, *self.span())
            case "ramp":
                return Ramp(size, *self.span())
            case "sine":
                return Sine(size, self.period(), self.time(self.first("at", "from"), default=0.0))
        if size < 0:
            raise self.error(f"its size is a standard deviation, and {self.size_text.strip()} is "
                             "below 0")  # fmt: skip
        return Noise(size, self.held(), self.drawn())

    def size(self) -> float:
        number, unit = self.number(self.size_text, "its size", self.unit)
        return float(unit.to_si(number))

    def number(self, text: str, quantity: str, default_unit: Unit) -> tuple[Fraction, Unit]:
        match = _NUMBER.fullmatch(text)
        if match is None:
            given_text = f"{text.strip()!r} was given" if text.strip() else "it is missing"
            raise self.error(
                f"{quantity} must be a number with or without a unit, and {given_text}"
            )
        try:
            unit = parse_unit(match.group(2)) if match.group(2) else default_unit
        except ModelError as error:
            raise ModelError(f"{self.place}: {error}") from error
        if unit.dimension != default_unit.dimension:
            raise self.error(
                f"{quantity} is in {default_unit.text}, which {match.group(2)!r} does not fit"
            )
        value = Fraction(match.group(1))
        if not isfinite(float(match.group(1))) or abs(value) > Fraction(10) ** 100:
            raise self.error(f"{quantity} is too large")
        return value, unit

    def time(self, word: str, *, default: float | None = None) -> float:
        if word not in self.given:
            if default is not None:
                return default
            raise self.error(f"the time behind {word!r} is missing")
        number, unit = self.number(self.given[word], f"the time behind {word!r}", parse_unit("s"))
        if number < 0:
            raise self.error(f"the time behind {word!r} is below 0, and a run begins at 0")
        return float(unit.to_si(number))

    def first(self, *words: str) -> str:
        given_words = [word for word in words if word in self.given]
        if len(given_words) > 1:
            raise self.error(
                f"{given_words[0]!r} and {given_words[1]!r} say the same; leave one out"
            )
        return given_words[0] if given_words else words[0]

    def span(self) -> tuple[float, float]:
        start = self.time(self.first("from", "at"))
        word = self.first("to", "for")
        if word not in self.given:
            raise self.error("its end is missing: 'to' with a time, or 'for' with a duration")
        stop = self.time(word) + (start if word == "for" else 0.0)
        if not stop > start:
            raise self.error(f"it would end at {stop:g} s, not after its start at {start:g} s")
        return start, stop

    def period(self) -> float:
        word = self.first("period", "frequency")
        if word not in self.given:
            raise self.error("how fast it is is missing: 'period' with a time, or 'frequency' in "
                             "rad/s")  # fmt: skip
        if word == "period":
            seconds = self.time("period")
        else:
            number, unit = self.number(self.given[word], "the frequency", parse_unit("rad/s"))
            seconds = 2 * pi / float(unit.to_si(number)) if number > 0 else 0.0
        if not seconds > 0:
            raise self.error(f"its {word} must be above 0")
        return seconds

    def held(self) -> float:
        if "every" not in self.given and self.every is not None:
            return self.every()
        seconds = self.time("every")
        if not seconds > 0:
            raise self.error("the time behind 'every' must be above 0")
        return seconds

    def drawn(self) -> tuple[int, ...]:
        if "seed" not in self.given:
            return self.seed
        text = self.given["seed"].strip()
        if not text.isascii() or not text.isdigit() or int(text) >= _LARGEST_SEED:
            raise self.error(f"the seed must be a whole number from 0 on, and {text!r} was given")
        return (int(text),)
