"""Regional models of every turbine of the library: exact, convex, with bounds that are tight."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.models import (
    ModelError,
    Premise,
    TSModel,
    Turbine,
    full_load_model,
    load_model,
    partial_load_model,
)
from takagi.models.files.library import built_in_kinds
from takagi.models.turbine.data import rotor_torque, rotor_torque_gradient
from takagi.models.turbine.loader import load_turbine
from takagi.models.turbine.operating_band import OperatingBand, operating_band, slope_range

Floats = NDArray[np.float64]

TURBINES = [name for name, kind in built_in_kinds().items() if kind == "turbine"]
REGIONS = ("partial load", "full load")
CASES = [(name, region) for name in TURBINES for region in REGIONS]
UNIT = st.floats(-1, 1)
# The default bands and tolerance of both models.
SPEED, WIND, PITCH = 0.1, 0.5, {"partial load": 0.0, "full load": 0.034907}
TOLERANCE = Fraction("0.02")


@dataclass(frozen=True)
class Case:
    turbine: Turbine
    model: TSModel
    band: OperatingBand
    pitch_band: float

    def points(self, shares: Floats) -> dict[str, Floats]:
        """Return operating points for columns of shares in [-1, 1] of v_0, speed, pitch, wind."""
        low, high = (float(end) for end in self.model.box["wind estimate [m/s]"])
        v0 = low + (high - low) * (shares[0] + 1) / 2
        speed, pitch = self.band.at(v0)
        return {
            "rotor_speed": speed + SPEED * shares[1],
            "pitch": np.maximum(pitch + self.pitch_band * shares[2], self.turbine.pitch_min),
            "wind": v0 + WIND * shares[3],
            "wind_estimate": v0,
        }


@lru_cache
def case(name: str, region: str) -> Case:
    turbine = load_model(name)
    assert isinstance(turbine, Turbine)
    make = partial_load_model if region == "partial load" else full_load_model
    model = make(turbine)
    low, high = (float(end) for end in model.box["wind estimate [m/s]"])
    band = operating_band(
        turbine, (low, high), speed_band="0.1", pitch_band=str(PITCH[region]), wind_band="0.5"
    )
    return Case(turbine, model, band, PITCH[region])


def test_every_turbine_of_the_library_is_tested_here() -> None:
    """The NREL 5-MW and the IEA 15-MW reference turbines."""
    assert TURBINES == ["iea15mw", "nrel5mw"]


@pytest.mark.parametrize(("name", "region"), CASES)
@settings(max_examples=25, derandomize=True, deadline=None)
@given(shares=st.tuples(UNIT, UNIT, UNIT, UNIT))
def test_the_model_equals_the_plant(
    name: str, region: str, shares: tuple[float, float, float, float]
) -> None:
    """J omega' = T_r - n_g T - (the same at the trim), to 1e-9; weights are convex."""
    found = case(name, region)
    turbine, here = found.turbine, found.points(np.array(shares))
    point = {key: float(value) for key, value in here.items()}
    v0 = point["wind_estimate"]
    speed, pitch = (float(value) for value in found.band.at(v0))
    values = found.model.premise_values(**point)
    h = found.model.memberships(values)
    now = found.model.blend(values)
    x = np.zeros(len(found.model.states))
    x[0] = point["rotor_speed"] - speed
    if region == "full load":
        x[1] = point["pitch"] - pitch
    blended = float((now.A @ x + now.E @ [point["wind"] - v0])[0])

    balance = float(rotor_torque(turbine, speed, pitch, v0))
    torque = float(rotor_torque(turbine, point["rotor_speed"], point["pitch"], point["wind"]))
    size = 1e-9 * balance / turbine.inertia
    assert blended == pytest.approx((torque - balance) / turbine.inertia, rel=1e-9, abs=size)
    assert np.all(h >= 0)
    assert h.sum() == pytest.approx(1, abs=1e-12)


@lru_cache
def sampled(name: str, region: str) -> list[Floats]:
    """Return each premise's slope, per inertia, at many points of its part of the tube."""
    found = case(name, region)
    chance = np.random.default_rng(7)
    shares = chance.choice([-1, -0.5, 0, 0.5, 1], (4, 40_000)).astype(float)
    shares[0, 4_000:] = chance.uniform(-1, 1, 36_000)
    off = found.points(shares)
    on_speed, on_pitch = found.band.at(off["wind_estimate"])
    parts = {"a": (off["rotor_speed"], off["pitch"], 0), "b": (on_speed, off["pitch"], 1)}
    parts["d"] = (on_speed, on_pitch, 2)
    return [
        rotor_torque_gradient(found.turbine, speed, pitch, off["wind"])[index]
        / found.turbine.inertia
        for speed, pitch, index in (parts[premise.name] for premise in found.model.premises)
    ]


@pytest.mark.parametrize(("name", "region"), CASES)
def test_bounds_hold_all_samples_and_little_more(name: str, region: str) -> None:
    """Sampled extrema inside, and within 8 % of the range; the search stops at 2 %."""
    found = case(name, region)

    for premise, values in zip(found.model.premises, sampled(name, region), strict=True):
        low, high = float(premise.lower), float(premise.upper)
        assert low <= values.min() <= low + 0.08 * (high - low)
        assert high - 0.08 * (high - low) <= values.max() <= high


@pytest.mark.slow
@pytest.mark.parametrize(("name", "region"), CASES)
def test_bounds_exceed_attained_values_by_the_stated_share(name: str, region: str) -> None:
    """The wind premise again: each end within its tolerance of a value that is attained."""
    found = case(name, region)
    again = slope_range(found.band, "wind", off_trim=("wind",), tolerance=TOLERANCE)
    premise = found.model.premises[-1]

    assert premise.name == "d"
    slack = TOLERANCE * again.outer.width + Fraction(1, 10**6)
    assert premise.lower <= again.inner.lower <= premise.lower + slack
    assert premise.upper - slack <= again.inner.upper <= premise.upper


@pytest.mark.parametrize(("name", "region"), CASES)
def test_a_wrong_bound_is_refused(name: str, region: str) -> None:
    """A tenth of each range cut off, at either end: a point of the tube is outside, and told."""
    found = case(name, region)

    for premise, values in zip(found.model.premises, sampled(name, region), strict=True):
        part = premise.bounds.width / 10
        for low, high, value in (
            (premise.lower, premise.upper - part, values.max()),
            (premise.lower + part, premise.upper, values.min()),
        ):
            planted = Premise(premise.name, low, high, unit=premise.unit)
            with pytest.raises(ModelError, match=f"premise {premise.name} = .* outside its range"):
                planted.weights(value)


def test_a_smallest_pitch_that_is_no_short_decimal() -> None:
    """1 deg = 0.01745... rad: the partial-load model stays at that angle, to the last digit."""
    turbine = replace(load_turbine("nrel5mw"), pitch_min=float(np.radians(1)))
    model = partial_load_model(turbine, wind_range=(8, 9))
    band = operating_band(turbine, (8, 9), speed_band="0.1", pitch_band=0, wind_band="0.5")

    assert len(model.rules) == 4
    assert set(band.pitch) == {turbine.pitch_min}
