"""The partial-load model: exact over its band, with bounds that no sample leaves."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest

from takagi.models import ModelError, TSModel, nrel5mw, partial_load_model
from takagi.models.turbine.operating_band import OperatingBand, operating_band
from takagi.models.turbine.region_models import lowest_wind
from takagi.models.turbine.trim import rated_wind


@lru_cache
def model() -> TSModel:
    return partial_load_model(nrel5mw())


def side(name: str) -> tuple[float, float]:
    lower, upper = model().box[name]
    return float(lower), float(upper)


@lru_cache
def band() -> OperatingBand:
    low, high = side("wind estimate [m/s]")
    return operating_band(nrel5mw(), (low, high), speed_band="0.1", pitch_band=0, wind_band="0.5")


def test_structure_names_and_units() -> None:
    """B holds -n_g / J of the figure sheet: 97 / 43 784 725 kg m^2; the integral has slope -1."""
    found = model()

    assert found.states == ("rotor speed error [rad/s]", "integral of speed deficit [rad]")
    assert found.inputs == ("generator torque deviation [N m]",)
    assert found.disturbances == ("wind deviation [m/s]",)
    np.testing.assert_allclose(found.B[:, 0, 0], -97 / 43_784_725, rtol=1e-7)
    np.testing.assert_array_equal(found.A[:, 1], [[-1, 0]] * 4)
    assert [premise.name for premise in found.premises] == ["a", "d"]


def test_vertices_are_the_decimals_of_the_bounds() -> None:
    """Each vertex entry prints as the exact bound, so a certificate can speak of the decimals."""
    a, d = model().premises
    corners = {
        (Fraction(repr(float(A[0, 0]))), Fraction(repr(float(E[0, 0]))))
        for A, E in zip(model().A, model().E, strict=True)
    }

    assert corners == {(x, y) for x in (a.lower, a.upper) for y in (d.lower, d.upper)}


def test_default_range_ends_at_rated_wind_and_begins_where_the_band_fits() -> None:
    turbine = nrel5mw()
    low, high = side("wind estimate [m/s]")

    assert high == pytest.approx(rated_wind(turbine), abs=1e-5)
    assert low == lowest_wind(turbine, speed_band="0.1", wind_band="0.5")
    with pytest.raises(ModelError, match="narrow the speed band or the wind band"):
        partial_load_model(turbine, wind_range=(low - 0.05, 8))


def test_a_wind_range_into_full_load_is_refused() -> None:
    with pytest.raises(ModelError, match="reaches into full load"):
        partial_load_model(nrel5mw(), wind_range=(6, 13))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"wind_range": (8, 6)}, "an increasing range inside 3 to 25"),
        ({"wind_range": (1, 6)}, "an increasing range inside 3 to 25"),
        ({"speed_band": -0.1, "wind_range": (6, 8)}, "speed band -0.1"),
        ({"wind_step": 0.0}, "wind step 0.0"),
        ({"speed_band": 2}, "fits into the coefficient table"),
    ],
)
def test_misuse_is_explained(options: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        partial_load_model(nrel5mw(), **options)  # type: ignore[arg-type]


def test_an_estimate_outside_the_range_is_refused_unless_clipped() -> None:
    """The trim table ends with the wind range; clip=True holds its ends at run time."""
    where = {"rotor_speed": 1.2, "wind": 12.0, "wind_estimate": 12.0}

    with pytest.raises(ModelError, match="leaves the model's wind range"):
        model().premise_values(**where)
    assert np.all(np.isfinite(model().premise_values(**where, clip=True)))
