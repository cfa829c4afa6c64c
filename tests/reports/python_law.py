"""The whole controller of a turbine's design, run by the law in Python sample by sample."""

from __future__ import annotations

from math import exp

import numpy as np

from takagi.certificates import TurbineDesign
from takagi.models.laws.protocol import Command, Measurement, SampledLaw
from takagi.models.simulation.turbine_plant import SpeedFilter


class FilteredSpeed:
    """What law and observer read, from a first speed at rest on."""

    def __init__(self, filters: SpeedFilter, sample_time: float, speed: float) -> None:
        slow, fast = exp(-sample_time * filters.corner), exp(-sample_time * filters.stop)
        pole = np.array([1.0, -fast])
        both = np.polymul(pole, pole)
        taken = 2 * (1 - filters.passed) if filters.stop else 0.0
        # P - P^2 in powers of 1/z, over (1 - q/z)^2.
        difference = (1 - fast) * np.array([fast, -fast, 0.0])
        self.numerator = (1 - slow) * (both - taken * difference)
        self.denominator = np.polymul(both, [1.0, -slow])
        self.inputs, self.outputs = [speed] * 2, [speed] * 3

    def __call__(self, measured: float) -> float:
        inputs = [measured, *self.inputs]
        found = float(self.numerator @ inputs - self.denominator[1:] @ self.outputs)
        self.inputs, self.outputs = inputs[:2], [found, *self.outputs[:2]]
        return found


class PythonLaw:
    """Low-pass, observer, law and rate limits of a design in Python, from their first sample on."""

    def __init__(self, design: TurbineDesign, sample_time: float) -> None:
        limits = design.turbine.torque_rate_limit, design.turbine.pitch_rate_limit
        self._program = SampledLaw(design.law, sample_time, 0.0, *limits)
        self._law, self._watch = design.law, design.observer.observer
        self._started, self._design = False, design

    def sample(self, measured: float, pitch: float, guess: float) -> Command:
        T = self._program.sample_time
        if not self._started:
            assert self._design.speed_filter is not None
            self._filter = FilteredSpeed(self._design.speed_filter, T, measured)
        speed = self._filter(measured)
        if not self._started:
            self._estimator = self._watch.initial_state(speed, guess)
            state = self._law.initial_state(guess)
            first = self._law.command(state, Measurement(speed, pitch, guess))
            self._within = self._program.start(guess, first)
            self._started = True
        self.estimate = self._watch.wind_estimate(self._estimator)
        command, self._within = self._program.step(
            self._within, Measurement(speed, pitch, self.estimate)
        )
        rate = self._watch.state_rate(self._estimator, speed, pitch, command.torque)
        self._estimator = self._estimator + T * rate
        return command
