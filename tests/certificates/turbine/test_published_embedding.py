"""Enclosures of the loop with the paper's laws: what the real loop does lies inside."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.published.loop import Loop
from takagi.certificates.claims.turbine.published import PublishedCell, PublishedSearch
from takagi.models import nrel5mw
from takagi.models.laws.published.law import (
    PublishedLaw,
    equilibrium,
    published_law,
)
from takagi.models.laws.published.regional_schedule import coupling_filter, regional_schedule
from tests.paper_models import loop_rate, regional_models

Floats = NDArray[np.float64]
TURBINE = nrel5mw()
# Winds in every region, beside the kinks of table and reference speed, and near rated wind.
WINDS = (3.3, 4.09, 6.0, 9.9, 10.7, 11.3, 11.44, 12.6, 17.1, 21.0, 24.9)
BOX = np.array([0.004, 0.006, 0.03])


@cache
def make_law(variant: str = "saturated") -> PublishedLaw:
    """Return a law with gains of realistic size that differ between the corners of a and b."""
    partial, full = regional_models()
    by_a = np.repeat([-1.0, 1.0], 2)
    by_ab = np.repeat([-1.0, -0.3, 0.4, 1.0], 2)
    return published_law(
        TURBINE,
        partial=regional_schedule(
            TURBINE, partial, k_x=-8e4 - 5e3 * by_a[:, None], k_I=-9.2e3 + 700 * by_a
        ),
        full=regional_schedule(
            TURBINE,
            full,
            k_x=np.column_stack([-0.4 + 0.05 * by_ab, -0.6 - 0.06 * by_ab]),
            k_I=-0.075 + 0.008 * by_ab,
        ),
        coupling=coupling_filter(TURBINE, variant=variant),  # type: ignore[arg-type]
    )


@cache
def search() -> PublishedSearch:
    """Return the search, whose ranges of the loop are the checker's; made once."""
    return PublishedSearch.of(make_law())


def centre_line(law: PublishedLaw, wind: tuple[float, float]) -> Floats:
    """Return the law's rest points, or the nearest to the trim without one, at both winds."""
    rows = []
    for v in wind:
        point = equilibrium(law, v)
        pair = [point.rotor_speed, point.pitch]
        if point.kind == "none":
            pair = [point.trim.rotor_speed, point.trim.pitch]
        rows.append([pair[0], max(pair[1], 0.0), point.integral])
    return np.array(rows)


@cache
def cell_at(wind: float, width: float, share: float) -> PublishedCell:
    """Return an enclosed cell, its box shrunk until the pitch rate limit is out of reach."""
    law = make_law()
    ends = (wind, min(wind + width, 25.0))
    centre = centre_line(law, ends)
    box = share * BOX
    while True:
        try:
            return search().enclosed(ends, centre, box, search().field_at(ends, centre))
        except Refused:
            box = box / 2


@settings(deadline=None, derandomize=True, max_examples=60)
@given(
    st.sampled_from(WINDS),
    st.sampled_from([0.02, 0.2]),
    st.sampled_from([1.0, 0.2]),
    st.integers(0, 10_000),
)
@pytest.mark.slow
def test_differences_of_the_real_loop_lie_in_the_family(
    wind: float, width: float, share: float, seed: int
) -> None:
    """f(z1) - f(z2) = A (z1 - z2) with A between the entrywise least and largest corner."""
    law, cell, rng = make_law(), cell_at(wind, width, share), np.random.default_rng(seed)
    low, high = cell.low.min(axis=0), cell.high.max(axis=0)
    for _ in range(4):
        t = rng.uniform()
        v = cell.wind[0] + t * (cell.wind[1] - cell.wind[0])
        middle = cell.centre[0] + t * (cell.centre[1] - cell.centre[0])
        first, last = (middle + cell.box * rng.uniform(-1, 1, len(middle)) for _ in range(2))
        if rng.uniform() < 0.5:
            # One coordinate at a time shows single entries.
            only = rng.integers(len(middle))
            last = np.where(np.arange(len(middle)) == only, last, first)
        first[1], last[1] = max(first[1], 0.0), max(last[1], 0.0)
        step = (last - first) / cell.box
        found = (loop_rate(law, v, last) - loop_rate(law, v, first)) / cell.box
        least = np.where(step > 0, low, high) @ step
        most = np.where(step > 0, high, low) @ step
        # The run-time law's difference quotients for premises are good to about 1e-8.
        slack = 2e-6 * (1 + np.abs(found)) / np.minimum(1, cell.box / 1e-3)
        assert np.all(least - slack <= found) and np.all(found <= most + slack)


@pytest.mark.parametrize("wind", WINDS)
def test_the_field_at_the_centre_is_within_its_bound(wind: float) -> None:
    """|f(z_0(v), v)| at random winds of a cell stays below the bound over the cell."""
    law, cell = make_law(), cell_at(wind, 0.1, 0.2)
    for t in np.linspace(0, 1, 9):
        v = cell.wind[0] + t * (cell.wind[1] - cell.wind[0])
        middle = cell.centre[0] + t * (cell.centre[1] - cell.centre[0])
        found = np.abs(loop_rate(law, float(v), middle)) / cell.box
        assert np.all(found <= cell.disturbance + 1e-6)


def test_the_torque_that_passes_is_that_of_the_coupling_filter() -> None:
    """Below, along and above the ramp; its ends are where the formulas meet."""
    coupling = make_law().coupling
    limit, overlap = coupling.rated_torque, coupling.torque_overlap
    loop = Loop.__new__(Loop)
    loop.law = SimpleNamespace(rated_torque=Fraction(limit))  # type: ignore[assignment]
    loop.overlaps = SimpleNamespace(torque=Fraction(overlap))  # type: ignore[assignment]
    for torque in limit + overlap * np.linspace(-1, 1, 41):
        bracket = loop._passed(int(Fraction(torque) * ONE))
        expected = coupling.factors_at(1.0, torque)[0] * torque
        assert bracket.low / ONE == pytest.approx(expected, abs=1e-6)
        assert bracket.low <= bracket.high <= bracket.low + 1e-6 * ONE
