"""Runs against closed forms: cut inputs, jumps, samples and holds, and ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import exp, log, pi, sin

import numpy as np
import pytest

from takagi.models import Floats, ModelError
from takagi.models.files.units import parse_unit
from takagi.models.plant_simulation.runs import Experiment, SampledProgram, run
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

FREE = np.array([[-np.inf, np.inf]])


def integrator(
    gain: float = 1.0,
    *,
    limits: Floats = FREE,
    disturbances: Signals | None = None,
    noise: Signals | None = None,
    program: Callable[[], SampledProgram] | None = None,
    step: float | None = None,
) -> Experiment:
    return Experiment(
        rate=lambda x, u, w: np.array([u[0] + w.sum()]),
        commands=lambda x, w: -gain * x,
        inputs=1,
        limits=limits,
        rest=np.array([5.0]),
        far_limits=np.array([np.inf]),
        disturbances=disturbances or Signals(1),
        disturbance_rest=np.zeros(1),
        noise=noise or Signals(1),
        program=program,
        step=step,
    )


class Proportional:
    def __init__(self, gain: float) -> None:
        self.gain, self.seen, self.missed = gain, 0, 0

    def sample(self, state: Floats, signals: Floats) -> Floats:
        self.seen += 1
        return -self.gain * state


def test_an_input_is_cut_until_the_time_of_the_closed_form() -> None:
    """x' = -sat(x), |u| <= 1 from 3: x = 3 - t until t = 2, then exp(2 - t)."""
    found = run(integrator(limits=np.array([[-1.0, 1.0]])), np.array([3.0]), 5.0)
    exact = np.where(found.time < 2, 3 - found.time, np.exp(2 - found.time))

    assert np.abs(found.state[:, 0] - exact).max() < 1e-5
    (cut,) = found.cuts
    assert cut.begin == 0.0 and cut.end == pytest.approx(2.0, abs=1e-4) and not cut.upper
    assert found.sent.min() == -1.0 and found.commanded[0, 0] == -3.0
    assert found.ended == "whole"


def test_an_input_at_its_limit_is_not_cut() -> None:
    """From x = 1 the command is -1, the end of the range: nothing is cut; from 1.001 it is."""
    loop = integrator(limits=np.array([[-1.0, 1.0]]))

    assert run(loop, np.array([1.0]), 2.0).cuts == ()
    (cut,) = run(loop, np.array([1.001]), 2.0).cuts
    assert cut.end == pytest.approx(0.001, abs=1e-4)


def test_a_step_and_a_pulse_act_at_their_times() -> None:
    """x' = -x + w: after a step x = 1 - exp(1 - t); of a pulse the rest decays."""
    stepped = run(integrator(disturbances=Signals(1, ((0, Step(1.0, 1.0)),))), np.zeros(1), 3.0)
    pulsed = run(
        integrator(disturbances=Signals(1, ((0, Pulse(1.0, 1.0, 1.001)),))), np.zeros(1), 3.0
    )

    exact = np.where(stepped.time < 1, 0.0, 1 - np.exp(1 - stepped.time))
    assert np.abs(stepped.state[:, 0] - exact).max() < 1e-6
    # A pulse shorter than any step of the integrator is not lost.
    assert pulsed.state[-1, 0] == pytest.approx((1 - exp(-0.001)) * exp(-1.999), rel=1e-4)
    assert pulsed.disturbance.max() == 1.0


def test_a_law_in_samples_holds_its_command() -> None:
    """x(t + T) = (1 - gain T) x(t) at the samples, with 0.5 s and gain 1.2."""
    made = []

    def program() -> Proportional:
        made.append(Proportional(1.2))
        return made[-1]

    found = run(integrator(program=program, step=0.5), np.array([2.0]), 4.0)
    at_samples = [found.state[np.flatnonzero(found.time == 0.5 * k)[0], 0] for k in range(9)]

    assert at_samples == pytest.approx([2.0 * 0.4**k for k in range(9)])
    assert made[0].seen == 8  # the end of the run is no sample


def test_samples_and_jumps_that_fall_together_are_one() -> None:
    """A step at 0.3 with samples of 0.1: 3 times 0.1 is not 0.3 in floating point."""
    own = Proportional(0.0)
    loop = integrator(
        program=lambda: own, step=0.1, disturbances=Signals(1, ((0, Step(1.0, 0.3)),))
    )
    found = run(loop, np.zeros(1), 1.0)

    assert found.state[-1, 0] == pytest.approx(0.7, abs=1e-9) and own.seen == 10


