"""The coefficients of wind cells: the checker's enclosures beside the certificate's own numbers.

The numbers of a certificate come from the models floor, by ball arithmetic and another derivation,
and are rounded outward to seven decimals.  The checker's must lie inside, and fill them.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.corners import BOUNDS, RANGES, Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop

# Two units of the last decimal, for two roundings of one.
STEP = Fraction(2, 10**7)
SHARES = (0, 8, 20, 30, 35, 38, 41, 44, 50, 65, 80, 99)
Inputs = tuple[Subject, list[Any]]


@pytest.fixture(scope="session")
def inputs(built: Any) -> Inputs:
    """Return what the checker reads of the whole certificate, and its cells."""
    read = read_text(json.dumps(built.document), "document")
    claim = read["claims"][0]
    return Subject.read(claim, read["model"], read["gains"], "claim"), claim["cells"]


def outside(loop: Loop, ranges: Any, sizes: dict[str, Fraction]) -> str:
    """Return which coefficient is not as it is stated."""
    return first_failure(loop.enclosed(Stated(ranges, sizes, "cell")))


@pytest.mark.parametrize("share", SHARES)
def test_what_a_cell_states_is_enclosed_and_no_more(inputs: Inputs, share: int) -> None:
    """From cut-in to cut-out, more closely around rated wind: every range and every size."""
    subject, cells = inputs
    k = share * (len(cells) - 1) // 99
    cell = cells[k]
    loop = Loop(subject, k, Fraction(cell["wind_rate"]))
    ranges = {name: [Fraction(end) for end in cell[name]] for name in RANGES}
    sizes = {name: Fraction(cell[name]) for name in BOUNDS}

    assert outside(loop, ranges, sizes) == ""
    assert first_failure(loop.limits()) == ""

    found = {name: [Fraction(end, ONE) for end in bracket] for name, bracket in loop.ranges()}
    largest = dict(loop.sizes())
    assert found.keys() == set(RANGES)
    assert largest.keys() == set(BOUNDS)
    for name, (low, high) in found.items():
        assert low - STEP <= ranges[name][0] <= low, name
        assert high <= ranges[name][1] <= high + STEP, name
    # The residual is bounded in two ways: over a whole cell here, over pieces of it there.
    residual = largest.pop("residual")
    assert residual <= sizes["residual"] <= 2 * residual
    for name, size in largest.items():
        assert size <= sizes[name] <= size + STEP, name


@pytest.mark.parametrize("name", (*RANGES, *BOUNDS))
def test_each_stated_number_is_compared(inputs: Inputs, name: str) -> None:
    """One that is too small by two units of the last decimal is named, at either end."""
    subject, cells = inputs
    k = next(k for k, cell in enumerate(cells) if Fraction(cell["reference_slope"]) > 0)
    cell = cells[k]
    loop = Loop(subject, k, Fraction(cell["wind_rate"]))
    ranges = {one: [Fraction(end) for end in cell[one]] for one in RANGES}
    sizes = {one: Fraction(cell[one]) for one in BOUNDS}

    if name in RANGES:
        low, high = ranges[name]
        assert f"loop's {name} leaves" in outside(loop, ranges | {name: [low + STEP, high]}, sizes)
        assert f"loop's {name} leaves" in outside(loop, ranges | {name: [low, high - STEP]}, sizes)
        assert outside(loop, ranges | {name: [low - STEP, high + STEP]}, sizes) == ""
    else:
        less = sizes[name] / 2 if name == "residual" else sizes[name] - STEP
        assert f"loop's {name} exceeds" in outside(loop, ranges, sizes | {name: less})
        assert outside(loop, ranges, sizes | {name: sizes[name] + STEP}) == ""
