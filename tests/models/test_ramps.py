"""Ramps by which two actuators or regions share: convex sums, slopes, placement, identities."""

from __future__ import annotations

from fractions import Fraction
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Floats, Interval, ModelError, nrel5mw
from takagi.models.laws.published.regional_schedule import CouplingFilter, Variant, coupling_filter
from takagi.models.ramps import (
    Ramp,
    Shape,
    effort_ramp,
    ramp,
    ramp_slope,
    rated_speed_ramp,
    share_range,
    share_value,
)

RATED = 1.267109  # rad/s, 12.1 rpm of the NREL 5-MW reference turbine
shapes = st.sampled_from(get_args(Shape))
ramps = st.builds(Ramp, st.floats(-5, 5), st.floats(1e-3, 3), shapes)


@given(ramps, st.floats(-20, 20))
def test_weights_are_a_convex_sum(ramp: Ramp, x: float) -> None:
    """w_1, w_2 lie in [0, 1] and sum to 1 everywhere, on the ramp and off it."""
    weights = ramp.weights(x)

    assert np.all(weights >= 0)
    assert float(weights.sum()) == pytest.approx(1.0, abs=1e-15)


@given(ramps, st.floats(-20, 20))
def test_one_number_and_an_array_agree(ramp: Ramp, x: float) -> None:
    assert ramp.at(x) == pytest.approx(float(ramp(x)), abs=1e-15)


