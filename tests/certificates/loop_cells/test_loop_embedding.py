"""The nonlinear loop lies in its interval family, at random points."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.models import Interval, ModelError, Turbine
from takagi.models.laws.effort_sharing.law import (
    EffortSharingLaw,
    LoopBox,
    LoopCell,
    LoopUncertainty,
    loop_vertices,
)
from tests.certificates.loop_cells.loop_points import (
    BOX,
    FAST,
    ROUNDING,
    WIDE,
    Point,
    campaign,
    derivative,
    distance,
    effort_sharing_cells,
    ends,
    points,
    rates_of,
)


@pytest.mark.parametrize("count", [600, pytest.param(2000, marks=pytest.mark.slow)])
def test_the_loop_lies_in_its_family(
    turbine: Turbine, law: EffortSharingLaw, cells: list[LoopCell], count: int
) -> None:
    """Points of all cells, any inertia, wake and wind of the class: all inside."""
    drawn = points(law, BOX, count, seed=1)

    assert max(d for _, d in campaign(turbine, law, cells, drawn)) < ROUNDING


@pytest.mark.slow
def test_the_rate_limit_is_a_sector(turbine: Turbine, law: EffortSharingLaw) -> None:
    """With a lag box so large that the drive saturates the loop still lies in its family."""
    cells = effort_sharing_cells(turbine, law, FAST, WIDE, rates_of(law))
    found = campaign(turbine, law, cells, points(law, FAST, 500, seed=3))

    assert max(d for _, d in found) < ROUNDING
    assert min(cell.lag_rate.lower / cell.lag_rate.upper for cell in cells) < 0.4


SHRUNK = (
    "stiffness",
    "loop_gain",
    "lag_gain",
    "share_gain",
    "lag_rate",
    "wind_gain",
    "effectiveness_slope",
    "reference_slope",
)


@pytest.fixture(scope="module")
def sampled(
    turbine: Turbine, law: EffortSharingLaw
) -> list[tuple[Point, tuple[float, float, float]]]:
    """Return points with their derivatives, for tests that break the family."""
    return [(p, derivative(turbine, law, p)) for p in points(law, BOX, 3000, seed=4)]


@pytest.mark.slow
@pytest.mark.parametrize("name", SHRUNK)
def test_a_family_without_one_term_is_left(
    name: str,
    cells: list[LoopCell],
    sampled: list[tuple[Point, tuple[float, float, float]]],
) -> None:
    """Each coefficient is needed: pinned to its middle, or to zero, some point falls outside."""
    pinned = []
    for cell in cells:
        change: dict[str, Any] = {name: Fraction(0)}
        if isinstance(stated := getattr(cell, name), Interval):
            change[name] = Interval(stated.centre, stated.centre)
        pinned.append(replace(cell, **change))

    assert max(distance(pinned[p.k], p, rates) for p, rates in sampled) > 100 * ROUNDING


@pytest.mark.slow
@pytest.mark.parametrize(
    "smaller",
    [
        replace(WIDE, frozen_wake=False),
        replace(WIDE, inertia=Interval.of(1, 1)),
    ],
    ids=["equilibrium wake", "nominal inertia"],
)
def test_a_family_with_less_uncertainty_is_left(
    smaller: LoopUncertainty,
    turbine: Turbine,
    law: EffortSharingLaw,
    sampled: list[tuple[Point, tuple[float, float, float]]],
) -> None:
    """A frozen wake or another inertia is not inside the family that leaves it out."""
    narrow = effort_sharing_cells(turbine, law, BOX, smaller, rates_of(law))

    assert max(distance(narrow[p.k], p, rates) for p, rates in sampled) > 100 * ROUNDING


def test_corners_span_the_family(cells: list[LoopCell]) -> None:
    """Random coefficients give a loop that is a convex blend of the corners: weights by product."""
    rng = np.random.default_rng(5)
    names = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
    cell = next(
        c for c in cells if all(getattr(c, n).width > 0 for n in names) and c.lag_disturbance
    )
    corners, nu = loop_vertices(cell), float(cell.integral_rate.lower)
    rate = float(cell.wind_rate)
    steady = float(cell.inertia_gain * cell.residual) + float(cell.reference_slope) * rate
    turning = float(cell.effectiveness_slope) * rate
    for moving in (0.0, 1.0):
        for _ in range(20):
            shares = rng.uniform(size=5)
            a, g, s, f, t = (
                (ends(getattr(cell, n)) + wider * np.array([-1, 1])) @ [1 - t, t]
                for n, t, wider in zip(names, shares, [0, 0, 0, 0, moving * turning], strict=True)
            )
            expected = [[a - g, s, g], [f * (a - g + nu), f * s - t, f * g], [-nu, 0, 0]]
            weights = np.ones(1)
            for share in [*shares, 0.5] if moving else shares:
                weights = np.outer(weights, [1 - share, share]).ravel()
            found = corners.A if moving else corners.at_rest
            assert np.tensordot(weights, found, 1) == pytest.approx(np.array(expected))
            if moving:
                assert weights @ corners.fixed == pytest.approx([steady, f * steady, 0], abs=1e-12)
    signs = corners.fixed[:, 1] - corners.A[:, 1, 2] / corners.A[:, 0, 2] * steady
    assert np.abs(signs) == pytest.approx(float(cell.lag_disturbance))


@pytest.mark.parametrize(
    ("box", "words"),
    [
        (LoopBox(Fraction("0.045"), Fraction("0.015"), Fraction(2), Fraction("0.03")), "torque"),
        (LoopBox(Fraction("0.045"), Fraction(9), Fraction("0.04"), Fraction("0.03")), "pitch"),
        (LoopBox(Fraction(9), Fraction("0.015"), Fraction("0.04"), Fraction("0.03")), "box"),
    ],
)
def test_a_box_beyond_actuators_or_tables_is_misuse(
    box: LoopBox, words: str, turbine: Turbine, law: EffortSharingLaw
) -> None:
    """The message names the wind cell and what to reduce."""
    with pytest.raises(ModelError, match="wind cell") as raised:
        effort_sharing_cells(turbine, law, box, WIDE, rates_of(law))
    assert words in str(raised.value)
