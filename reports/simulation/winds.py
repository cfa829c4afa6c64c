"""The winds of a simulation, from the words of `takagi simulate --wind`.

    15                      steady 15 m/s; 15m/s is the same
    turbulent:11:B:7        normal turbulence about 11 m/s, IEC class B (or A, C), seed 7
    turbulent:11:B:1-6      the same with six seeds
    step:10:12.5            a step
    ramp:10:12.5:0.2        a ramp of 0.2 m/s a second
    gust:11                 the extreme operating gust, class I B
    coherent:11             the extreme coherent gust, without a change of direction
    wind.csv, field.bts     a table of time and wind; a full field of TurbSim over the rotor's disc

    paper, step, gust, coherent, ramp    without numbers: some winds around rated wind

What stands behind a colon may be left out from the end: class B, and the seed of the simulation.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.simulation.scenario import PAPER_DURATION, PAPER_SEED, published_winds
from takagi.models.simulation.wind import (
    WindSeries,
    class_turbulence,
    coherent_gust_wind,
    gust_wind,
    ramp_wind,
    read_full_field,
    read_wind_table,
    steady_wind,
    step_wind,
)
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

# An hour at 50 samples a second: a longer record adds no information and needs much memory.
LONGEST = 3600.0
# Half the height of the steps around rated wind [m/s].
HALF_STEP = 1.5
# Slope of a ramp unless it is given [m/s^2].
RAMP_RATE = 0.2
# Of turbulence of a class.
CLASS_SEED = 1
MOST_SEEDS = 1000
_SEEDS = re.compile(r"(turbulent:[^:]*:[^:]*):(\d+)-(\d+)", re.ASCII)
SUFFIXES = (".csv", ".bts")
DEFAULT_WINDS = ("paper",)


class _Asked(NamedTuple):
    """What the makers of winds read: the turbine, duration [s] and seed."""

    turbine: Turbine
    duration: float
    seed: int | None

    @property
    def begin(self) -> float:
        """When a gust begins [s]: early, so that most of the record shows how the loop settles."""
        return min(30.0, self.duration / 4)

    @property
    def rated(self) -> float:
        """Rated wind [m/s]."""
        return round(rated_wind(self.turbine), 2)

    def gust(self, mean: float) -> WindSeries:
        radius = self.turbine.rotor_radius
        return gust_wind(mean, self.duration, rotor_radius=radius, begin=self.begin)

    def coherent(self, mean: float) -> WindSeries:
        return coherent_gust_wind(mean, self.duration, begin=self.begin)

    def step(self, before: float, after: float) -> WindSeries:
        return step_wind(before, after, self.duration, begin=self.duration / 4)

    def ramp(self, before: float, after: float, rate: float = RAMP_RATE) -> WindSeries:
        return ramp_wind(before, after, self.duration, rate=rate, begin=self.begin)

    def turbulent(self, mean: float, name: str = "B", seed: int | None = None) -> WindSeries:
        turbine, given = self.turbine, self.seed if seed is None else seed
        return class_turbulence(
            mean,
            self.duration,
            CLASS_SEED if given is None else given,
            turbulence_class=name,
            rotor_radius=turbine.rotor_radius,
            hub_height=turbine.hub_height,
        )


def _paper(asked: _Asked) -> tuple[WindSeries, ...]:
    seed = PAPER_SEED if asked.seed is None else asked.seed
    return published_winds(asked.turbine, asked.duration, seed)


def _steps(asked: _Asked) -> tuple[WindSeries, ...]:
    low, high = asked.rated - HALF_STEP, asked.rated + HALF_STEP
    return asked.step(low, high), asked.step(high, low)


def _gusts(asked: _Asked) -> tuple[WindSeries, ...]:
    return tuple(asked.gust(asked.rated + distance) for distance in (-2.5, 0.0, 4.5))


def _coherent(asked: _Asked) -> tuple[WindSeries, ...]:
    # From partial load the gust ends at full load, 15 m/s higher.
    return (asked.coherent(asked.rated - 4.0),)


def _ramps(asked: _Asked) -> tuple[WindSeries, ...]:
    share = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    speed = np.array([8.0, 8.0, 14.0, 8.0, 8.0])
    return (WindSeries(share * asked.duration, speed, "ramp 8 to 14 to 8 m/s"),)


class _Form(NamedTuple):
    """A word and what may stand behind it.

    Attributes
    ----------
    numbers : names of the values behind the word, the first ``needed`` of which must be there.
    duration : of the wind unless it is given [s]; of the word alone ``duration_alone``.
    one : the wind of given values;  alone : the winds of the word alone, None if there are none.
    """

    about: str
    numbers: tuple[str, ...]
    needed: int
    duration: float
    one: Callable[..., WindSeries] | None
    alone: Callable[[_Asked], tuple[WindSeries, ...]] | None = None
    seeded: bool = False


FORMS: Mapping[str, _Form] = MappingProxyType(
    {
        "paper": _Form(
            "three turbulent winds, the same turbulence at different means",
            (), 0, PAPER_DURATION, None, _paper, seeded=True,
        ),
        "turbulent": _Form(
            "normal turbulence of IEC 61400-1",
            ("MEAN", "CLASS", "SEED"), 1, 600.0, _Asked.turbulent, seeded=True,
        ),
        "step": _Form("steps of the wind", ("FROM", "TO"), 2, 120.0, _Asked.step, _steps),
        "ramp": _Form(
            "ramps of the wind", ("FROM", "TO", "RATE"), 2, 180.0, _Asked.ramp, _ramps
        ),
        "gust": _Form(
            "the extreme operating gust of IEC 61400-1", ("MEAN",), 1, 90.0, _Asked.gust, _gusts
        ),
        "coherent": _Form(
            "the extreme coherent gust of IEC 61400-1 without a change of direction",
            ("MEAN",), 1, 90.0, _Asked.coherent, _coherent,
        ),
    }
)  # fmt: skip
_STEADY = _Form("a steady wind", ("WIND",), 1, 120.0, None)
_EXAMPLES = "15, turbulent:11:B:7, step:10:12.5, ramp:10:12.5, gust:11, coherent:8, wind.csv, a.bts"


def requested_winds(
    turbine: Turbine,
    texts: Sequence[str] = DEFAULT_WINDS,
    *,
    duration: float | None = None,
    seed: int | None = None,
) -> tuple[WindSeries, ...]:
    """Return the winds of words, in their order; what is given twice is there once.

    Parameters
    ----------
    texts : as the head of this file has them.
    duration : of every wind [s]; None takes each word's, of a file all that it has.
    seed : 0 or more, of turbulence that states none.

    Raises
    ------
    ModelError : a word that is no wind, values that it does not have, a wind outside cut-in to
        cut-out, a file that is none; a duration that is too short or above an hour; a seed below
        0, or for winds without chance.
    """
    if duration is not None and not (isfinite(duration) and 0 < duration <= LONGEST):
        raise ModelError(
            f"duration {duration:g} s was given; it must be above 0 and at most {LONGEST:g} s (for "
            "more of the same turbulence, simulate several seeds)"
        )
    if seed is not None and seed < 0:
        raise ModelError(f"seed {seed} was given; it must be 0 or more")
    words = [text.strip() for text in texts]
    forms = [FORMS.get(text.partition(":")[0], _STEADY) for text in words]
    if seed is not None and not any(form.seeded for form in forms):
        raise ModelError(
            f"seed {seed} was given, but {', '.join(words)} has no turbulence; leave the seed out"
        )
    winds = [wind for text in words for wind in _winds(turbine, text, duration, seed)]
    return tuple({wind.name: wind for wind in winds}.values())


def winds_words(texts: Sequence[str]) -> str:
    """Return what is asked for as a sentence's beginning."""
    about = []
    for text in texts:
        form = FORMS.get(text.strip().partition(":")[0], _STEADY)
        about.append(f"the wind of {text}" if _is_file(text) else form.about)
    return "; ".join(dict.fromkeys(about))