def test_noise_reaches_the_law_and_not_the_state() -> None:
    """With samples of 0.1 s: x(k+1) = x(k) - T gain (x(k) + n(k))."""
    noise = Noise(0.5, 0.1, (1,))
    loop = integrator(noise=Signals(1, ((0, noise),)), program=lambda: Proportional(2.0), step=0.1)
    found = run(loop, np.array([1.0]), 1.0)
    x = 1.0
    for k in range(10):
        x -= 0.1 * 2.0 * (x + noise.on(0.1 * k, 0.1 * (k + 1))(0.1 * k))

    assert found.state[-1, 0] == pytest.approx(x, abs=1e-7)


def test_discrete_time_cuts_and_disturbs_too() -> None:
    """x+ = x + sat(-x) + w on samples of 1 s: 3, 2, 1, 0, then the step."""
    loop = replace(
        integrator(limits=np.array([[-1.0, 1.0]]), disturbances=Signals(1, ((0, Step(1.0, 4.0)),))),
        rate=lambda x, u, w: x + u + w,
        step=1.0,
        discrete=True,
    )
    found = run(loop, np.array([3.0]), 6.0)

    assert found.state[:, 0] == pytest.approx([3, 2, 1, 0, 0, 1, 1])
    (cut,) = found.cuts
    assert (cut.begin, cut.end) == (0.0, 2.0)


@pytest.mark.parametrize(
    ("rate", "start", "ended"),
    [
        (lambda x, u, w: x - 5.0, 1.0, "far"),
        (lambda x, u, w: np.array([-1.0 / (float(x[0]) - 6.0)]), 1.0, "undefined"),
        (lambda x, u, w: np.log(x - 5.5), 0.0, "undefined"),
    ],
)
def test_a_run_that_ends_early_says_how(rate: object, start: float, ended: str) -> None:
    loop = replace(integrator(), rate=rate, far_limits=np.array([20.0]))  # type: ignore[arg-type]
    found = run(loop, np.array([start]), 10.0)

    assert found.ended == ended
    if ended == "far":
        assert found.time[-1] == pytest.approx(log(20), abs=0.05)


def test_too_many_samples_are_refused_before_the_run() -> None:
    loop = integrator(program=lambda: Proportional(1.0), step=1e-6)

    with pytest.raises(ModelError, match="10000000 samples and jumps"):
        run(loop, np.zeros(1), 10.0)


def test_a_law_with_a_state_of_its_own_sees_what_is_measured() -> None:
    """x' = u + w, u = -s, s' = 2 (x - s): x = w, s = w; with an offset d x = w - d."""
    offset = Signals(1, ((0, Step(0.25, 0.0)),))
    push = Signals(1, ((0, Step(0.5, 1.0)),))
    for noise, rest in ((Signals(1), 0.5), (offset, 0.25)):
        loop = replace(
            integrator(disturbances=push, noise=noise),
            commands=lambda z, w: -z[1:],
            law_rate=lambda z, u: 2 * (z[:1] - z[1:]),
        )
        found = run(loop, np.array([1.0, 0.0]), 20.0)

        assert found.ended == "whole"
        assert found.state[-1] == pytest.approx([rest, 0.5], abs=1e-6)


def test_a_law_with_a_state_of_its_own_in_discrete_time() -> None:
    """x+ = x + u, u = -s/2, s+ = x: x and s follow [[1, -1/2], [1, 0]] to the last digit."""
    loop = replace(
        integrator(disturbances=Signals(0), step=1.0),
        rate=lambda x, u, w: x + u,
        commands=lambda z, w: -z[1:] / 2,
        law_rate=lambda z, u: z[:1],
        disturbance_rest=np.zeros(0),
        discrete=True,
    )
    found = run(loop, np.array([1.0, 0.0]), 8.0)

    z = np.array([1.0, 0.0])
    for row in found.state:
        assert row == pytest.approx(z, abs=1e-12)
        z = np.array([[1.0, -0.5], [1.0, 0.0]]) @ z


FORCE = parse_unit("kN")


def value(signal: Signal, time: float, end: float = 10.0) -> float:
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
