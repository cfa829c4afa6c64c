r"""Wind over time as a whole rotor feels it: deterministic shapes, and turbulence.

Turbulence is made by spectral synthesis.

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

Wind series from files: a table of time and wind, and a full field of TurbSim over the disc.

A full field is averaged over the points of its grid that lie inside the rotor's disc, at hub
height: the rotor feels that mean.  Shear, veer and what passes single blades are not in it.

Layout of a ``.bts`` file, all little-endian: int16 kind (7, or 8 for a periodic field); int32
points in height and width, points of the tower, time steps; float32 grid spacing in height and
width [m], time step [s], mean wind at the hub [m/s], hub height and height of the lowest row [m];
then for each of the three components float32 slope and offset; int32 length of a text, and the
text.  Then for every time step int16 values v of all points, rows of height outside, width within,
the three components innermost, and those of the tower: wind = (v - offset) / slope.

Source: Jonkman (2014), TurbSim user's guide v2.00.00, appendix on full-field binary files.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, Indices, frozen
from takagi.models.errors import ModelError

TIME_STEP = 0.05
# IEC 61400-1 (ed. 3), table 1: the NREL 5-MW is a class I B machine.
REFERENCE_WIND = 50.0
REFERENCE_INTENSITY = 0.14
# Class of turbulence -> I_ref [-].
INTENSITIES: Mapping[str, float] = MappingProxyType(
    {"A": 0.16, "B": REFERENCE_INTENSITY, "C": 0.12}
)
GUST_DURATION = 10.5
# Of the extreme coherent gust [m/s], [s].
COHERENT_GUST, COHERENT_RISE = 15.0, 10.0
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
            frozen(self, field)
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
        times = np.asarray(time, dtype=np.float64)
        return np.asarray(np.interp(times, self.time, self.speed), dtype=np.float64)


def steady_wind(speed: float, duration: float) -> WindSeries:
    """Return a constant wind [m/s] of this duration [s]."""
    _check_duration(duration, 0.0)
    return WindSeries(np.array([0.0, duration]), np.array([speed, speed]), f"steady {speed:g} m/s")


def step_wind(before: float, after: float, duration: float, *, begin: float = 30.0) -> WindSeries:
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
        f"step {before:g} to {after:g} m/s",
    )


def ramp_wind(
    before: float, after: float, duration: float, *, rate: float, begin: float = 30.0
) -> WindSeries:
    """Return a wind that leaves ``before`` at ``begin`` [s] and reaches ``after`` at ``rate``.

    ``rate`` : size of the slope [m/s^2], above 0; its sign follows from the two winds.

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
        f"ramp {before:g} to {after:g} m/s at {rate:g} m/s^2",
    )


def gust_wind(
    mean: float, duration: float, *, rotor_radius: float, begin: float = 30.0
) -> WindSeries:
    """Return the extreme operating gust: dip, peak, dip within 10.5 s.

        v = V - 0.37 V_gust sin(3 pi s / T) (1 - cos(2 pi s / T)),  s = t - begin in [0, T]
        V_gust = min(1.35 (V_e1 - V), 3.3 sigma_1 / (1 + 0.1 D / Lambda_1))

    with T = 10.5 s, V_e1 = 0.8 * 1.4 * 50 m/s, sigma_1 = 0.14 (0.75 V + 5.6 m/s) and
    Lambda_1 = 42 m (hub at or above 60 m): class I B.

    ``mean`` : V [m/s].   rotor_radius : D / 2 [m].

    Raises
    ------
    ModelError : the gust does not end inside the duration, or wind would not stay above 0.

    Source: IEC 61400-1 (ed. 3, 2005), 6.3.2.2, eqs. 16 to 18.
    """
    _check_duration(duration, begin + GUST_DURATION)
    sigma = REFERENCE_INTENSITY * (0.75 * mean + 5.6)
    yearly = 0.8 * 1.4 * REFERENCE_WIND
    size = min(1.35 * (yearly - mean), 3.3 * sigma / (1 + 0.2 * rotor_radius / LONGITUDINAL_SCALE))

    time = np.linspace(0.0, duration, max(2, round(duration / TIME_STEP) + 1))
    s = np.clip(time - begin, 0.0, GUST_DURATION) / GUST_DURATION
    wave = np.sin(3 * pi * s) * (1 - np.cos(2 * pi * s))
    return WindSeries(time, mean - 0.37 * size * wave, f"gust at {mean:g} m/s")


