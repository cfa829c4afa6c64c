"""The tube around the trim: exact slopes against floats, and enclosures against samples."""

from __future__ import annotations

from functools import lru_cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import Interval, ModelError, nrel5mw
from takagi.models.turbine.data import rotor_torque_gradient
from takagi.models.turbine.operating_band import (
    OperatingBand,
    Slope,
    operating_band,
    slope_enclosure,
    slope_gradient,
)

SLOPES: tuple[Slope, ...] = ("speed", "pitch", "wind")
POINTS = st.tuples(st.floats(1.0, 1.3), st.floats(0.01, 0.35), st.floats(9.0, 22.0))


def at(point: tuple[float, float, float]) -> tuple[Interval, Interval, Interval]:
    """Return a point as three intervals without width."""
    omega, beta, v = (Interval.of(value) for value in point)
    return omega, beta, v


@lru_cache
def band() -> OperatingBand:
    """Return a tube across rated wind."""
    return operating_band(
        nrel5mw(), (10.0, 13.0), speed_band="0.1", pitch_band="0.02", wind_band="0.5"
    )


@settings(max_examples=40, derandomize=True, deadline=None)
@given(POINTS)
def test_slopes_at_a_point_agree_with_floats(point: tuple[float, float, float]) -> None:
    """Exact arithmetic and the float gradient give the same three numbers."""
    expected = [float(g) / nrel5mw().inertia for g in rotor_torque_gradient(nrel5mw(), *point)]

    for slope, value in zip(SLOPES, expected, strict=True):
        found = slope_enclosure(nrel5mw(), slope, *at(point))
        assert float(found.centre) == pytest.approx(value, rel=1e-7, abs=1e-10)
        assert float(found.width) < 1e-7


@settings(max_examples=40, derandomize=True, deadline=None)
@given(POINTS, st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_an_enclosure_contains_what_lies_in_the_box(
    point: tuple[float, float, float], s: float, t: float, u: float
) -> None:
    """Any point of a small box has its slopes inside the box's enclosures."""
    sizes = (0.02, 0.005, 0.3)
    box = [Interval.of(p, p + size) for p, size in zip(point, sizes, strict=True)]
    inside = [p + share * z for p, share, z in zip(point, (s, t, u), sizes, strict=True)]
    gradient = rotor_torque_gradient(nrel5mw(), *inside)

    for slope, value in zip(SLOPES, gradient, strict=True):
        found = slope_enclosure(nrel5mw(), slope, box[0], box[1], box[2])
        assert float(found.lower) - 1e-12 <= float(value) / nrel5mw().inertia
        assert float(value) / nrel5mw().inertia <= float(found.upper) + 1e-12


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (
            (1.2, 0.1, 40.0),
            r"tip-speed ratio 1\.89 to 1\.89, and the c_P and c_T tables cover 2 to",
        ),
        ((1.2, 0.9, 12.0), r"pitch 0\.9 to 0\.9 rad, and the c_P and c_T tables cover"),
    ],
)
def test_entries_that_a_table_lacks_are_named(
    place: tuple[float, float, float], words: str
) -> None:
    """The wind, the entries, and what a user can do: there is no option that shrinks a box."""
    points = [Interval.of(value) for value in place]
    for call in (slope_enclosure, slope_gradient):
        with pytest.raises(ModelError, match=words) as refused:
            call(nrel5mw(), "speed", points[0], points[1], points[2])
        assert f"winds of {place[2]:g} to {place[2]:g} m/s" in str(refused.value)
        assert "leave these winds out by cut_in and cut_out" in str(refused.value)
        assert "shrink the box" not in str(refused.value)


def test_a_wind_band_down_to_zero_is_refused() -> None:
    """The tip-speed ratio has no bound when v may vanish."""
    with pytest.raises(ModelError, match="reaches 0"):
        operating_band(nrel5mw(), (4, 6), speed_band=0.1, pitch_band=0, wind_band=4)
