"""The models of partial and full load: exact over their bands, within bounds that samples keep."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest
import sympy as sp

from takagi.models import ModelError, TSModel, full_load_model, nrel5mw, partial_load_model
from takagi.models.turbine.operating_band import OperatingBand, operating_band
from takagi.models.turbine.region_models import lowest_wind, torque_symbols
from takagi.models.turbine.trim import rated_wind

PITCH_BAND = 0.034907


@lru_cache
def full_load() -> TSModel:
    return full_load_model(nrel5mw())


@lru_cache
def band() -> OperatingBand:
    low, high = (float(end) for end in full_load().box["wind estimate [m/s]"])
    return operating_band(
        nrel5mw(), (low, high), speed_band="0.1", pitch_band=PITCH_BAND, wind_band="0.5"
    )


def test_pitch_keeps_its_sign_over_the_default_range() -> None:
    """Proved: b < 0 everywhere in the band, because the range begins above rated wind."""
    b = full_load().premises[1]

    assert b.name == "b"
    assert float(b.upper) < -0.15
    assert float(full_load().box["wind estimate [m/s]"][0]) == pytest.approx(
        rated_wind(nrel5mw()) + 0.5
    )


@pytest.mark.slow
def test_the_band_must_not_begin_at_rated_wind() -> None:
    """From rated wind on, with 1 m/s of wind band, b reaches positive values: no PDC there."""
    early = full_load_model(nrel5mw(), wind_range=(11.46, 13), wind_band=1)

    assert early.premises[1].upper > 0


def test_sensitivities_of_the_figure_sheet_lie_within_the_bounds() -> None:
    """c_P table at the trims, per inertia: v = 14: b = -0.69, d = 0.023; v = 25: a = -0.53,
    b = -1.89, d = 0.034 (quasi-steady surface of the NREL 5-MW reference turbine)."""
    at_14 = full_load().premise_values(
        rotor_speed=float(band().at(14)[0]),
        pitch=float(band().at(14)[1]),
        wind=14,
        wind_estimate=14,
    )
    at_25 = full_load().premise_values(
        rotor_speed=float(band().at(25)[0]),
        pitch=float(band().at(25)[1]),
        wind=25,
        wind_estimate=25,
    )

    np.testing.assert_allclose(at_14, (-0.10, -0.69, 0.023), atol=5e-3)
    np.testing.assert_allclose(at_25, (-0.53, -1.89, 0.034), atol=5e-3)


def test_telescope_is_an_identity_and_a_wrong_one_is_not() -> None:
    """J (a e + b delta + d w) - (T_r - T_r*) cancels symbolically; with a doubled it does not."""
    torque = torque_symbols(with_pitch=True)
    steps = (torque.speed_error, torque.pitch_deviation, torque.wind_deviation)
    total = torque.inertia * sum(
        secant * step for secant, step in zip(torque.secants.values(), steps, strict=True)
    )
    doubled = total + torque.inertia * torque.secants[torque.secant("a")] * steps[0]

    assert sp.simplify(total - (torque.point - torque.trim)) == 0
    assert sp.simplify(doubled - (torque.point - torque.trim)) != 0


def test_a_secant_meets_its_derivative_continuously() -> None:
    """Across the switch from difference quotient to derivative premises move by less than 1e-7."""
    low, high = (float(end) for end in full_load().box["wind estimate [m/s]"])
    wind = low + 0.6 * (high - low)
    speed, pitch = (float(value) for value in band().at(wind))
    here = {"pitch": pitch, "wind": wind, "wind_estimate": wind}
    near, far = (
        full_load().premise_values(**(here | {"rotor_speed": speed + step}))
        for step in (9e-7, 1.1e-6)
    )

    np.testing.assert_allclose(near, far, rtol=1e-7)


def test_a_derated_set_point_moves_the_reference() -> None:
    """With a set-point of 1.1 rad/s the trim table runs at 1.1 rad/s."""
    derated = full_load_model(
        nrel5mw(), wind_range=(15, 16), speed_setpoint=1.1, speed_band="0.05", tolerance="0.2"
    )

    where = {"rotor_speed": 1.1, "pitch": 0.2, "wind": 15.0, "wind_estimate": 15.0}
    assert np.all(np.isfinite(derated.premise_values(**where)))
    with pytest.raises(ModelError, match="outside its range"):
        derated.memberships(
            full_load().premise_values(**(where | {"rotor_speed": 1.25}), clip=True) * 3
        )


@lru_cache
def partial_load() -> TSModel:
    return partial_load_model(nrel5mw())


def side(name: str) -> tuple[float, float]:
    lower, upper = partial_load().box[name]
    return float(lower), float(upper)


def test_structure_names_and_units() -> None:
    """B holds -n_g / J of the figure sheet: 97 / 43 784 725 kg m^2; the integral has slope -1."""
    found = partial_load()

    assert found.states == ("rotor speed error [rad/s]", "integral of speed deficit [rad]")
    assert found.inputs == ("generator torque deviation [N m]",)
    assert found.disturbances == ("wind deviation [m/s]",)
    np.testing.assert_allclose(found.B[:, 0, 0], -97 / 43_784_725, rtol=1e-7)
    np.testing.assert_array_equal(found.A[:, 1], [[-1, 0]] * 4)
    assert [premise.name for premise in found.premises] == ["a", "d"]


def test_vertices_are_the_decimals_of_the_bounds() -> None:
    """Each vertex entry prints as the exact bound, so a certificate can speak of the decimals."""
    a, d = partial_load().premises
    corners = {
        (Fraction(repr(float(A[0, 0]))), Fraction(repr(float(E[0, 0]))))
        for A, E in zip(partial_load().A, partial_load().E, strict=True)
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
        partial_load().premise_values(**where)
    assert np.all(np.isfinite(partial_load().premise_values(**where, clip=True)))