def coherent_gust_wind(mean: float, duration: float, *, begin: float = 30.0) -> WindSeries:
    """Return the extreme coherent gust: 15 m/s more within 10 s, and the wind stays there.

        v = V + V_cg / 2 (1 - cos(pi s / T)),  s = t - begin in [0, T],  V_cg = 15 m/s, T = 10 s

    The direction of the wind does not change, unlike in the standard: there is no yaw here.

    Raises
    ------
    ModelError : the gust does not end inside the duration, or the mean is not above 0.

    Source: IEC 61400-1 (ed. 3, 2005), 6.3.2.5, eqs. 21 and 22.
    """
    _check_duration(duration, begin + COHERENT_RISE)
    time = np.linspace(0.0, duration, max(2, round(duration / TIME_STEP) + 1))
    s = np.clip(time - begin, 0.0, COHERENT_RISE) / COHERENT_RISE
    rise = COHERENT_GUST / 2 * (1 - np.cos(pi * s))
    return WindSeries(time, mean + rise, f"coherent gust at {mean:g} m/s")


def _check_duration(duration: float, needed: float) -> None:
    if not (np.isfinite(duration) and duration > needed):
        raise ModelError(
            f"duration {duration:g} s was given; more than {needed:g} s is needed here: give a "
            "longer duration or an earlier begin"
        )


# Of a realisation of turbulence from which shorter ones are cut [s].
PERIOD = 600.0
# Quadrature points for the mean over the disc: 1e-6 against 2000 points up to 10 Hz.
NODES = 300


