"""Ranges for a search: the exact ones up to rounding, and refused where those are refused."""

from __future__ import annotations

from dataclasses import fields
from fractions import Fraction

import numpy as np
import pytest

from takagi.models import Interval, ModelError, Turbine, nrel5mw
from takagi.models.laws import EffortGains, EffortSchedule, EffortSharingLaw
from takagi.models.loops.effort_sharing import CellLoop, LoopBox, LoopUncertainty
from takagi.models.splines.approximate_ranges import quick_ranges

BOX = LoopBox(Fraction("0.04"), Fraction("0.008"), Fraction("0.03"), Fraction("0.03"))
UNCERTAINTY = LoopUncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


def law(turbine: Turbine, gamma: float) -> EffortSharingLaw:
    """A law near rated wind, its tables rounded from those of the 5-MW design."""
    schedule = EffortSchedule(
        wind=np.array([11.6, 11.8, 12.0]),
        rotor_speed=np.array([1.26711, 1.26711, 1.26711]),
        trim_effort=np.array([0.0025, 0.0052, 0.0081]),
        effectiveness=np.array([0.18, 0.19, 0.2]),
        effectiveness_limit=np.array([0.3, 0.317, 0.334]),
        overlap=0.01,
    )
    gains = EffortGains(np.full(3, gamma), np.full(2, 0.09))
    return EffortSharingLaw.of(turbine, schedule, gains)


@pytest.mark.parametrize("order", [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)])
def test_the_range_is_the_exact_one_up_to_rounding(
    turbine: Turbine, order: tuple[int, int]
) -> None:
    """Across several knot cells, the same Bernstein hull."""
    x, y = Interval.of("6.2", "7.9"), Interval.of("0.01", "0.13")
    exact = turbine.torque.bounds(x, y, *order)
    found = quick_ranges(turbine.torque)(x, y, *order)
    size = float(exact.magnitude)
    assert abs(float(found.lower - exact.lower)) < 1e-11 * size
    assert abs(float(found.upper - exact.upper)) < 1e-11 * size


def test_outside_the_table_it_is_refused(turbine: Turbine) -> None:
    """On the edge is inside; a thousandth beyond it is not."""
    low, high = turbine.torque.x_range
    ranges, pitch = quick_ranges(turbine.torque), Interval.of("0.01", "0.02")
    assert ranges(Interval.of(high - 1, high), pitch, 0, 0).width > 0
    with pytest.raises(ModelError, match="leaves the coefficient table"):
        ranges(Interval.of(high - 1, high + 1e-3), pitch, 0, 0)


def test_a_searching_cell_is_the_exact_cell(turbine: Turbine) -> None:
    """Every range and size within one unit of the last emitted decimal; other gains differ."""

    def enclosed(gamma: float, *, searching: bool) -> dict[str, tuple[float, float]]:
        cell = CellLoop(turbine, law(turbine, gamma), BOX, UNCERTAINTY, 0, searching=searching)
        found = cell.enclosed("0.1")
        values = {field.name: getattr(found, field.name) for field in fields(found)}
        return {
            name: (float(v.lower), float(v.upper)) if isinstance(v, Interval) else (float(v),) * 2
            for name, v in values.items()
        }

    exact, quick, other = (
        enclosed(gamma, searching=fast) for gamma, fast in ((0.6, False), (0.6, True), (0.5, True))
    )
    for name, ends in exact.items():
        assert quick[name] == pytest.approx(ends, abs=1.1e-7), name
    assert other["share_gain"] != pytest.approx(exact["share_gain"], abs=1e-4)
    assert other["residual"] == exact["residual"]
