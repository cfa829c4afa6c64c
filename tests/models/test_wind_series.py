"""Wind series: shapes by their formulas, turbulence by its spectrum, misuse by its message."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.models import ModelError
from takagi.models.simulation.wind import (
    WindSeries,
    class_turbulence,
    coherent_gust_wind,
    gust_wind,
    kaimal_spectrum,
    ramp_wind,
    read_full_field,
    read_wind_table,
    rotor_share,
    same_turbulence,
    step_wind,
)


def test_point_spectrum_holds_the_variance() -> None:
    """The integral of S over all frequencies is sigma^2: IEC 61400-1 (ed. 3), annex B.

    Far above V / L the spectrum is Kolmogorov's: ten times the frequency, 10^(-5/3) of it.
    """
    frequency = np.concatenate([[0.0], np.logspace(-7, 5, 20001)])
    spectrum = kaimal_spectrum(frequency, 11.5, 1.7)

    assert np.trapezoid(spectrum, frequency) == pytest.approx(1.7**2, rel=2e-3)
    low, high = kaimal_spectrum(np.array([50.0, 500.0]), 10.0, 1.0)
    assert high / low == pytest.approx(10 ** (-5 / 3), rel=1e-3)


@pytest.mark.parametrize("frequency", [0.0, 0.1])
def test_rotor_share_equals_the_mean_over_random_points(frequency: float) -> None:
    """The integral over the distance density against 400 000 pairs drawn in the disc."""
    draw = np.random.default_rng(0)
    radius = 63.0 * np.sqrt(draw.uniform(size=(2, 400_000)))
    points = radius * np.exp(2j * np.pi * draw.uniform(size=(2, 400_000)))
    distance = np.abs(points[0] - points[1])
    coherence = np.exp(-12 * np.hypot(frequency * distance / 11.5, 0.12 * distance / 340.2))
    found = rotor_share(np.array([frequency]), 11.5)

    assert abs(found[0] - coherence.mean()) < 4 * coherence.std() / np.sqrt(len(coherence))


def test_turbulence_has_its_mean_and_the_spectrum_it_was_made_from() -> None:
    """Mean as asked; every line of the periodogram equals S_rotor at its frequency."""
    wind = same_turbulence((12.0,), 0.15, 300.0, 7, 0.1)[0]
    lines = np.fft.rfft(wind.speed[:-1] - 12.0)[1:-1]
    frequency = np.arange(1, len(lines) + 1) / 300.0
    density = 2 * np.abs(lines) ** 2 * 0.1 / len(wind.speed[:-1])
    wanted = kaimal_spectrum(frequency, 12.0, 1.8) * rotor_share(frequency, 12.0)

    assert np.mean(wind.speed[:-1]) == pytest.approx(12.0, rel=1e-12)
    assert density == pytest.approx(wanted, rel=1e-6)
    assert wind.speed[0] == wind.speed[-1]


def test_turbulence_follows_from_its_seed() -> None:
    first, again, other = (same_turbulence((10.0,), 0.1, 60.0, seed)[0] for seed in (3, 3, 4))

    assert np.array_equal(first.speed, again.speed)
    assert not np.allclose(first.speed, other.speed, atol=0.1)


def test_a_cut_is_the_beginning_of_its_period() -> None:
    """60 s of a 600 s period are the first 60 s of the 600 s wind."""
    cut = same_turbulence((10.0,), 0.1, 60.0, 3, period=600.0)[0]
    whole = same_turbulence((10.0,), 0.1, 600.0, 3)[0]

    assert np.array_equal(cut.speed, whole.speed[: len(cut.speed)])


@settings(max_examples=15)
@given(st.integers(0, 2**31), st.floats(0.0, 0.2))
def test_same_turbulence_differs_in_the_mean_alone(seed: int, intensity: float) -> None:
    """v_i / mean_i is one and the same function of time."""
    low, high = same_turbulence((8.0, 14.0), intensity, 30.0, seed, 0.1, period=120.0)

    assert low.speed / 8.0 == pytest.approx(high.speed / 14.0, rel=1e-12)


def test_operating_gust_has_its_peak_and_dips() -> None:
    """IEC 61400-1 (ed. 3), eqs. 16 to 18, by hand at 11.45 m/s: V_gust = 3.3 * 1.98625 / 1.3.

    The peak is V + 0.74 V_gust in the middle; two equal dips surround it, deepest where
    sin^2(pi s / T) = 9 / 20, there -0.37 V_gust 2.4 (9 / 20)^(3/2).
    """
    wind = gust_wind(11.45, 60.0, rotor_radius=63.0, begin=20.0)
    gust = 3.3 * 1.98625 / 1.3

    assert wind.at(25.25) == pytest.approx(11.45 + 0.74 * gust, abs=1e-3)
    assert wind.speed.max() == pytest.approx(wind.at(25.25), abs=1e-3)
    assert wind.at(22.45) == pytest.approx(wind.at(28.05), abs=1e-9)
    assert wind.speed.min() == pytest.approx(11.45 - 0.37 * gust * 2.4 * 0.45**1.5, abs=1e-3)
    assert wind.at([0.0, 20.0, 30.5, 60.0]) == pytest.approx(11.45)


def test_step_ramp_and_constant() -> None:
    step, ramp = step_wind(9.0, 12.0, 60.0), ramp_wind(14.0, 8.0, 100.0, rate=0.2, begin=10.0)

    assert step.at([0.0, 30.0, 30.001, 60.0]) == pytest.approx([9, 9, 12, 12])
    assert ramp.at([10.0, 25.0, 40.0, 100.0]) == pytest.approx([14, 11, 8, 8])


def test_a_series_cannot_be_changed() -> None:
    speed = np.array([5.0, 6.0])
    wind = WindSeries(np.array([0.0, 1.0]), speed)
    speed[0] = 99.0

    assert wind.speed[0] == 5.0
    with pytest.raises(ValueError, match="read-only"):
        wind.speed[0] = 1.0


def test_misuse_is_told() -> None:
    with pytest.raises(ModelError, match="one length, at least 2"):
        WindSeries(np.array([0.0]), np.array([5.0]))
    with pytest.raises(ModelError, match="increase strictly"):
        WindSeries(np.array([0.0, 0.0]), np.array([5.0, 5.0]))
    with pytest.raises(ModelError, match="speed is -1 m/s at 1 s"):
        WindSeries(np.array([0.0, 1.0]), np.array([5.0, -1.0]))
    with pytest.raises(ModelError, match="more than 40.5 s is needed"):
        gust_wind(10.0, 40.0, rotor_radius=63.0)
    with pytest.raises(ModelError, match="rate above 0"):
        ramp_wind(8.0, 14.0, 60.0, rate=-1.0)
    with pytest.raises(ModelError, match="0.14 is 14 %"):
        same_turbulence((10.0,), 14.0, 60.0, 1)[0]
    with pytest.raises(ModelError, match="period 30 s"):
        same_turbulence((10.0,), 0.1, 60.0, 1, period=30.0)[0]
    with pytest.raises(ModelError, match="no mean wind"):
        same_turbulence((), 0.1, 60.0, 1)


def test_coherent_gust_by_its_formula() -> None:
    """IEC 61400-1 (ed. 3), eq. 21: half of 15 m/s after half of 10 s, and no way back."""
    wind = coherent_gust_wind(9.0, 60.0, begin=20.0)

    assert wind.at([0.0, 20.0, 22.5, 25.0, 30.0, 60.0]) == pytest.approx(
        [9.0, 9.0, 9.0 + 7.5 * (1 - np.sqrt(0.5)), 16.5, 24.0, 24.0]
    )
    with pytest.raises(ModelError, match="longer duration"):
        coherent_gust_wind(9.0, 25.0, begin=20.0)


def test_turbulence_of_a_class_has_its_deviation() -> None:
    """Before the rotor's filter sigma_1 = I_ref (0.75 V + 5.6 m/s): classes differ by I_ref."""
    winds = {
        name: class_turbulence(
            10.0, 600.0, 1, turbulence_class=name, rotor_radius=1e-4, hub_height=90.0
        )
        for name in "ABC"
    }
    moving = {name: winds[name].speed - 10.0 for name in "ABC"}

    assert moving["A"] / moving["B"] == pytest.approx(0.16 / 0.14)
    assert moving["C"] / moving["B"] == pytest.approx(0.12 / 0.14)
    # What is slower than the period and faster than the samples is missing from the deviation.
    assert 0.9 < np.std(moving["B"]) / (0.14 * (7.5 + 5.6)) < 1.0