def _winds(
    turbine: Turbine, text: str, duration: float | None, seed: int | None
) -> tuple[WindSeries, ...]:
    if _is_file(text):
        return (_from_file(turbine, Path(text), duration),)
    word, *values = text.split(":")
    speed = _number(word.removesuffix("m/s"))
    if speed is not None and not values:
        _require_inside(turbine, speed, text)
        return (steady_wind(speed, duration or _STEADY.duration),)
    if word not in FORMS:
        raise ModelError(
            f"wind {text!r} is not known{did_you_mean(word, FORMS)}; give one such as {_EXAMPLES}, "
            f"or one of {', '.join(name for name, form in FORMS.items() if form.alone)}"
        )
    if seeds := _SEEDS.fullmatch(text):
        head, first, last = seeds[1], int(seeds[2]), int(seeds[3])
        if not first <= last < first + MOST_SEEDS:
            raise ModelError(
                f"wind {text!r}: seeds from {first} to {last} were given; 1 to {MOST_SEEDS} seeds "
                "are needed, the lower one first, such as 1-6"
            )
        texts = [f"{head}:{k}" for k in range(first, last + 1)]
        return tuple(wind for each in texts for wind in _winds(turbine, each, duration, seed))
    form = FORMS[word]
    asked = _Asked(turbine, duration or form.duration, seed)
    if not values and form.alone is not None:
        return form.alone(asked)
    given = _values(turbine, text, form, values)
    assert form.one is not None
    return (form.one(asked, *given),)


