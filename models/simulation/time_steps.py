"""How a simulation is cut in time: samples of the law, and the plant's own steps within them."""

from __future__ import annotations

from math import ceil, isfinite

from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Law
from takagi.models.laws.sampled import SampledLaw
from takagi.models.simulation.wind import WindSeries

# Of the plant's integration [s]: resolves all its modes.
TIME_STEP = 0.02
# A computation time is looked for among the steps of up to this many more to a sample.
MOST_STEPS = 400


def sampled_program(
    law: Law | SampledLaw, time_step: float | None, controller_step: float | None
) -> SampledLaw:
    """Return the law as a program; a plain law takes the steps that are given."""
    if not isinstance(law, SampledLaw):
        given = [step for step in (controller_step, time_step, TIME_STEP) if step is not None]
        if not (given[0] > 0 and isfinite(given[0])):
            raise ModelError(f"step {given[0]:g} s was given; it must be above 0")
        return SampledLaw(law, given[0])
    if controller_step not in (None, law.sample_time):
        raise ModelError(
            f"controller step {controller_step:g} s was given for a law that is sampled every "
            f"{law.sample_time:g} s; leave the step out"
        )
    return law


def fitting_step(sample_time: float, computation_time: float, longest: float = TIME_STEP) -> float:
    """Return the largest step up to ``longest`` [s] that divides sample and computation time."""
    period, late = sample_time, computation_time
    # A period that is a whole multiple of the longest step must not get one more step by rounding.
    least = max(1, ceil(period / longest - 1e-9))
    for count in range(least, least + MOST_STEPS):
        share = late * count / period
        if abs(share - round(share)) < 1e-9 * count:
            return period / count
    raise ModelError(
        f"computation time {late:g} s was given with a sample time of {period:g} s; a simple "
        "fraction of the sample time is needed, such as a half or a quarter"
    )


def step_counts(time_step: float, period: float, wind: WindSeries) -> tuple[int, int]:
    """Return (time steps per controller sample, controller samples)."""
    if not time_step > 0:
        raise ModelError(f"time step {time_step:g} s was given; it must be above 0")
    inner = whole_steps(period, time_step, "controller step")
    if inner < 1:
        raise ModelError(
            f"controller step {period:g} s was given with time step {time_step:g} s; it must be "
            "a whole multiple of it"
        )
    # The quotient of two decimals such as 0.3 / 0.1 may be just below a whole number.
    samples = int(wind.duration / period + 1e-9)
    if samples < 1:
        raise ModelError(
            f"wind {wind.name!r} lasts {wind.duration:g} s, less than one step of {period:g} s"
        )
    return inner, samples


def whole_steps(time: float, step: float, what: str) -> int:
    """Return how many steps a time is."""
    count = round(time / step)
    if abs(count * step - time) > 1e-9 * time:
        raise ModelError(
            f"{what} {time:g} s was given with time step {step:g} s; it must be a whole multiple "
            "of it"
        )
    return count
