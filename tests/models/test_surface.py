"""The bicubic surface: reproduces its table, exact derivatives, ranges that hold."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RectBivariateSpline

from takagi.models import ModelError, Surface
from takagi.models.intervals.interval import Interval
from takagi.models.splines.spline import interpolate
from takagi.models.turbine.loader import nrel5mw

ORDERS = [(dx, dy) for dx in range(3) for dy in range(3)]
X = np.array([0.0, 1.0, 1.5, 2.0, 3.0, 4.5, 5.0])
Y = np.array([-1.0, -0.4, 0.0, 0.3, 1.0])


def cubic(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return a bicubic polynomial: a not-a-knot spline reproduces it."""
    return np.asarray((x**3 - 2 * x + 1) * (y**3 - y**2 + 3))


def polynomial_surface() -> Surface:
    return interpolate(X, Y, cubic(X[:, None], Y), name="cubic")


def boxes() -> st.SearchStrategy[tuple[Interval, Interval]]:
    """Return boxes inside the torque table, of the size of a wind cell and smaller."""
    return st.tuples(
        st.integers(2000, 13000), st.integers(0, 1500), st.integers(-870, 4800), st.integers(0, 400)
    ).map(
        lambda t: (
            Interval(Fraction(t[0], 1000), Fraction(t[0] + t[1], 1000)),
            Interval(Fraction(t[2], 10000), Fraction(t[2] + t[3], 10000)),
        )
    )


def samples(box: tuple[Interval, Interval], count: int) -> tuple[np.ndarray, np.ndarray]:
    x, y = (np.linspace(float(side.lower), float(side.upper), count) for side in box)
    return x[:, None], y[None, :]


def test_table_is_reproduced() -> None:
    """The spline of rounded coefficients passes through the table to 1e-9."""
    turbine = nrel5mw()
    pitch = np.radians(np.arange(-5.0, 31.0))
    ratios = np.arange(2.0, 14.6, 0.5)[:, None]
    c_p = turbine.power(ratios, pitch)

    assert c_p[11, 5] == pytest.approx(0.465925, abs=1e-3)  # the table's peak, 7.5 and 0 deg
    assert np.abs(ratios * turbine.torque(ratios, pitch) - c_p).max() < 1e-9


def test_agrees_with_an_independent_spline() -> None:
    """FITPACK's interpolating bicubic spline (same not-a-knot knots) agrees off the table."""
    turbine = nrel5mw()
    ratios, pitch = np.arange(2.0, 14.6, 0.5), np.radians(np.arange(-5.0, 31.0))
    other = RectBivariateSpline(ratios, pitch, turbine.power(ratios[:, None], pitch), s=0)
    x, y = np.linspace(2, 14.5, 97), np.linspace(-0.087, 0.52, 83)

    assert np.abs(other(x, y) - turbine.power(x[:, None], y)).max() < 1e-9


@pytest.mark.parametrize(("dx", "dy"), ORDERS)
def test_a_cubic_is_reproduced_with_its_derivatives(dx: int, dy: int) -> None:
    x, y = np.linspace(0, 5, 21)[:, None], np.linspace(-1, 1, 17)
    along_x = np.polyval(np.polyder([1.0, 0.0, -2.0, 1.0], dx), x)
    along_y = np.polyval(np.polyder([1.0, -1.0, 0.0, 3.0], dy), y)

    assert polynomial_surface()(x, y, dx, dy) == pytest.approx(along_x * along_y, abs=1e-8)


@given(boxes(), st.sampled_from(ORDERS))
def test_bounds_contain_samples(box: tuple[Interval, Interval], order: tuple[int, int]) -> None:
    torque = nrel5mw().torque
    low, high = torque.bounds(*box, *order).outward_floats()
    values = torque(*samples(box, 25), *order)
    rounding = 1e-11 * max(1.0, float(np.abs(values).max()))

    assert low - rounding <= values.min() and values.max() <= high + rounding


@pytest.mark.parametrize(("dx", "dy"), ORDERS)
def test_a_point_box_is_the_exact_value(dx: int, dy: int) -> None:
    torque = nrel5mw().torque
    for x, y in (("7.3", "0.1"), ("7.5", "0"), ("2", "-0.0872664626"), ("14.5", "0.523598775598")):
        bound = torque.bounds(Interval.of(x), Interval.of(y), dx, dy)
        value = torque(float(x), float(y), dx, dy)

        assert bound.width == 0
        assert bound.lower == torque.exact(x, y, dx, dy)
        assert float(bound.lower) == pytest.approx(float(value), rel=1e-9, abs=1e-9)


def test_one_changed_digit_is_noticed() -> None:
    """Raising one coefficient by 1e-12 moves the exact value: nothing was rounded away."""
    good = polynomial_surface()
    coefficients = good.coefficients.copy()
    coefficients[2, 2] = np.round(coefficients[2, 2] + 1e-12, 12)
    other = Surface(good.x_knots, good.y_knots, coefficients)

    assert 0 < other.exact("1.7", "0.1") - good.exact("1.7", "0.1") < Fraction(2, 10**12)


def test_outside_is_refused_with_the_range() -> None:
    torque = nrel5mw().torque

    with pytest.raises(ModelError, match=r"tip-speed ratio .* = 15 .* 2 to 14.5"):
        torque(15.0, 0.0)
    with pytest.raises(ModelError, match="pitch .* clip=True"):
        torque([7.0, 8.0], [0.0, 0.6])
    with pytest.raises(ModelError, match="c_Q"):
        torque(float("nan"), 0.0)
    with pytest.raises(ModelError, match="leaves the table"):
        torque.bounds(Interval.of(7, 15), Interval.of(0))
    with pytest.raises(ModelError, match="orders are 0, 1 or 2"):
        torque(7.0, 0.0, 3, 0)
    with pytest.raises(ModelError, match="0, 1 or 2 is needed"):
        torque.bounds(Interval.of(7), Interval.of(0), 0, 3)


def test_clip_holds_the_edge_value() -> None:
    torque = nrel5mw().torque

    assert float(torque(20.0, 1.0, clip=True)) == float(torque(14.5, torque.y_range[1]))


@pytest.mark.parametrize(
    ("x", "y", "table", "words"),
    [
        (X[:3], Y, np.zeros((3, 5)), "at least 4"),
        (X[::-1], Y, np.zeros((7, 5)), "strictly increasing"),
        (X, Y, np.zeros((5, 7)), "shape"),
        (X, Y, np.where(np.arange(35).reshape(7, 5) == 8, np.nan, 0.0), "x = 1, y = 0.3"),
    ],
)
def test_bad_tables_are_refused(
    x: np.ndarray, y: np.ndarray, table: np.ndarray, words: str
) -> None:
    with pytest.raises(ModelError, match=words):
        interpolate(x, y, table)


def test_a_surface_is_defined_by_short_decimals() -> None:
    """More than 12 decimals, or sizes that do not fit, are refused."""
    good = polynomial_surface()

    with pytest.raises(ModelError, match="12 places"):
        Surface(good.x_knots, good.y_knots, good.coefficients + np.pi * 1e-9)
    with pytest.raises(ModelError, match="knots ask for"):
        Surface(good.x_knots, good.y_knots, good.coefficients[1:])
    with pytest.raises(ModelError, match="must increase"):
        Surface(good.x_knots[::-1], good.y_knots, good.coefficients)
    with pytest.raises(ValueError, match="read-only"):
        good.coefficients[0, 0] = 1.0
