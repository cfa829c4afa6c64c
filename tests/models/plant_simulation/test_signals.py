"""Signals over time: values, jumps, what is written as text, and what is refused."""

from __future__ import annotations

from math import pi, sin

import numpy as np
import pytest

from takagi.models import ModelError
from takagi.models.files.units import parse_unit
from takagi.models.plant_simulation.signals import (
    Noise,
    Pulse,
    Ramp,
    Signal,
    Signals,
    Sine,
    Step,
    parse_signal,
)

FORCE = parse_unit("kN")


def value(signal: Signal, time: float, end: float = 10.0) -> float:
    """The value in the middle of the segment that holds the time."""
    edges = np.unique([0.0, *signal.breaks(end), end])
    k = int(np.searchsorted(edges, time, side="right")) - 1
    return signal.on(float(edges[k]), float(edges[min(k + 1, len(edges) - 1)]))(time)


@pytest.mark.parametrize(
    ("text", "signal"),
    [
        ("step 0.2 at 1s", Step(200.0, 1.0)),
        ("step 3 N at 1 s", Step(3.0, 1.0)),
        ("step -3N at 500ms", Step(-3.0, 0.5)),
        ("constant .5", Step(500.0, 0.0)),
        ("pulse 2 N from 1s to 1.5s", Pulse(2.0, 1.0, 1.5)),
        ("pulse 2 N at 1s for 0.5s", Pulse(2.0, 1.0, 1.5)),
        ("ramp 5 from 1 min to 2 min", Ramp(5000.0, 60.0, 120.0)),
        ("sine 1e-1 period 2s", Sine(100.0, 2.0, 0.0)),
        ("noise 0.1 every 10ms seed 3", Noise(100.0, 0.01, (3,))),
        ("white noise 0.1 every 10ms", Noise(100.0, 0.01, (7, 1))),
    ],
)
def test_a_text_is_the_signal_in_si(text: str, signal: Signal) -> None:
    """Sizes without a unit are in that of the file, times without one in s."""
    assert parse_signal(text, FORCE, place="here", seed=(7, 1)) == signal


def test_a_frequency_is_an_angular_one() -> None:
    """3 rad/s has the period 2 pi / 3."""
    found = parse_signal("sine 1 frequency 3 rad/s from 2s", FORCE, place="here")

    assert isinstance(found, Sine)
    assert found.period == pytest.approx(2 * pi / 3) and found.start == 2.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("stop 0.2 at 1s", "'stop' is no kind of signal (did you mean 'step'?)"),
        ("step at 1s", "its size must be a number with or without a unit, and it is missing"),
        ("step 0.2", "the time behind 'at' is missing"),
        ("step 0.2 at -1s", "the time behind 'at' is below 0"),
        ("step 0.2 at 1 m", "the time behind 'at' is in s, which 'm' does not fit"),
        ("step 0.2 K at 1s", "its size is in kN, which 'K' does not fit"),
        ("step 0.2 Newton at 1s", "'Newton' is not known"),
        ("step 0.2 at 1s at 2s", "'at' stands there twice"),
        ("step 0.2 every 1s", "'every' does not belong to a step"),
        ("step 1e400 at 1s", "too large"),
        ("pulse 1 from 2s to 1s", "it would end at 1 s, not after its start at 2 s"),
        ("pulse 1 from 2s", "its end is missing"),
        ("pulse 1 from 1s at 1s to 2s", "'from' and 'at' say the same"),
        ("sine 1", "how fast it is is missing"),
        ("sine 1 period 0s", "its period must be above 0"),
        ("sine 1 frequency 0 rad/s", "its frequency must be above 0"),
        ("noise -1 every 1s", "is below 0"),
        ("noise 1 every 0s", "'every' must be above 0"),
        ("noise 1 every 1s seed x", "the seed must be a whole number"),
        ("noise 1", "the time behind 'every' is missing"),
    ],
)
def test_what_is_refused_says_where_why_and_what_to_write(text: str, words: str) -> None:
    with pytest.raises(ModelError) as caught:
        parse_signal(text, FORCE, place="option --disturbance load:")

    said = str(caught.value)
    assert said.startswith("option --disturbance load:") and words in said


def test_values_on_both_sides_of_a_jump() -> None:
    """A jump belongs to the segment that begins with it."""
    pulse = Pulse(2.0, 1.0, 1.5)

    assert pulse.breaks(10.0) == [1.0, 1.5] and pulse.breaks(1.2) == [1.0]
    assert [value(pulse, t) for t in (0.5, 1.0, 1.49, 1.5, 3.0)] == [0, 2, 2, 0, 0]
    # At the end of a segment the value is that of before the jump.
    assert pulse.on(0.0, 1.0)(1.0) == 0.0


def test_a_ramp_and_a_sine_are_what_they_say() -> None:
    ramp, sine = Ramp(4.0, 1.0, 3.0), Sine(2.0, 4.0, 1.0)

    assert [value(ramp, t) for t in (0.5, 1.5, 2.0, 5.0)] == pytest.approx([0.0, 1.0, 2.0, 4.0])
    assert value(sine, 0.5) == 0.0
    assert value(sine, 2.0) == pytest.approx(2.0) == pytest.approx(2.0 * sin(pi / 2))


def test_noise_is_held_seeded_and_has_its_deviation() -> None:
    noise = Noise(0.5, 0.01, (3, 1))
    short = [value(noise, 0.01 * k + 0.005, 5.0) for k in range(400)]
    longer = [value(noise, 0.01 * k + 0.005, 50.0) for k in range(400)]

    assert short == longer
    assert value(noise, 0.0101, 5.0) == value(noise, 0.0199, 5.0) != value(noise, 0.0201, 5.0)
    # Of 400 values the deviation is within 4 standard errors, 0.5 / sqrt(800) each.
    assert np.std(short) == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(800))
    other = Noise(0.5, 0.01, (4, 1))
    assert value(other, 0.005) != value(noise, 0.005)


def test_signals_on_one_place_are_added() -> None:
    both = Signals(2, ((0, Step(1.0, 0.0)), (0, Sine(2.0, 4.0)), (1, Step(-1.0, 5.0))))

    assert both.on(0.0, 5.0)(1.0) == pytest.approx([3.0, 0.0])
    assert both.on(5.0, 6.0)(5.0) == pytest.approx([3.0, -1.0])
