r"""Turbulent wind as a whole rotor feels it, by spectral synthesis.

At a point, the longitudinal spectrum is Kaimal's; two points a distance r apart are coherent with
an exponential law:

    f S(f) / sigma^2 = 4 f L / V / (1 + 6 f L / V)^(5/3),      L = 8.1 Lambda_1
    C(f, r) = exp(-12 sqrt((f r / V)^2 + (0.12 r / L)^2))

The rotor-effective wind is the mean over the disc, so its spectrum is exactly

    S_rotor(f) = S(f) E[C(f, r)],      r the distance of two random points of the disc

with the density p(r) = 4 r / (pi R^2) arccos(r / 2R) - 2 r^2 / (pi R^3) sqrt(1 - r^2 / 4R^2).
No corner frequency is chosen: the low-pass of the rotor follows from the coherence.  What it does
not hold: rotational sampling (3P), shear, tower shadow.

Source: IEC 61400-1 (ed. 3, 2005), annex B.2 (spectrum, coherence); Schlipf (2016), Lidar-assisted
control concepts for wind turbines, sec. 5.2 (rotor-effective spectrum); Solomon (1978), Geometric
probability, ch. 2 (two points in a disc).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.simulation.wind import TIME_STEP, WindSeries

# Quadrature points for the mean over the disc: 1e-6 against 2000 points up to 10 Hz.
NODES = 300


def kaimal_spectrum(
    frequency: Floats, mean: float, deviation: float, *, hub_height: float = 90.0
) -> Floats:
    """Return the one-sided point spectrum S(f) [(m/s)^2/Hz]; its integral is deviation^2.

    Parameters
    ----------
    frequency : [Hz], >= 0.   mean, deviation : [m/s].   hub_height : [m].

    Source: IEC 61400-1 (ed. 3, 2005), eq. B.14 and table B.1.
    """
    scale = _length_scale(hub_height) / mean
    spectrum = 4 * deviation**2 * scale / (1 + 6 * np.asarray(frequency) * scale) ** (5 / 3)
    return np.asarray(spectrum, dtype=np.float64)


def rotor_share(
    frequency: Floats, mean: float, *, rotor_radius: float = 63.0, hub_height: float = 90.0
) -> Floats:
    """Return S_rotor(f) / S(f) = E[C(f, r)] [-]: 1 for a small rotor, falling with frequency.

    Source: see the head of this file.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    # Squared, so that the nodes are dense at small distances, which matter at high frequencies.
    unit = (nodes + 1) / 2
    distance = 2 * rotor_radius * unit**2
    weight = weights / 2 * 4 * rotor_radius * unit
    half = distance / (2 * rotor_radius)
    density = 4 * distance / (pi * rotor_radius**2) * np.arccos(half) - 2 * distance**2 / (
        pi * rotor_radius**3
    ) * np.sqrt(1 - half**2)
    decay = 12 * np.hypot(np.asarray(frequency)[..., None] / mean, 0.12 / _length_scale(hub_height))
    return np.asarray(np.exp(-decay * distance) @ (density * weight), dtype=np.float64)


def turbulent_wind(
    mean: float,
    intensity: float,
    duration: float,
    seed: int,
    time_step: float = TIME_STEP,
    *,
    rotor_radius: float = 63.0,
    hub_height: float = 90.0,
    period: float | None = None,
    name: str | None = None,
) -> WindSeries:
    """Return mean + sum_k sqrt(2 S_rotor(f_k) / T) cos(2 pi f_k t + phi_k), f_k = k / T.

    The phases are uniform and follow from the seed alone.  The sum has period T and its mean over
    one period is ``mean`` exactly; what is slower than 1 / T is missing.

    Parameters
    ----------
    mean : [m/s].   intensity : deviation of the wind *at a point* over its mean [-]; the rotor
        feels less.   duration, time_step : [s].   seed : the same seed gives the same wind.
    rotor_radius, hub_height : [m].

    Raises
    ------
    ModelError : mean or intensity out of range, fewer than 4 samples, or a wind that falls to 0.
    """
    _check(mean, intensity, duration, time_step, period)
    shape = _realisation(mean, period or duration, seed, time_step, rotor_radius, hub_height)
    time, shape = _cut(shape, duration, time_step)
    return WindSeries(
        time, mean * (1 + intensity * shape), name or f"turbulent {mean:g} m/s, seed {seed}"
    )


