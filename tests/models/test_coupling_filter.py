"""The coupling filter: its four rules, its convex sum, and the slopes of its two variants."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Floats, ModelError, nrel5mw
from takagi.models.laws.published.regional_schedule import CouplingFilter, Variant, coupling_filter
from takagi.models.ramps import Ramp, Shape

TURBINE = nrel5mw()
RATED, TOP = TURBINE.rated_torque, TURBINE.maximum_torque
variants = st.sampled_from(get_args(Variant))


def matrix(law: CouplingFilter, speed: float, torque: float) -> Floats:
    """Return F = sum_m h^a_m F_m, (2, 2)."""
    return np.asarray(np.tensordot(law.memberships(speed, torque), law.corners, axes=1))


def torque_factor(law: CouplingFilter, torque: Floats) -> Floats:
    """Return f_2(T_g), the convex sum of its corners."""
    return np.asarray(np.tensordot(law.torque_corners, law.torque_weights(torque), axes=1))


@st.composite
def filters(draw: st.DrawFn) -> CouplingFilter:
    """Filters of the reference turbine over the overlaps that somebody might try."""
    return coupling_filter(
        TURBINE,
        speed_overlap=draw(st.floats(0.01, 0.4)),
        torque_overlap=draw(st.floats(50.0, 8000.0)),
        variant=draw(variants),
        placement=draw(st.floats(0, 1)),
        shape=draw(st.sampled_from(get_args(Shape))),
        torque_shape=draw(st.sampled_from(get_args(Shape))),
    )


@given(filters(), st.floats(0.3, 2.0), st.floats(-1e4, 9e4))
def test_memberships_are_a_convex_sum(law: CouplingFilter, speed: float, torque: float) -> None:
    """h^a_m >= 0 and sum h^a_m = 1 at every speed and every commanded torque."""
    h = law.memberships(speed, torque)

    assert h.shape == (4,)
    assert np.all(h >= 0)
    assert float(h.sum()) == pytest.approx(1.0, abs=1e-14)


@given(filters(), st.floats(0.3, 2.0), st.floats(-1e4, 9e4))
def test_sum_over_rules_is_the_filter(law: CouplingFilter, speed: float, torque: float) -> None:
    """sum h^a_m F_m = diag(f_2(T_g), f_1(omega)): torque first, as u = (T_g, beta_ref) has it."""
    f_2, f_1 = law.factors_at(speed, torque)

    np.testing.assert_allclose(matrix(law, speed, torque), np.diag([f_2, f_1]), atol=1e-12)


@given(st.floats(50.0, 8000.0), st.floats(0.0, RATED * 1.2))
def test_saturated_is_phi_over_torque(overlap: float, torque: float) -> None:
    """f_2 T_g is identity, then a parabola, then T_max; wherever T_g <= T_top."""
    law = coupling_filter(TURBINE, torque_overlap=overlap, variant="saturated")
    passed = law.factors_at(1.0, torque)[0] * torque
    half = overlap / 2
    if torque <= RATED - half:
        expected = torque
    elif torque >= RATED + half:
        expected = RATED * max(1.0, torque / TOP)
    else:
        expected = RATED - (RATED + half - torque) ** 2 / (4 * half)

    assert passed == pytest.approx(expected, rel=1e-12)


def test_corners_are_the_published_four() -> None:
    """F_1..F_4 of the filter equation, with f_2 on torque because u = (T_g, beta_ref)."""
    law = coupling_filter(TURBINE, variant="sector", torque_overlap=2000.0)
    top = RATED / (RATED - 2000.0)

    expected = [np.diag(pair) for pair in ((1, 0), (top, 0), (1, 1), (top, 1))]
    np.testing.assert_allclose(law.corners, expected)


def test_memberships_follow_the_published_products() -> None:
    """h^a_2 = w_11 w_22: at low speed and low torque the second rule acts alone."""
    law = coupling_filter(TURBINE, variant="sector")

    np.testing.assert_allclose(law.memberships(1.0, law.minimum_torque), [0, 1, 0, 0])
    np.testing.assert_allclose(law.memberships(1.0, RATED), [1, 0, 0, 0])
    np.testing.assert_allclose(law.memberships(1.5, RATED), [0, 0, 1, 0])


def test_memberships_are_vectorised_over_a_map() -> None:
    """A speed grid against a torque grid gives (4, speeds, torques), as membership plots need."""
    law = coupling_filter(TURBINE)
    speeds, torques = np.linspace(1.0, 1.5, 7)[:, None], np.linspace(0, TOP, 5)[None, :]
    h = law.memberships(speeds, torques)

    assert h.shape == (4, 7, 5)
    np.testing.assert_allclose(h[:, 3, 2], law.memberships(speeds[3, 0], torques[0, 2]))


@pytest.mark.parametrize("shape", get_args(Shape))
def test_sector_slope_exceeds_one(shape: Shape) -> None:
    """The pass-through below T_min costs a slope > 1, and a slope < 0 above it."""
    law = coupling_filter(TURBINE, variant="sector", torque_shape=shape)
    torque = np.linspace(0, RATED, 200_001)
    slope = np.diff(torque_factor(law, torque) * torque) / np.diff(torque)

    assert float(slope.max()) > 1 + (RATED - law.minimum_torque) / law.torque_overlap
    assert float(slope.min()) < 0


@pytest.mark.parametrize(("shape", "dip"), [("linear", 0.0), ("smooth", 2000.0 * 3**0.5 / 18)])
def test_sector_holds_rated_torque_on_its_window(shape: Shape, dip: float) -> None:
    """Linear ramps never fall below T_max on [T_min, T_max]; smooth ones dip.

    w = 3 s^2 - 2 s^3 leaves max(q - 3 q^2 + 2 q^3) = sqrt(3)/18 of the window, to first order.
    """
    law = coupling_filter(TURBINE, variant="sector", torque_overlap=2000.0, torque_shape=shape)
    torque = np.linspace(law.minimum_torque, RATED, 4001)
    lowest = float((torque_factor(law, torque) * torque).min())

    assert lowest == pytest.approx(RATED - dip, abs=0.05 * dip + 1e-9)


@given(st.floats(50.0, 8000.0), st.floats(0, 1), st.floats(0, 1))
def test_saturated_slope_stays_in_zero_to_one(overlap: float, a: float, b: float) -> None:
    """Every secant of phi lies in [0, 1], up to the largest command."""
    law = coupling_filter(TURBINE, torque_overlap=overlap)
    x, y = sorted((a * TOP, b * TOP))
    rise = law.factors_at(1.0, y)[0] * y - law.factors_at(1.0, x)[0] * x

    assert -1e-9 <= rise <= (y - x) + 1e-9


def test_f1_on_torque_would_be_noticed() -> None:
    """Without the permutation f_1 would multiply torque: at low speed there would be none."""
    law = coupling_filter(TURBINE)
    right = matrix(law, 1.0, 2e4) @ np.array([2e4, 0.1])

    np.testing.assert_allclose(right, [2e4, 0.0])
    assert not np.allclose(matrix(law, 1.0, 2e4)[::-1, ::-1] @ np.array([2e4, 0.1]), right)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"torque_overlap": -1.0}, "0 <= overlap < minimum < rated"),
        ({"torque_overlap": 3e4}, "narrow the overlap"),
        ({"torque_overlap": 9000.0}, "above the largest command"),
        ({"variant": "sectr"}, "did you mean 'sector'"),
        ({"minimum_torque": RATED}, "minimum < rated"),
    ],
)
def test_a_bad_filter_is_refused(arguments: dict[str, object], words: str) -> None:
    """Torques out of order and unknown variants are told apart and explained."""
    fields: dict[str, object] = {"variant": "saturated", "torque_overlap": 2000.0}
    fields |= {"minimum_torque": RATED - 2000.0} | arguments
    with pytest.raises(ModelError, match=words):
        CouplingFilter(
            Ramp(1.2, 0.1),
            fields["variant"],  # type: ignore[arg-type]
            RATED,
            fields["torque_overlap"],  # type: ignore[arg-type]
            fields["minimum_torque"],  # type: ignore[arg-type]
            TOP,
        )
