"""Regional models of every turbine of the library: exact, convex, with bounds that are tight."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import (
    Floats,
    Interval,
    ModelError,
    Premise,
    TSModel,
    Turbine,
    full_load_model,
    load_model,
    nrel5mw,
    partial_load_model,
)
from takagi.models.files.library import built_in_kinds
from takagi.models.turbine.data import rotor_torque, rotor_torque_gradient
from takagi.models.turbine.loader import load_turbine
from takagi.models.turbine.operating_band import (
    OperatingBand,
    Slope,
    operating_band,
    slope_enclosure,
    slope_gradient,
)

TURBINES = [name for name, kind in built_in_kinds().items() if kind == "turbine"]
REGIONS = ("partial load", "full load")
CASES = [(name, region) for name in TURBINES for region in REGIONS]
UNIT = st.floats(-1, 1)
# The default bands and tolerance of both models.
SPEED, WIND, PITCH = 0.1, 0.5, {"partial load": 0.0, "full load": 0.034907}


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
    assert TURBINES == ["iea15mw", "nrel5mw"]


@pytest.mark.parametrize(("name", "region"), CASES)
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


@pytest.mark.parametrize(("name", "region"), CASES)
def test_a_wrong_bound_is_refused(name: str, region: str) -> None:
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


SLOPES: tuple[Slope, ...] = ("speed", "pitch", "wind")
POINTS = st.tuples(st.floats(1.0, 1.3), st.floats(0.01, 0.35), st.floats(9.0, 22.0))


def at(point: tuple[float, float, float]) -> tuple[Interval, Interval, Interval]:
    omega, beta, v = (Interval.of(value) for value in point)
    return omega, beta, v


@lru_cache
def band() -> OperatingBand:
    return operating_band(
        nrel5mw(), (10.0, 13.0), speed_band="0.1", pitch_band="0.02", wind_band="0.5"
    )


@given(POINTS)
def test_slopes_at_a_point_agree_with_floats(point: tuple[float, float, float]) -> None:
    expected = [float(g) / nrel5mw().inertia for g in rotor_torque_gradient(nrel5mw(), *point)]

    for slope, value in zip(SLOPES, expected, strict=True):
        found = slope_enclosure(nrel5mw(), slope, *at(point))
        assert float(found.centre) == pytest.approx(value, rel=1e-7, abs=1e-10)
        assert float(found.width) < 1e-7


@given(POINTS, st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_an_enclosure_contains_what_lies_in_the_box(
    point: tuple[float, float, float], s: float, t: float, u: float
) -> None:
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
    points = [Interval.of(value) for value in place]
    for call in (slope_enclosure, slope_gradient):
        with pytest.raises(ModelError, match=words) as refused:
            call(nrel5mw(), "speed", points[0], points[1], points[2])
        assert f"winds of {place[2]:g} to {place[2]:g} m/s" in str(refused.value)
        assert "leave these winds out by cut_in and cut_out" in str(refused.value)
        assert "shrink the box" not in str(refused.value)


def test_a_wind_band_down_to_zero_is_refused() -> None:
    with pytest.raises(ModelError, match="reaches 0"):
        operating_band(nrel5mw(), (4, 6), speed_band=0.1, pitch_band=0, wind_band=4)