@pytest.mark.parametrize(("placement", "at_rated"), [(0.0, 1.0), (0.5, 0.5), (1.0, 0.0)])
def test_placement_says_what_happens_at_rated_speed(placement: float, at_rated: float) -> None:
    """Below, around, above rated speed: w_2 there is 1, 1/2, 0."""
    ramp = rated_speed_ramp(RATED, overlap=0.1, placement=placement)

    assert ramp.at(RATED) == pytest.approx(at_rated, abs=1e-12)
    assert ramp.width == 0.1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.0, -0.1, "linear"), "width above 0, or 0 for a switch"),
        ((float("nan"), 1.0, "linear"), "finite"),
        ((0.0, 1.0, "smoth"), "did you mean 'smooth'"),
    ],
)
def test_a_bad_ramp_is_refused(arguments: tuple[float, float, Shape], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        Ramp(*arguments)


efforts = st.fractions(-10, 10, max_denominator=1000)
overlaps = st.fractions("1/100", 5, max_denominator=1000)


@given(efforts, overlaps)
def test_what_one_delivers_less_what_the_other_takes_is_the_effort(
    s: Fraction, e: Fraction
) -> None:
    """psi(s) - psi(-s) = s, and the slopes add up to 1."""
    assert ramp(s, e) - ramp(-s, e) == s
    assert ramp_slope(s, e) + ramp_slope(-s, e) == 1
    assert ramp(s, e) >= 0


def test_pieces_meet_where_the_overlap_ends() -> None:
    """Values and slopes at -e, 0 and e: 0, e/4, e and 0, 1/2, 1."""
    e = Fraction(3, 2)

    assert [ramp(s, e) for s in (-e, Fraction(0), e)] == [0, e / 4, e]
    assert [ramp_slope(s, e) for s in (-e, Fraction(0), e)] == [0, Fraction(1, 2), 1]
    assert ramp(-e - 1, e) == 0
    assert ramp(e + 1, e) == e + 1


@given(efforts, efforts, overlaps)
def test_shares_are_convex_and_give_back_the_ramp(s: Fraction, rest: Fraction, e: Fraction) -> None:
    """psi(s) = psi(r) + F (s - r), psi(-s) = psi(-r) - (1 - F)(s - r), F in [0, 1]."""
    share = share_value(s, rest, e)

    assert 0 <= share <= 1
    assert ramp(s, e) == ramp(rest, e) + share * (s - rest)
    assert ramp(-s, e) == ramp(-rest, e) - (1 - share) * (s - rest)


@given(st.tuples(efforts, efforts, efforts, efforts), overlaps)
def test_the_range_of_the_share_holds_every_share(
    four: tuple[Fraction, Fraction, Fraction, Fraction], e: Fraction
) -> None:
    low, rest, s, high = sorted(four)[0], four[1], four[2], sorted(four)[3]
    found = share_range(Interval(low, high), rest, e)

    assert found.lower <= share_value(s, rest, e) <= found.upper
    assert found.lower == share_value(low, rest, e)
    assert found.upper == share_value(high, rest, e)


@given(st.lists(efforts, min_size=1, max_size=5), overlaps)
def test_floating_point_is_the_exact_ramp(s: list[Fraction], e: Fraction) -> None:
    exact = [float(ramp(one, e)) for one in s]

    np.testing.assert_allclose(effort_ramp([float(x) for x in s], float(e)), exact, atol=1e-12)


TURBINE = nrel5mw()
RATED_TORQUE, TOP = TURBINE.rated_torque, TURBINE.maximum_torque
variants = st.sampled_from(get_args(Variant))


def matrix(law: CouplingFilter, speed: float, torque: float) -> Floats:
    return np.asarray(np.tensordot(law.memberships(speed, torque), law.corners, axes=1))


def torque_factor(law: CouplingFilter, torque: Floats) -> Floats:
    return np.asarray(np.tensordot(law.torque_corners, law.torque_weights(torque), axes=1))


@st.composite
def filters(draw: st.DrawFn) -> CouplingFilter:
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
def test_sum_over_rules_is_the_filter(law: CouplingFilter, speed: float, torque: float) -> None:
    """sum h^a_m F_m = diag(f_2(T_g), f_1(omega)): torque first, as u = (T_g, beta_ref) has it."""
    f_2, f_1 = law.factors_at(speed, torque)

    np.testing.assert_allclose(matrix(law, speed, torque), np.diag([f_2, f_1]), atol=1e-12)


@given(st.floats(50.0, 8000.0), st.floats(0.0, RATED_TORQUE * 1.2))
def test_saturated_is_phi_over_torque(overlap: float, torque: float) -> None:
    """f_2 T_g is identity, then a parabola, then T_max; wherever T_g <= T_top."""
    law = coupling_filter(TURBINE, torque_overlap=overlap, variant="saturated")
    passed = law.factors_at(1.0, torque)[0] * torque
    half = overlap / 2
    if torque <= RATED_TORQUE - half:
        expected = torque
    elif torque >= RATED_TORQUE + half:
        expected = RATED_TORQUE * max(1.0, torque / TOP)
    else:
        expected = RATED_TORQUE - (RATED_TORQUE + half - torque) ** 2 / (4 * half)

    assert passed == pytest.approx(expected, rel=1e-12)


def test_corners_are_the_published_four() -> None:
    """F_1..F_4 of the filter equation, with f_2 on torque because u = (T_g, beta_ref)."""
    law = coupling_filter(TURBINE, variant="sector", torque_overlap=2000.0)
    top = RATED_TORQUE / (RATED_TORQUE - 2000.0)

    expected = [np.diag(pair) for pair in ((1, 0), (top, 0), (1, 1), (top, 1))]
    np.testing.assert_allclose(law.corners, expected)


def test_memberships_follow_the_published_products() -> None:
    """h^a_2 = w_11 w_22: at low speed and low torque the second rule acts alone."""
    law = coupling_filter(TURBINE, variant="sector")

    np.testing.assert_allclose(law.memberships(1.0, law.minimum_torque), [0, 1, 0, 0])
    np.testing.assert_allclose(law.memberships(1.0, RATED_TORQUE), [1, 0, 0, 0])
    np.testing.assert_allclose(law.memberships(1.5, RATED_TORQUE), [0, 0, 1, 0])


def test_memberships_are_vectorised_over_a_map() -> None:
    """A speed grid against a torque grid gives (4, speeds, torques), as membership plots need."""
    law = coupling_filter(TURBINE)
    speeds, torques = np.linspace(1.0, 1.5, 7)[:, None], np.linspace(0, TOP, 5)[None, :]
    h = law.memberships(speeds, torques)

    assert h.shape == (4, 7, 5)
    np.testing.assert_allclose(h[:, 3, 2], law.memberships(speeds[3, 0], torques[0, 2]))


@pytest.mark.parametrize("shape", get_args(Shape))
def test_sector_slope_exceeds_one(shape: Shape) -> None:
    """The pass-through below T_min costs a slope > 1: stated, attained, and nowhere exceeded."""
    law = coupling_filter(TURBINE, variant="sector", torque_shape=shape)
    low, high = law.torque_slope_range
    torque = np.linspace(0, RATED_TORQUE, 200_001)
    slope = np.diff(torque_factor(law, torque) * torque) / np.diff(torque)

    assert high > 1 + (RATED_TORQUE - law.minimum_torque) / law.torque_overlap
    assert float(slope.max()) == pytest.approx(high, rel=1e-3)
    assert float(slope.min()) == pytest.approx(low, abs=1e-3)


@pytest.mark.parametrize(("shape", "dip"), [("linear", 0.0), ("smooth", 2000.0 * 3**0.5 / 18)])
def test_sector_holds_rated_torque_on_its_window(shape: Shape, dip: float) -> None:
    """Linear ramps never fall below T_max on [T_min, T_max]; smooth ones dip.

    w = 3 s^2 - 2 s^3 leaves max(q - 3 q^2 + 2 q^3) = sqrt(3)/18 of the window, to first order.
    """
    law = coupling_filter(TURBINE, variant="sector", torque_overlap=2000.0, torque_shape=shape)
    torque = np.linspace(law.minimum_torque, RATED_TORQUE, 4001)
    lowest = float((torque_factor(law, torque) * torque).min())

    assert lowest == pytest.approx(RATED_TORQUE - dip, abs=0.05 * dip + 1e-9)


@given(st.floats(50.0, 8000.0), st.floats(0, 1), st.floats(0, 1))
def test_saturated_slope_stays_in_zero_to_one(overlap: float, a: float, b: float) -> None:
    """Every secant of phi lies in [0, 1], up to the largest command."""
    law = coupling_filter(TURBINE, torque_overlap=overlap)
    x, y = sorted((a * TOP, b * TOP))
    rise = law.factors_at(1.0, y)[0] * y - law.factors_at(1.0, x)[0] * x

    assert -1e-9 <= rise <= (y - x) + 1e-9


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"torque_overlap": -1.0}, "0 <= overlap < minimum < rated"),
        ({"torque_overlap": 3e4}, "narrow the overlap"),
        ({"torque_overlap": 9000.0}, "above the largest command"),
        ({"variant": "sectr"}, "did you mean 'sector'"),
        ({"minimum_torque": RATED_TORQUE}, "minimum < rated"),
    ],
)
def test_a_bad_filter_is_refused(arguments: dict[str, object], words: str) -> None:
    fields: dict[str, object] = {"variant": "saturated", "torque_overlap": 2000.0}
    fields |= {"minimum_torque": RATED_TORQUE - 2000.0} | arguments
    with pytest.raises(ModelError, match=words):
        CouplingFilter(
            Ramp(1.2, 0.1),
            fields["variant"],  # type: ignore[arg-type]
            RATED_TORQUE,
            fields["torque_overlap"],  # type: ignore[arg-type]
            fields["minimum_torque"],  # type: ignore[arg-type]
            TOP,
        )
