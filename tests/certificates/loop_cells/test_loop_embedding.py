"""The nonlinear loop lies in its interval family, also with another power coefficient."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict
from takagi.certificates.checker import check_document
from takagi.models import Interval, ModelError, Turbine
from takagi.models.laws.effort_sharing.law import (
    EffortSharingLaw,
    LoopBox,
    LoopCell,
    LoopUncertainty,
    loop_vertices,
)
from tests.certificates.kinds.claims import resealed
from tests.certificates.loop_cells.loop_points import (
    BOX,
    FAST,
    ROUNDING,
    WIDE,
    WIDER,
    WRONG,
    Point,
    campaign,
    derivative,
    distance,
    effort_sharing_cells,
    ends,
    points,
    rates_of,
)


@pytest.mark.parametrize("count", [250, pytest.param(2000, marks=pytest.mark.slow)])
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


@pytest.fixture(scope="module")
def wider(turbine: Turbine, law: EffortSharingLaw) -> list[LoopCell]:
    return effort_sharing_cells(turbine, law, BOX, WIDER, rates_of(law))


def test_the_loop_with_another_power_coefficient_lies_in_its_family(
    turbine: Turbine, law: EffortSharingLaw, wider: list[LoopCell]
) -> None:
    """A true c_P of 0.98 to 1.02 times the table's, with all that is uncertain beside it."""
    drawn = points(law, BOX, 250, seed=11, wrong=WRONG)

    assert max(d for _, d in campaign(turbine, law, wider, drawn)) < ROUNDING


@pytest.mark.parametrize(("power", "inside"), [(0.98, True), (1.02, True), (0.975, False)])
def test_a_rotor_outside_the_stated_power_coefficients_leaves_the_family(
    power: float, inside: bool, turbine: Turbine, law: EffortSharingLaw, wider: list[LoopCell]
) -> None:
    """At rest in the trim all there is to see is the torque that the table has wrong."""
    trims = [
        replace(p, e=0.0, zeta=0.0, x=0.0, wind=p.schedule_wind, schedule_rate=0.0, power=power)
        for p in points(law, BOX, 300, seed=13)
    ]
    away = [distance(wider[p.k], p, derivative(turbine, law, p)) for p in trims]
    assert (max(away) < ROUNDING) is inside


FAR_TOO_WIDE = {
    "stiffness": "leaves the stated range",
    "loop_gain": "leaves the stated range",
    "lag_gain": "leaves the stated range",
    "residual": "exceeds the stated bound",
    "wind_gain": "exceeds the stated bound",
}


LESS, MORE = [0.9, 1.0], [1.0, 1.1]


# A better coefficient moves no pitch further than the frozen wake does, a worse one no wind.
@pytest.mark.parametrize(
    ("name", "power"),
    [
        ("stiffness", LESS),
        ("stiffness", MORE),
        ("loop_gain", LESS),
        ("lag_gain", LESS),
        ("residual", LESS),
        ("residual", MORE),
        ("wind_gain", MORE),
    ],
)
def test_each_coefficient_needs_its_share(
    short: dict[str, Any], name: str, power: list[float]
) -> None:
    """All others are stated far too wide: what is left to fail is the one of the table alone."""
    claim = short["claims"][0]
    claim["uncertainty"]["power_coefficient"] = power
    for cell in claim["cells"]:
        for other in FAR_TOO_WIDE.keys() - {name}:
            ranged = isinstance(cell[other], list)
            cell[other] = [-1000.0, 1000.0] if ranged else 1000.0

    checked = check_document(resealed(short))

    assert checked.verdict is Verdict.UNDECIDED
    assert f"the loop's {name} {FAR_TOO_WIDE[name]}" in checked.claims[0].text


def test_the_residual_has_the_trim_torque_and_its_own_share(short: dict[str, Any]) -> None:
    """(1 + p) r + p T, where T is the larger demanded torque of both nodes over the inertia."""
    from fractions import Fraction

    from takagi.certificates.checker import read_text
    from takagi.certificates.checker.arithmetic.interval import ONE
    from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
    from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
    from takagi.certificates.document.certificate_file import dumps

    read = read_text(dumps(short), "certificate")
    subject = Subject.read(read["claims"][0], read["model"], read["gains"], "claim")
    plant, law = subject.plant, subject.law
    one, p = Fraction(1), Fraction(3, 100)
    for k in range(len(law.wind) - 1):
        alone = Loop(subject, k, Fraction(0)).residual((one, one))
        asked = []
        for q in law.effort[k : k + 2]:
            reserve = max(-q, Fraction(0))
            if abs(q) < law.overlap:
                reserve = (law.overlap - q) ** 2 / (4 * law.overlap)
            asked.append((law.rated_torque - law.effort_torque * reserve) * plant.gear_per_inertia)
        needed = (1 + p) * Fraction(alone, ONE) + p * max(asked)

        for power in ((1 - p, one), (one, 1 + p), (1 - p, 1 + p / 2)):
            assert abs(
                Fraction(Loop(subject, k, Fraction(0)).residual(power), ONE) - needed
            ) < Fraction(1, 10**20)
