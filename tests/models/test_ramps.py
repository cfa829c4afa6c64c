"""The pair of ramps: convex sum, placement."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.ramps import Ramp, Shape, rated_speed_ramp

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
    """The scalar path of the control loop is the vectorised formula."""
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
        ((0.0, 0.0, "linear"), "width above 0"),
        ((float("nan"), 1.0, "linear"), "finite"),
        ((0.0, 1.0, "smoth"), "did you mean 'smooth'"),
    ],
)
def test_a_bad_ramp_is_refused(arguments: tuple[float, float, Shape], words: str) -> None:
    """A ramp without width, without a place or of an unknown shape does not come to be."""
    with pytest.raises(ModelError, match=words):
        Ramp(*arguments)