HUB, RADIUS = 90.0, 60.0
TEXT = b"a field of the tests"


def write_field(
    path: Path, along: NDArray[np.float64], spacing: float, *, tower: int = 3, kind: int = 7
) -> None:
    """Write the wind along the flow, (steps, height, width), in TurbSim's full-field layout.

    Source: Jonkman (2014), TurbSim user's guide v2.00.00, full-field binary files.
    """
    steps, rows, columns = along.shape
    slope, offset = 1000.0, -20000.0
    lowest = HUB - spacing * (rows - 1) / 2
    content = struct.pack("<hiiii", kind, rows, columns, tower, steps)
    content += struct.pack("<ffffff", spacing, spacing, 0.05, 11.0, HUB, lowest)
    content += struct.pack("<ffffff", slope, offset, 1500.0, 7.0, 1500.0, -7.0)
    content += struct.pack("<i", len(TEXT)) + TEXT
    for field in along:
        for value in field.ravel():
            content += struct.pack("<hhh", round(value * slope + offset), 17, -17)
        content += struct.pack("<hhh", 1, 2, 3) * tower
    path.write_bytes(content)


def sheared(steps: int, points: int, spacing: float) -> NDArray[np.float64]:
    """A wind with steps in time, shear over height and width, and a cubic that a square has."""
    z = spacing * (np.arange(points) - (points - 1) / 2) / RADIUS
    t = np.arange(steps)[:, None, None]
    up, across = z[None, :, None], z[None, None, :]
    return np.asarray(10.0 + 0.5 * t + 3.0 * up - 2.0 * across + up**2, dtype=np.float64)


