"""Claims about Schulte's law: proved where they hold, refused or undecided where they do not."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine.published import (
    PublishedCandidate,
    PublishedSearch,
    merged,
    published_candidate,
    published_claim,
    with_overlaps,
)
from takagi.certificates.document.certificate_file import (
    published_law_data,
    turbine_data,
)
from takagi.models import ModelError, nrel5mw
from takagi.models.laws.published.law import (
    PublishedLaw,
    equilibrium,
    published_law,
)
from takagi.models.laws.published.regional_schedule import (
    RegionalSchedule,
    coupling_filter,
    regional_schedule,
)
from tests.certificates.kinds.claims import sealed
from tests.paper_models import loop_rate, regional_models

TURBINE = nrel5mw()
WINDOWS = ((6.0, 6.2), (13.0, 13.06), (20.0, 20.06))


@cache
def schedules() -> tuple[RegionalSchedule, RegionalSchedule]:
    return (
        regional_schedule(
            TURBINE,
            regional_models()[0],
            k_x=np.repeat([-75_500.0, -84_700.0], 2)[:, None],
            k_I=np.repeat([-9_900.0, -8_500.0], 2),
        ),
        regional_schedule(
            TURBINE,
            regional_models()[1],
            k_x=np.repeat([[-0.43, -0.52], [-0.32, -0.67], [-0.47, -0.55], [-0.41, -0.65]], 2, 0),
            k_I=np.repeat([-0.080, -0.079, -0.065, -0.083], 2),
        ),
    )


@cache
def make_law(placement: float = 0.5) -> PublishedLaw:
    partial, full = schedules()
    coupling = coupling_filter(TURBINE, placement=placement)
    return published_law(TURBINE, partial=partial, full=full, coupling=coupling)


@cache
def candidate() -> PublishedCandidate:
    return published_candidate(make_law(), winds=WINDOWS)


def test_what_no_enclosure_covers_is_refused() -> None:
    """The filter's other variant, and gains that depend on the premise d."""
    law, coupling = make_law(), coupling_filter(TURBINE, variant="sector")
    other = published_law(TURBINE, partial=law.partial, full=law.full, coupling=coupling)
    with pytest.raises(ModelError, match="saturated"):
        PublishedSearch.of(other)
    tilted = regional_schedule(
        TURBINE, law.partial.model, k_x=-8e4 - np.arange(4.0)[:, None], k_I=-9e3 * np.ones(4)
    )
    other = published_law(TURBINE, partial=tilted, full=law.full, coupling=law.coupling)
    with pytest.raises(ModelError, match="corners of d"):
        PublishedSearch.of(other)


def document(law: PublishedLaw, claim: dict[str, Any]) -> dict[str, Any]:
    return sealed(turbine_data(TURBINE, ()), published_law_data(law), claim)


@cache
def proved() -> Claim:
    found = candidate()
    return check_document(document(found.law, published_claim(found))).claims[0]


def test_candidates_are_proved() -> None:
    claim = proved()
    assert claim.verdict is Verdict.PROVED, claim.text
    assert "winds 6 to 6.2, 13 to 13.06, 20 to 20.06 m/s" in claim.text
    assert "speed overlap 0.1 rad/s, torque overlap 2000 N m" in claim.text
    assert "pitch not below its lower limit" in claim.text and "no lag of torque" in claim.text
    assert candidate().covered == list(WINDOWS)


def test_no_equilibrium_no_proof() -> None:
    """With f_1 = 0 at rated speed the shared integrator has no equilibrium above rated wind.

    Source: docs/laws.md, "How Schulte's law was read", placement 1.
    """
    law = make_law(placement=1.0)
    found = published_candidate(law, winds=[(15.0, 15.1)])
    assert not found.cells
    assert all("no equilibrium" in gap.reason for gap in found.unproved)
    claim = check_document(document(law, published_claim(found))).claims[0]
    assert claim.verdict is Verdict.UNDECIDED
    assert "proved at no wind" in claim.text


@pytest.mark.slow
def test_overlaps_move_the_ramp_with_its_placement() -> None:
    """Other overlaps keep the share of the ramp above rated speed."""
    law = make_law()
    moved = with_overlaps(law, speed_overlap=0.2, torque_overlap=1000.0)
    assert moved.coupling.speed_ramp.at(law.speed_setpoint) == pytest.approx(0.5)
    assert moved.coupling.torque_overlap == 1000.0
    first = published_candidate(moved, winds=[(20.0, 20.1)])
    stated = document(law, published_claim(first))
    claim = check_document(stated).claims[0]
    assert "speed overlap 0.2 rad/s, torque overlap 1000 N m" in claim.text
    assert "with these overlaps in place of its own" in claim.text
    assert claim.verdict is Verdict.PROVED


def test_ranges_that_touch_are_one() -> None:
    """Cells end where the next begins."""
    assert merged([(2.0, 3.0), (1.0, 2.0), (4.0, 5.0)]) == [(1.0, 3.0), (4.0, 5.0)]


def test_the_report_reads_every_number_of_the_checkers_words() -> None:
    """The page reads winds, rates and bounds in the claim's text; rewording would lose them."""
    from types import SimpleNamespace
    from typing import cast

    from takagi.certificates import TurbineDesign
    from takagi.reports.loops.plant_claims import overlap_claims

    found = candidate()
    whole = document(found.law, published_claim(found))
    design = SimpleNamespace(document=whole, checked=check_document(whole))

    (read,) = overlap_claims(cast(TurbineDesign, design))

    assert read.verdict is Verdict.PROVED
    assert read.proved == WINDOWS
    for number in (read.decay, read.speed_share, read.half_width):
        assert number


@pytest.mark.slow
def test_motions_from_the_boundary_stay_and_settle() -> None:
    """From V = 1 the real loop stays inside, and approaches its equilibrium at the stated rate."""
    law, rng = make_law(), np.random.default_rng(7)
    for found in candidate().cells:
        cell, P = found.cell, found.P
        v = float(rng.uniform(*cell.wind))
        share = (v - cell.wind[0]) / (cell.wind[1] - cell.wind[0])
        centre = cell.centre[0] + share * (cell.centre[1] - cell.centre[0])
        point = equilibrium(law, v)
        rest = np.array([point.rotor_speed, point.pitch, point.integral])

        def norm(z: Any, origin: Any, box: Any = cell.box, P: Any = P) -> float:
            y = (z - origin) / box
            return float(np.sqrt(y @ P @ y))

        y = rng.normal(size=len(centre))
        y[1] = abs(y[1])  # pitch never goes below its smallest
        start = centre + cell.box * y / np.sqrt(y @ P @ y)
        assert norm(rest, centre) < 1

        def motion(_: float, z: Any, v: float = v) -> Any:
            return loop_rate(law, v, z)

        found_path = solve_ivp(motion, (0, 20), start, rtol=1e-9, atol=1e-12, max_step=0.05)
        path = found_path.y.T
        assert max(norm(z, centre) for z in path) < 1 + 1e-6
        first = norm(start, rest)
        for t, z in zip(found_path.t, path, strict=True):
            assert norm(z, rest) <= first * np.exp(-found.decay_rate * t) * (1 + 1e-4) + 1e-5