def _values(turbine: Turbine, text: str, form: _Form, values: Sequence[str]) -> list[float | str]:
    """Return the values behind a word: winds inside cut-in to cut-out, a class, a seed."""
    word = text.partition(":")[0]
    if not form.needed <= len(values) <= len(form.numbers):
        raise ModelError(
            f"wind {text!r}: {len(values)} values stand behind {word}; it is written "
            + ":".join((word, *form.numbers))
            + (f", of which the first {form.needed} are needed" if form.needed else "")
        )
    given: list[float | str] = []
    for name, value in zip(form.numbers, values, strict=False):
        number = _number(value.strip().removesuffix("m/s"))
        if name == "CLASS":
            given.append(value.strip().upper())
        elif number is None or (name == "SEED" and not (number >= 0 and number == int(number))):
            needed = "a whole number of 0 or more" if name == "SEED" else "a number"
            raise ModelError(f"wind {text!r}: {value!r} is {name}; {needed} is needed")
        elif name == "SEED":
            given.append(int(number))
        else:
            if name != "RATE":
                _require_inside(turbine, number, text)
            given.append(number)
    return given


def _from_file(turbine: Turbine, path: Path, duration: float | None) -> WindSeries:
    """Return the wind of a file, cut to the duration."""
    if path.suffix.lower() == ".bts":
        wind = read_full_field(
            path, rotor_radius=turbine.rotor_radius, hub_height=turbine.hub_height
        )
    else:
        wind = read_wind_table(path)
    end = wind.duration if duration is None else duration
    # The last decimals of a time step in 32 bits must not count.
    if end > wind.duration * (1 + 1e-6):
        raise ModelError(
            f"{path}: the file has {wind.duration:g} s and --duration is {end:g} s; give a "
            "duration up to that of the file"
        )
    if end > LONGEST:
        raise ModelError(
            f"{path}: the file has {wind.duration:g} s; at most {LONGEST:g} s are simulated in one "
            "run: give --duration"
        )
    last = wind.time[0] + end
    inside = wind.time < last - 1e-9 * end
    time = np.append(wind.time[inside], last)
    cut = WindSeries(time, np.append(wind.speed[inside], wind.at(last)), wind.name)
    _require_inside(turbine, float(np.mean(cut.speed)), f"{path}, its mean")
    return cut


def _require_inside(turbine: Turbine, speed: float, text: str) -> None:
    if not turbine.cut_in <= speed <= turbine.cut_out:
        raise ModelError(
            f"wind {text!r}: {speed:g} m/s was given; {turbine.name} runs from {turbine.cut_in:g} "
            f"to {turbine.cut_out:g} m/s, and its laws have tables for these winds alone"
        )


def _is_file(text: str) -> bool:
    return Path(text).suffix.lower() in SUFFIXES


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