@pytest.mark.parametrize("kind", [7, 8])
def test_a_full_field_is_averaged_over_the_disc(tmp_path: Path, kind: int) -> None:
    """Linear shear averages out; z^2 has the mean R^2 / 4 over a disc, R^2 / 3 over a square."""
    path = tmp_path / "field.bts"
    write_field(path, sheared(4, 121, 1.0), 1.0, kind=kind)
    wind = read_full_field(path, rotor_radius=RADIUS, hub_height=HUB)

    assert wind.time == pytest.approx(0.05 * np.arange(4), abs=1e-7)
    assert wind.speed == pytest.approx(10.25 + 0.5 * np.arange(4), abs=0.005)


def test_the_disc_stands_at_the_turbines_hub(tmp_path: Path) -> None:
    """A smaller rotor that stands 10 m higher feels the shear between."""
    path = tmp_path / "field.bts"
    write_field(path, sheared(2, 121, 1.0), 1.0)
    wind = read_full_field(path, rotor_radius=30.0, hub_height=HUB + 10.0)
    share = 10.0 / RADIUS

    assert wind.speed[0] == pytest.approx(10.0 + 3.0 * share + share**2 + 1 / 16, abs=0.005)


def test_a_table_may_have_a_heading_and_comments(tmp_path: Path) -> None:
    path = tmp_path / "wind.csv"
    path.write_text("time [s], wind [m/s]\n# measured\n0, 8\n10, 9.5, cloudy\n\n20,8\n")
    wind = read_wind_table(path)

    assert wind.time.tolist() == [0.0, 10.0, 20.0]
    assert wind.speed.tolist() == [8.0, 9.5, 8.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,wind\n0,8\n1,fast\n", "line 3: '1,fast'"),
        ("0;8\n1;8\n", "line 2"),
        ("time,wind\n0,8\n", "1 lines"),
        ("0,8\n0,9\n", "increase strictly"),
        ("0,8\n1,-2\n", "speed is -2 m/s at 1 s"),
    ],
)
def test_a_damaged_table_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "wind.csv"
    path.write_text(text)
    with pytest.raises(ModelError, match=words):
        read_wind_table(path)


def test_a_damaged_field_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "field.bts"
    write_field(path, sheared(2, 13, 10.0), 10.0)
    content = path.read_bytes()
    for damaged, words in (
        (b"time,wind\n" + content, "begins with"),
        (content[:-1], "ends before"),
        (content[:50], "50 bytes"),
        (content[:2] + struct.pack("<i", 0) + content[6:], "not above 0"),
    ):
        path.write_bytes(damaged)
        with pytest.raises(ModelError, match=words):
            read_full_field(path, rotor_radius=RADIUS, hub_height=HUB)
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"reaches 60.0 m .* radius is 80 m"):
        read_full_field(path, rotor_radius=80.0, hub_height=HUB)
    assert read_full_field(path, rotor_radius=RADIUS, hub_height=HUB).speed[0] > 0
