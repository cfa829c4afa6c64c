"""The full-load model: exact over its band, eight rules, pitch with authority everywhere."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import ModelError, TSModel, full_load_model, nrel5mw
from takagi.models.turbine import OperatingBand, rated_wind, rotor_torque, rotor_torque_gradient
from takagi.models.turbine.operating_band import operating_band
from takagi.models.turbine.torque_secants import torque_symbols

UNIT = st.floats(-1, 1)
SHARES = st.tuples(UNIT, UNIT, UNIT, UNIT)
PITCH_BAND = 0.034907


@lru_cache
def model() -> TSModel:
    """Return the default model of the NREL 5-MW turbine."""
    return full_load_model(nrel5mw())


@lru_cache
def band() -> OperatingBand:
    """Return the tube that the default model is built on."""
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


@settings(max_examples=50, derandomize=True, deadline=None)
@given(SHARES, UNIT)
def test_blend_equals_the_plant(shares: tuple[float, float, float, float], command: float) -> None:
    """The blended derivative is the nonlinear plant's at any point of the band, to 1e-9."""
    turbine, here = nrel5mw(), point(shares)
    speed, pitch = (float(value) for value in band().at(here["wind_estimate"]))
    x = np.array([here["rotor_speed"] - speed, here["pitch"] - pitch, 0.1])
    now = model().blend(model().premise_values(**here))
    blended = now.A @ x + now.B @ [command] + now.E @ [here["wind"] - here["wind_estimate"]]

    balance = float(rotor_torque(turbine, speed, pitch, here["wind_estimate"]))
    aerodynamic = float(rotor_torque(turbine, here["rotor_speed"], here["pitch"], here["wind"]))
    scale = balance / turbine.inertia
    expected = (aerodynamic - balance) / turbine.inertia
    assert blended[0] == pytest.approx(expected, rel=1e-9, abs=1e-9 * scale)
    assert blended[1] == pytest.approx((command - x[1]) / turbine.pitch_time_constant, rel=1e-12)
    assert blended[2] == pytest.approx(-x[0], abs=1e-15)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(SHARES)
def test_memberships_are_a_convex_sum(shares: tuple[float, float, float, float]) -> None:
    """Eight weights, none negative, sum one, without clipping anywhere in the band."""
    h = model().memberships(model().premise_values(**point(shares)))

    assert h.shape == (8,)
    assert np.all(h >= 0)
    assert np.sum(h) == pytest.approx(1, abs=1e-14)


def test_bounds_contain_sampled_slopes_and_are_tight() -> None:
    """Sampled extrema of the partial derivatives lie inside, within 6 % of the range."""
    turbine, rng = nrel5mw(), np.random.default_rng(5)
    low, high = (float(end) for end in model().box["wind estimate [m/s]"])
    v0 = np.concatenate([rng.uniform(low, high, 40_000), np.repeat((low, high), 2_000)])
    omega, beta = band().at(v0)
    e, p, w = rng.choice([-1, -0.5, 0, 0.5, 1], (3, v0.size))
    off = np.maximum(beta + PITCH_BAND * p, turbine.pitch_min)
    wind = v0 + 0.5 * w
    slopes = (
        rotor_torque_gradient(turbine, omega + 0.1 * e, off, wind)[0],
        rotor_torque_gradient(turbine, omega, off, wind)[1],
        rotor_torque_gradient(turbine, omega, beta, wind)[2],
    )

    for premise, slope in zip(model().premises, slopes, strict=True):
        values = slope / turbine.inertia
        least, most = float(premise.lower), float(premise.upper)
        assert least <= values.min() <= least + 0.06 * (most - least)
        assert most - 0.06 * (most - least) <= values.max() <= most


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


def test_premises_are_vectorised() -> None:
    """Arrays of operating points give arrays of premises, equal to one point at a time."""
    points = [point((s, -s, s, 0.5 * s)) for s in (-0.9, 0.1, 0.8)]
    together = {name: np.array([p[name] for p in points]) for name in points[0]}

    values = model().premise_values(**together)  # type: ignore[arg-type]
    np.testing.assert_allclose(values.T, [model().premise_values(**p) for p in points], rtol=1e-12)


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


def test_derivation_is_latex_with_plain_words_escaped() -> None:
    """Underscores in the words are written out, those in formulas are not."""
    text = model().derivation_latex

    assert r"range of dT\_r/dbeta / J over the tube" in text
    assert r"T_{r}{\left(\omega^{*} + e,\beta^{*} + \delta_{\beta},v_{0} + w \right)}" in text
    assert text.count(r"\[") == text.count(r"\]") == len(model().derivation.steps)  # type: ignore[union-attr]