def same_turbulence(
    means: Sequence[float],
    intensity: float,
    duration: float,
    seed: int,
    time_step: float = TIME_STEP,
    *,
    rotor_radius: float = 63.0,
    hub_height: float = 90.0,
    period: float | None = None,
) -> tuple[WindSeries, ...]:
    """Return winds V_i (1 + I x(t)), one per mean, with one and the same realisation x(t).

    x(t) is made for the average of the means (the spectrum depends on it through L / V), so that
    gusts come at the same times with the same intensity in every wind.

    Parameters and errors as for ``turbulent_wind``; no means are refused too.

    Source: the scenario of Schulte (2024), Coherent Design of Wind Turbine Controllers, fig. of
    the wind: the same degree of turbulence, different mean values.
    """
    if not means:
        raise ModelError("no mean wind was given; at least one is needed")
    for mean in means:
        _check(mean, intensity, duration, time_step, period)
    middle = float(np.mean(means))
    shape = _realisation(middle, period or duration, seed, time_step, rotor_radius, hub_height)
    time, shape = _cut(shape, duration, time_step)
    return tuple(
        WindSeries(time, mean * (1 + intensity * shape), f"turbulent {mean:g} m/s, seed {seed}")
        for mean in means
    )


def _realisation(
    mean: float, duration: float, seed: int, time_step: float, radius: float, height: float
) -> Floats:
    """Return the fluctuation over the point deviation, one period and its first sample again."""
    samples = round(duration / time_step)
    frequency = np.arange(1, (samples + 1) // 2) / (samples * time_step)
    spectrum = kaimal_spectrum(frequency, mean, 1.0, hub_height=height)
    spectrum = spectrum * rotor_share(frequency, mean, rotor_radius=radius, hub_height=height)
    phases = np.random.default_rng(seed).uniform(0, 2 * pi, len(frequency))
    # The mean of the series is exact because the line of frequency 0 stays empty.
    lines = np.zeros(samples // 2 + 1, dtype=np.complex128)
    amplitude = np.sqrt(2 * spectrum / (samples * time_step))
    # irfft divides by the number of samples, and a real line has two complex halves.
    lines[1 : len(frequency) + 1] = samples / 2 * amplitude * np.exp(1j * phases)
    period = np.fft.irfft(lines, samples)
    return np.asarray(np.append(period, period[0]), dtype=np.float64)


def _cut(shape: Floats, duration: float, time_step: float) -> tuple[Floats, Floats]:
    kept = shape[: round(duration / time_step) + 1]
    return np.arange(len(kept), dtype=np.float64) * time_step, kept


def _length_scale(hub_height: float) -> float:
    """Return L = 8.1 Lambda_1 [m], Lambda_1 = 0.7 z below 60 m and 42 m above."""
    return 8.1 * min(0.7 * hub_height, 42.0)


def _check(
    mean: float, intensity: float, duration: float, time_step: float, period: float | None
) -> None:
    if not (mean > 0 and 0 <= intensity < 1):
        raise ModelError(
            f"mean wind {mean:g} m/s with intensity {intensity:g} was given; the mean must be "
            "above 0 and the intensity between 0 and 1 (0.14 is 14 %)"
        )
    if not (time_step > 0 and duration >= 4 * time_step and np.isfinite(duration)):
        raise ModelError(
            f"duration {duration:g} s at steps of {time_step:g} s was given; at least 4 steps of "
            "a size above 0 are needed"
        )
    if period is not None and not (period >= duration and np.isfinite(period)):
        raise ModelError(
            f"period {period:g} s was given; it must be at least the duration, {duration:g} s"
        )
