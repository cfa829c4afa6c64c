"""The full-load model: exact over its band, eight rules, pitch with authority everywhere."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
import sympy as sp

from takagi.models import ModelError, TSModel, full_load_model, nrel5mw
from takagi.models.turbine.operating_band import OperatingBand, operating_band
from takagi.models.turbine.region_models import torque_symbols
from takagi.models.turbine.trim import rated_wind

PITCH_BAND = 0.034907


@lru_cache
def model() -> TSModel:
    return full_load_model(nrel5mw())


@lru_cache
def band() -> OperatingBand:
    low, high = (float(end) for end in model().box["wind estimate [m/s]"])
    return operating_band(
        nrel5mw(), (low, high), speed_band="0.1", pitch_band=PITCH_BAND, wind_band="0.5"
    )


def point(shares: tuple[float, float, float, float]) -> dict[str, float]:
    """Return an operating point for shares in [-1, 1] of the box, pitch not below its limit."""
    low, high = (float(end) for end in model().box["wind estimate [m/s]"])
    v0 = low + (high - low) * (shares[0] + 1) / 2
    speed, pitch = (float(value) for value in band().at(v0))
    return {
        "rotor_speed": speed + 0.1 * shares[1],
        "pitch": max(pitch + PITCH_BAND * shares[2], nrel5mw().pitch_min),
        "wind": v0 + 0.5 * shares[3],
        "wind_estimate": v0,
    }


def test_pitch_keeps_its_sign_over_the_default_range() -> None:
    """Proved: b < 0 everywhere in the band, because the range begins above rated wind."""
    b = model().premises[1]

    assert b.name == "b"
    assert float(b.upper) < -0.15
    assert float(model().box["wind estimate [m/s]"][0]) == pytest.approx(
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
    at_14 = model().premise_values(
        rotor_speed=float(band().at(14)[0]),
        pitch=float(band().at(14)[1]),
        wind=14,
        wind_estimate=14,
    )
    at_25 = model().premise_values(
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
    here = point((0.2, 0.0, 0.0, 0.0))
    speed = here["rotor_speed"]
    near, far = (
        model().premise_values(**(here | {"rotor_speed": speed + step})) for step in (9e-7, 1.1e-6)
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
            model().premise_values(**(where | {"rotor_speed": 1.25}), clip=True) * 3
        )