def kaimal_spectrum(
    frequency: Floats, mean: float, deviation: float, *, hub_height: float = 90.0
) -> Floats:
    """Return the one-sided point spectrum S(f) [(m/s)^2/Hz]; its integral is deviation^2.

    ``frequency`` : [Hz], >= 0.   mean, deviation : [m/s].   hub_height : [m].

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

        x(t) = sum_k sqrt(2 S_rotor(f_k) / T) cos(2 pi f_k t + phi_k),   f_k = k / T

    x(t) is made for the average of the means (the spectrum depends on it through L / V), so that
    gusts come at the same times with the same intensity in every wind.  The phases are uniform and
    follow from the seed alone.  The sum has period T and its mean over one period is 0 exactly;
    what is slower than 1 / T is missing.

    Parameters
    ----------
    means : [m/s].   intensity : deviation of the wind *at a point* over its mean [-]; the rotor
        feels less.   duration, time_step : [s].   seed : the same seed gives the same winds.
    rotor_radius, hub_height : [m].   period : T [s]; None takes the duration.

    Raises
    ------
    ModelError : no mean, mean or intensity out of range, fewer than 4 samples, or a wind that falls
        to 0.

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


def class_turbulence(
    mean: float,
    duration: float,
    seed: int,
    *,
    turbulence_class: str = "B",
    rotor_radius: float,
    hub_height: float,
) -> WindSeries:
    """Return normal turbulence of IEC class A, B or C: sigma_1 = I_ref (0.75 V + 5.6 m/s).

    It is cut from a period of 600 s or more, see ``same_turbulence``.

    Raises
    ------
    ModelError : another class, or what ``same_turbulence`` refuses.

    Source: IEC 61400-1 (ed. 3, 2005), table 1 and eq. 11.
    """
    if turbulence_class not in INTENSITIES:
        raise ModelError(
            f"turbulence class {turbulence_class!r} is not known; IEC 61400-1 has A, B and C"
        )
    intensity = INTENSITIES[turbulence_class] * (0.75 + 5.6 / mean)
    (wind,) = same_turbulence(
        [mean],
        intensity,
        duration,
        seed,
        rotor_radius=rotor_radius,
        hub_height=hub_height,
        period=max(duration, PERIOD),
    )
    name = f"turbulent {mean:g} m/s, class {turbulence_class}, seed {seed}"
    return replace(wind, name=name)


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
    shape_cut = shape[: round(duration / time_step) + 1]
    return np.arange(len(shape_cut), dtype=np.float64) * time_step, shape_cut


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


FIELD_KINDS = (7, 8)
_HEADER = struct.Struct("<h4i12fi")
# A grid may end this share of the radius inside the disc: TurbSim rounds its size to whole cells.
UNCOVERED = 0.05


def read_wind_table(path: Path) -> WindSeries:
    """Return the wind of a CSV file: time [s] and wind [m/s] in the first two columns.

    A first line that is no pair of numbers is taken for a heading; lines that begin with # are
    comments.

    Raises
    ------
    ModelError : names the line that has no two numbers, or what a wind series refuses.
    """
    rows: list[tuple[float, float]] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ModelError(
            f"{path}: no table of winds, for it is no text; a CSV file with time [s] and wind "
            "[m/s] is needed, or a full field of TurbSim named .bts"
        ) from error
    for number, line in enumerate(lines, 1):
        cells = [cell.strip() for cell in line.split(",")]
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            rows.append((float(cells[0]), float(cells[1])))
        except (ValueError, IndexError):
            if rows or number > 1:
                raise ModelError(
                    f"{path}, line {number}: {line.strip()!r} was read; time [s] and wind [m/s] "
                    "are needed, as in 0.05,11.3"
                ) from None
    if len(rows) < 2:
        raise ModelError(
            f"{path}: {len(rows)} lines with time [s] and wind [m/s] were read; 2 or more are "
            "needed"
        )
    time, speed = np.array(rows).T
    return WindSeries(time, speed, str(path))


def read_full_field(path: Path, *, rotor_radius: float, hub_height: float) -> WindSeries:
    """Return the wind of a TurbSim ``.bts`` file along the flow, averaged over the rotor's disc.

    ``rotor_radius``, ``hub_height`` : of the turbine [m]; the disc's middle is the grid's in width.

    Raises
    ------
    ModelError : no such file, one that ends early, or a grid that does not cover the disc.
    """
    content = path.read_bytes()
    wrong = f"{path}: no full field of TurbSim"
    if len(content) < _HEADER.size:
        raise ModelError(f"{wrong}, for it has {len(content)} bytes; give its .bts file")
    kind, rows, columns, tower, steps, *figures, letters = _HEADER.unpack_from(content)
    if kind not in FIELD_KINDS:
        raise ModelError(
            f"{wrong}, for it begins with {kind} and not with 7 or 8; give the .bts file that "
            "TurbSim writes with WrADFF = True"
        )
    d_z, d_y, d_t, _, _, lowest, slope, offset = figures[:8]
    sizes = (rows, columns, steps, d_z, d_y, d_t, slope)
    if not all(np.isfinite(size) and size > 0 for size in sizes) or tower < 0 or letters < 0:
        raise ModelError(f"{wrong}: its head has a size that is not above 0; it is damaged")
    begin, values = _HEADER.size + letters, 3 * (rows * columns + tower)
    if len(content) < begin + 2 * values * steps:
        raise ModelError(
            f"{path}: {steps} steps of {rows} x {columns} points are announced and the file ends "
            "before them; write or copy it once more"
        )
    field = np.frombuffer(content, "<i2", values * steps, begin).reshape(steps, values)
    along = field[:, : 3 * rows * columns : 3]
    inside = _disc(path, (rows, columns), (d_z, d_y), lowest, rotor_radius, hub_height)
    mean = along[:, inside].mean(axis=1, dtype=np.float64)
    return WindSeries(d_t * np.arange(steps), (mean - offset) / slope, str(path))


def _disc(
    path: Path,
    points: tuple[int, int],
    spacing: tuple[float, float],
    lowest: float,
    radius: float,
    hub_height: float,
) -> Indices:
    """Return the numbers of the grid's points inside the disc, rows of height outside."""
    height = lowest + spacing[0] * np.arange(points[0]) - hub_height
    width = spacing[1] * (np.arange(points[1]) - (points[1] - 1) / 2)
    reach = min(-height[0], height[-1], width[-1])
    if reach < (1 - UNCOVERED) * radius:
        raise ModelError(
            f"{path}: the grid reaches {reach:.1f} m from the hub at {hub_height:g} m, and the "
            f"rotor's radius is {radius:g} m; make a field for this turbine (HubHt, GridHeight and "
            "GridWidth of TurbSim)"
        )
    inside = np.hypot(height[:, None], width[None, :]) <= radius
    return np.flatnonzero(inside.ravel())
