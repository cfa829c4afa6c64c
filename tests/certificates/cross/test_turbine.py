"""The turbine's claim by the second checker: its ranges enclose the turbine, or it is not proved.

The numbers compared with are sampled plants on the spline of scipy, and the first checker.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from scipy.interpolate import BSpline

from takagi.certificates.audit.two_checkers import cross_checked_document
from takagi.certificates.cross_check.kernel.reading import loads
from takagi.certificates.cross_check.opinion import judge_document
from takagi.certificates.cross_check.turbine.numbers import TurbineNumbers
from takagi.certificates.cross_check.turbine.ranges import _ranges, _sizes
from takagi.certificates.document.certificate_file import dumps
from tests.certificates.kinds.test_damage import resealed

Data = dict[str, Any]
RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
SIZES = ("residual", "wind_gain", "inertia_gain", "effectiveness_slope", "reference_slope")


def number(value: fmpq) -> float:
    return int(value.p) / int(value.q)


@pytest.fixture
def turbine(short: Data) -> TurbineNumbers:
    read = loads(dumps(short))
    return TurbineNumbers(read["claims"][0], read["model"], read["gains"])


@pytest.fixture
def lowest(whole: Data) -> Data:
    """Return the certificate of the four cells at the lowest winds."""
    gains, claim = whole["gains"], whole["claims"][0]
    nodes = len(gains["wind"])
    for name, column in gains.items():
        if isinstance(column, list):
            gains[name] = column[: 5 - (nodes - len(column))]
    claim["cells"] = claim["cells"][:4]
    return dict(resealed(whole))


def knots_of(short: Data) -> tuple[list[float], list[float], list[list[float]]]:
    table = short["model"]["torque_surface"]
    return table["tip_speed_ratio_knots"], table["pitch_knots"], table["coefficients"]


def test_true_claim_is_proved(short: Data, lowest: Data) -> None:
    for document in (short, lowest):
        assert [one.verdict for one in judge_document(document)] == ["PROVED"]


@pytest.mark.slow
def test_all_wind_cells_are_proved(whole: Data) -> None:
    """All seventy, with 3782 matrices."""
    (one,) = judge_document(whole)
    assert (one.verdict, one.inequalities) == ("PROVED", 3782)


def test_stated_numbers_are_hardly_wider_than_the_ranges(
    short: Data, turbine: TurbineNumbers
) -> None:
    """Two units of the seventh decimal at most, so that a slip in an enclosure would show."""
    for k, cell in enumerate(short["claims"][0]["cells"]):
        for name, span in _ranges(turbine.cell(k)):
            low, high = cell[name]
            assert 0 <= number(span.low) - low < 2.1e-7, (k, name)
            assert 0 <= high - number(span.high) < 2.1e-7, (k, name)
        for name, size in _sizes(turbine.cell(k)):
            assert 0 <= cell[name] - number(size) < 2.1e-7, (k, name)


def test_sampled_turbines_lie_in_the_ranges(short: Data, turbine: TurbineNumbers) -> None:
    """Stiffness and wind gain by difference quotients of the torque at sampled points."""
    x_knots, y_knots, rows = knots_of(short)
    model, box = short["model"], short["claims"][0]["box"]
    J = model["rotor_inertia"] + model["gear_ratio"] ** 2 * model["generator_inertia"]
    surface = BSpline(np.array(x_knots), np.array(rows), 3)

    def torque(speed: float, pitch: float, wind: float) -> float:
        at = surface(speed * model["rotor_radius"] / wind)
        c = float(BSpline(np.array(y_knots), at, 3)(pitch))
        return float(model["torque_constant"] / J * wind**2 * c)

    rng, h = random.Random(5), 1e-5
    gains = short["gains"]
    for k, cell in enumerate(short["claims"][0]["cells"]):
        band = turbine.cell(k).band
        for _ in range(60):
            v = rng.uniform(*cell["wind"])
            speed = np.interp(v, gains["wind"], gains["rotor_speed"])
            speed += rng.uniform(-1, 1) * box["speed_error"]
            pitch = rng.uniform(number(band.low), number(band.high))
            a = (torque(speed + h, pitch, v) - torque(speed - h, pitch, v)) / (2 * h)
            for kappa in (1 / 1.1, 1 / 0.9):
                assert cell["stiffness"][0] - 1e-6 <= kappa * a <= cell["stiffness"][1] + 1e-6
            d = (torque(speed, pitch, v + h) - torque(speed, pitch, v - h)) / (2 * h)
            assert abs(d) <= cell["wind_gain"] + 1e-6


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("end", [0, 1])
def test_narrower_range_is_not_proved(short: Data, name: str, end: int) -> None:
    """One micro-unit inside; all matrices still hold, since the hull has become smaller."""
    for cell in short["claims"][0]["cells"]:
        low, high = cell[name]
        if high - low > 1e-5:
            cell[name][end] = round(cell[name][end] + (1e-6, -1e-6)[end], 7)
            break
    else:
        short["claims"][0]["cells"][1][name] = [5.1, 5.1]
    (one,) = judge_document(resealed(short))

    assert one.verdict == "UNDECIDED"
    assert f"range of {name} does not hold" in one.reason or name == "lag_rate"


@pytest.mark.parametrize("name", [*SIZES, "lag_disturbance"])
def test_smaller_size_is_not_proved(short: Data, lowest: Data, name: str) -> None:
    """One micro-unit less in the cell that shows most of it; the reference moves below rated."""
    document = lowest if name == "reference_slope" else short
    cell = max(document["claims"][0]["cells"], key=lambda cell: float(cell[name]))
    assert cell[name] > 1e-6, "no cell shows this size"
    cell[name] = round(cell[name] - 1e-6, 7)
    (one,) = judge_document(resealed(document))

    assert one.verdict == "UNDECIDED"
    assert f"size of {name} does not hold" in one.reason


def scaled(*path: Any, by: float) -> Callable[[Data], None]:
    """Return the damage that multiplies one number."""

    def damage(document: Data) -> None:
        owner: Any = document
        for key in path[:-1]:
            owner = owner[key]
        owner[path[-1]] = float(f"{owner[path[-1]] * by:.12g}")

    return damage


def pitch_ends_early(document: Data) -> None:
    document["model"]["pitch_max"] = document["gains"]["pitch_max"] = 0.01


def surface_rises(document: Data) -> None:
    """Two per cent more torque at all tip-speed ratios and pitch angles."""
    table = document["model"]["torque_surface"]
    table["coefficients"] = [[c * 1.02 for c in row] for row in table["coefficients"]]


def pitch_knots_move(document: Data) -> None:
    knots = document["model"]["torque_surface"]["pitch_knots"]
    places = [k for k, (a, b) in enumerate(pairwise(knots)) if 0 <= a < b < 0.1]
    for k in places:
        knots[k] += 0.002


def feeds_forward(document: Data) -> None:
    """The law feeds a rate forward where its reference speed stands still."""
    document["gains"]["inertia_feedforward"][0] = 0.1


DAMAGES: dict[str, Callable[[Data], None]] = {
    "torque": scaled("model", "torque_constant", by=1.01),
    "radius": scaled("model", "rotor_radius", by=1.001),
    "inertia": scaled("model", "rotor_inertia", by=0.99),
    "gear": scaled("model", "gear_ratio", by=1.01),
    "drive": scaled("model", "pitch_time_constant", by=1.5),
    "rate limit": scaled("model", "pitch_rate_limit", by=0.1),
    "largest pitch": pitch_ends_early,
    "surface": surface_rises,
    "knots": pitch_knots_move,
    "speed": scaled("gains", "rotor_speed", 2, by=1.01),
    "effort": scaled("gains", "trim_effort", 2, by=1.2),
    "effectiveness": scaled("gains", "effectiveness", 2, by=0.95),
    "frozen wake": scaled("gains", "effectiveness_limit", 3, by=3.0),
    "proportional": scaled("gains", "proportional", 2, by=1.02),
    "feed-forward": feeds_forward,
    "lead": scaled("gains", "pitch_lead", by=0.5),
    "ramp": scaled("gains", "overlap", by=1.3),
    "effort torque": scaled("gains", "effort_torque", by=0.98),
    "box, speed": scaled("claims", 0, "box", "speed_error", by=1.1),
    "box, lag": scaled("claims", 0, "box", "effort_lag", by=1.1),
    "box, signal": scaled("claims", 0, "box", "speed_signal", by=1.1),
    "box, wind": scaled("claims", 0, "box", "wind_share", by=1.5),
    "heavier": scaled("claims", 0, "uncertainty", "inertia", 1, by=1.02),
    "lighter": scaled("claims", 0, "uncertainty", "inertia", 0, by=0.98),
    "faster wind": scaled("claims", 0, "cells", 3, "wind_rate", by=3.0),
    "more wind": scaled("claims", 0, "cells", 3, "wind_error", by=3.0),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damaged_claim_is_not_proved(short: Data, name: str) -> None:
    """Turbine, law, box or wind class are others than those that the ranges are stated for."""
    DAMAGES[name](short)
    found = cross_checked_document(resealed(short))

    assert found.rows[0].second != "PROVED", name
    assert found.agrees, found.text


def test_tables_that_do_not_fit_are_refused(short: Data) -> None:
    short["gains"]["rotor_speed"].pop()

    assert cross_checked_document(resealed(short)).rows[0].second == "REFUSED"


def test_knots_that_do_not_increase_are_refused(short: Data) -> None:
    knots = short["model"]["torque_surface"]["pitch_knots"]
    knots[6] = knots[5]

    assert cross_checked_document(resealed(short)).rows[0].second == "REFUSED"


def test_surface_of_too_large_numbers_is_refused_by_both(short: Data) -> None:
    """Even where no cell looks at them."""
    short["model"]["torque_surface"]["coefficients"][0][0] = 1025.0
    (row,) = cross_checked_document(resealed(short)).rows

    assert (row.first, row.second) == ("REFUSED", "REFUSED")
