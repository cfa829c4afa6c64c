"""What a claim about the effort-sharing loop may not speak of: numbers on both sides of a limit."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import (
    Box,
    Law,
    Settling,
    Uncertainty,
)
from takagi.certificates.checker.turbine.rotor import Plant

KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
MODEL: dict[str, Any] = {
    "kind": "turbine",
    "gear_ratio": 10,
    "torque_constant": 40,
    "rotor_radius": 5,
    "pitch_time_constant": 0.5,
    "pitch_rate_limit": 0.25,
    "rated_rotor_speed": 2,
    "rotor_inertia": 100,
    "generator_inertia": 3,
    "pitch_min": -0.125,
    "pitch_max": 1.5,
    "torque_surface": {
        "tip_speed_ratio_knots": KNOTS,
        "pitch_knots": KNOTS,
        "coefficients": [[1] * 4] * 4,
    },
}
GAINS: dict[str, Any] = {
    "name": "coherent",
    "wind": [4, 6, 9],
    "rotor_speed": [1, 2, 3],
    "trim_effort": [-1, 0, 1],
    "effectiveness": [3, 4, 5],
    "effectiveness_limit": [6, 7, 8],
    "proportional": [0.5, 0.25, 0.75],
    "integral_rate": [0.1, 0.2],
    "overlap": 0.5,
    "rated_torque": 43,
    "effort_torque": 12,
    "pitch_min": -0.125,
    "pitch_max": 1.5,
    "integral_limit": 2,
    "wind_filter": 5,
}
CLAIM: dict[str, Any] = {
    "box": {"speed_error": 1, "effort_lag": 2, "speed_signal": 3, "wind_share": 0.5},
    "uncertainty": {
        "inertia": [0.8, 1.25],
        "frozen_wake": True,
        "power_coefficient": [0.75, 1.5],
    },
    "settling": {"P": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "decay_rate": 0},
}


def as_read(data: dict[str, Any], **changes: Any) -> Any:
    return read_text(json.dumps(data | changes), "test")


def part(name: str, **changes: Any) -> Any:
    return as_read(CLAIM, **{name: CLAIM[name] | changes})


def exact(*values: float) -> tuple[Fraction, ...]:
    return tuple(Fraction(value) for value in values)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("kind", "paper"),
        *(
            (name, value)
            for name in ("gear_ratio", "torque_constant", "rotor_radius", "pitch_time_constant")
            for value in (0, -1)
        ),
        *(("pitch_rate_limit", value) for value in (0, -0.25)),
        *(("rated_rotor_speed", value) for value in (0, -2)),
        *(("rotor_inertia", value) for value in (-300, -301)),
        ("pitch_max", -0.126),
    ],
)
def test_a_plant_is_refused(name: str, value: Any) -> None:
    with pytest.raises(CertificateError):
        Plant.read(as_read(MODEL, **{name: value}))


def test_an_inertia_that_is_all_the_generators_is_one() -> None:
    """The sum decides, not its parts."""
    assert Plant.read(as_read(MODEL, rotor_inertia=-299)).gear_per_inertia == 10
    assert Plant.read(as_read(MODEL, rotor_inertia=1, generator_inertia=0)).gear_per_inertia == 10


POSITIVE = ("overlap", "rated_torque", "effort_torque", "integral_limit")
POSITIVE_ROWS = ("rotor_speed", "effectiveness", "proportional", "integral_rate")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, value) for name in POSITIVE for value in (0, -1)),
        *((name, [*GAINS[name][:-1], value]) for name in POSITIVE_ROWS for value in (0, -1)),
        *((name, [0, *GAINS[name][1:]]) for name in POSITIVE_ROWS),
        ("wind", [0, 6, 9]),
        ("wind", [-1, 6, 9]),
        ("wind", [4, 4, 9]),
        ("wind", [4, 9, 6]),
        *((name, GAINS[name][:-1]) for name, row in GAINS.items() if isinstance(row, list)),
        *((name, [*row, 9]) for name, row in GAINS.items() if isinstance(row, list)),
    ],
)
def test_a_law_is_refused(name: str, value: Any) -> None:
    with pytest.raises(CertificateError):
        Law.read(as_read(GAINS, **{name: value}))


def table(count: int) -> Any:
    rows = {n: [v[0]] * count for n, v in GAINS.items() if isinstance(v, list)}
    short = {n: rows[n][:-1] for n in rows if len(GAINS[n]) == 2}
    return as_read(GAINS, **(rows | short | {"wind": [k + 1 for k in range(count)]}))


def test_there_are_two_to_two_thousand_winds() -> None:
    for count in (2, 2000):
        assert len(Law.read(table(count)).wind) == count
    for count in (1, 2001):
        with pytest.raises(CertificateError):
            Law.read(table(count))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, value) for name in CLAIM["box"] for value in (0, -0.5)),
        *(("wind_share", value) for value in (1, 1.5)),
    ],
)
def test_a_box_is_refused(name: str, value: float) -> None:
    with pytest.raises(CertificateError, match="box"):
        Box.read(part("box", **{name: value}), "claim")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("inertia", value) for value in ([0, 1], [-1, 1], [1.1, 1.0], [1], [1, 1, 1])),
        *(("frozen_wake", value) for value in (1, 0, "yes", None)),
        *(
            ("power_coefficient", value)
            for value in ([0, 1], [-1, 1], [1.1, 0.9], [1.01, 1.1], [0.9, 0.99], [1], [1, 1, 1])
        ),
    ],
)
def test_an_uncertainty_is_refused(name: str, value: Any) -> None:
    with pytest.raises(CertificateError, match="uncertainty"):
        Uncertainty.read(part("uncertainty", **{name: value}), "claim")


def test_ends_that_are_allowed() -> None:
    """Pitch held at one angle, limits of zero, nearly all of the wind, intervals of one number."""
    assert Plant.read(as_read(MODEL, pitch_max=-0.125)).pitch_max == Fraction(-1, 8)
    assert Box.read(part("box", wind_share=0.999), "claim").wind_share < 1
    found = Uncertainty.read(
        part("uncertainty", inertia=[0.5, 0.5], power_coefficient=[1, 1], frozen_wake=False),
        "claim",
    )
    assert found.inertia == exact(0.5, 0.5) and found.kappa == exact(2, 2)
    assert found.power == exact(1, 1) and found.frozen_wake is False


def test_without_a_power_coefficient_it_is_the_tables() -> None:
    stated = {n: v for n, v in CLAIM["uncertainty"].items() if n != "power_coefficient"}

    found = Uncertainty.read(as_read(CLAIM, uncertainty=stated), "claim")

    assert found.power == exact(1, 1)


@pytest.mark.parametrize(
    "changes",
    [
        {"P": [[1, 0], [0, 1]]},
        {"P": [[1, 0, 0], [0, 1, 0]]},
        {"P": [[1, 0], [0, 1], [0, 0]]},
        {"P": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]},
        {"P": [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]]},
        {"decay_rate": -0.001},
    ],
)
def test_settling_is_refused(changes: Any) -> None:
    with pytest.raises(CertificateError, match="settling"):
        Settling.read(part("settling", **changes), "claim")
