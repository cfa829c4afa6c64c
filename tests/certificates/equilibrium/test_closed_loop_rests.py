"""Rests of the turbine's loops: against the float studies, the law run by hand, and thresholds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from takagi.certificates import Verdict
from takagi.certificates.equilibrium import ClosedLoopEquilibria, closed_loop_equilibria
from takagi.models import ModelError
from takagi.models.laws import EffortSharingLaw, Measurement
from takagi.models.laws.published import PublishedLawName
from takagi.models.laws.published.equilibrium import equilibrium
from takagi.models.turbine import rotor_torque
from tests.certificates.conftest import Built, resealed
from tests.certificates.test_paper_certificate import TURBINE, make_law

ANSWERS = {"intended": "one at the trim", "shifted": "one off the trim", "none": "none"}
WIDTH = 0.02


def published_equilibria(
    name: PublishedLawName, placement: float, wind: float
) -> ClosedLoopEquilibria:
    winds = (wind, round(wind + WIDTH, 6))
    return closed_loop_equilibria(TURBINE, make_law(name, placement), winds=winds, narrowest=WIDTH)


def effort_sharing_equilibria(law: EffortSharingLaw, low: float, high: float) -> set[str]:
    found = closed_loop_equilibria(TURBINE, law, winds=(low, high), narrowest=0.05)
    return {cell.rests for cell in found.cells}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "placement", "wind"),
    [
        ("paper", 0.0, 8.0),
        ("paper", 0.0, 20.0),
        ("paper", 0.5, 10.9),
        ("paper", 0.5, 20.0),
        ("paper", 1.0, 11.3),
        ("paper", 1.0, 11.6),
        ("paper-two-integrators", 0.5, 8.0),
        ("paper-two-integrators", 0.5, 20.0),
        ("paper-two-integrators", 0.0, 10.2),
    ],
)
def test_the_float_study_finds_the_same(
    name: PublishedLawName, placement: float, wind: float
) -> None:
    """``models.laws.published.equilibrium`` looks for roots on a grid; the proof agrees with it."""
    study = equilibrium(make_law(name, placement), wind + WIDTH / 2)

    found = published_equilibria(name, placement, wind)

    assert [cell.rests for cell in found.cells] == [ANSWERS[study.kind]]
    assert found.check().verdict is Verdict.PROVED


def test_rated_wind_is_the_threshold_of_a_ramp_above_rated_speed() -> None:
    """Placement 1 gives no pitch at rated speed: at rest up to rated wind, 11.45 m/s, not above."""
    below, above = (published_equilibria("paper", 1.0, v).cells[0].rests for v in (11.40, 11.48))

    assert (below, above) == ("one at the trim", "none")


def test_a_continuum_is_at_rest_at_each_of_its_points() -> None:
    """Two integrators, f_1 = 1 at rated speed: three splits of torque and pitch, all at rest."""
    law, wind = make_law("paper-two-integrators", 0.0), 15.0
    assert published_equilibria("paper-two-integrators", 0.0, wind).cells[0].rests == "continuum"

    speed = law.reference_speed(wind)
    for torque in (30_000.0, 35_000.0, 40_000.0):
        needed = torque * TURBINE.gear_ratio

        def excess(pitch: float, needed: float = needed) -> float:
            return float(rotor_torque(TURBINE, speed, pitch, wind)) - needed

        pitch = brentq(excess, 0.1, 0.4, xtol=1e-14)
        measured = Measurement(speed, pitch, wind)
        b, c = (region.gains_at(*measured) for region in (law.partial, law.full))
        state = np.array([torque / b.integral, (1 + c.pitch) * pitch / c.integral])

        assert law.command(state, measured) == pytest.approx((torque, pitch), rel=1e-9)
        assert law.state_rate(state, measured) == pytest.approx([0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(("low", "high"), [(3.0, 4.0), (11.0, 12.0), (15.0, 16.0), (24.0, 25.0)])
def test_the_coherent_loop_rests_once(built: Built, low: float, high: float) -> None:
    """Lowest wind, the hand-over between torque and pitch, full load, cut-out."""
    assert effort_sharing_equilibria(built.law, low, high) == {"one"}


def test_a_stalled_rotor_is_the_coherent_loops_second_rest(built: Built) -> None:
    """At 18.5 m/s torque holds a slow rotor with the integrator at its limit: all rates are 0."""
    law, wind = built.law, 18.5
    assert effort_sharing_equilibria(law, 18.45, 18.55) == {"several"}

    def turning(speed: float) -> float:
        state = np.array([law.integral_limit, wind])
        pitch = 0.0
        for _ in range(3):
            torque, pitch = law.command(state, Measurement(speed, pitch, wind))
        return float(rotor_torque(TURBINE, speed, pitch, wind)) - TURBINE.gear_ratio * torque

    speed = brentq(turning, 0.62, 0.70)

    assert speed < 0.65 * TURBINE.rated_rotor_speed
    rate = law.state_rate(np.array([law.integral_limit, wind]), Measurement(speed, 0.0, wind))
    assert rate == pytest.approx([0.0, 0.0])


def test_a_wider_integrator_limit_removes_the_second_rest(built: Built) -> None:
    """With 0.6 rad/s in place of 0.1 the torque falls far enough to let the rotor go."""
    assert effort_sharing_equilibria(replace(built.law, integral_limit=0.6), 18.45, 18.55) == {
        "one"
    }


@pytest.mark.parametrize("stated", ["none", "several", "one off the trim", "continuum"])
def test_a_false_answer_is_not_proved(stated: str) -> None:
    """The cell says otherwise, and the verdict shows what was found."""
    found = published_equilibria("paper", 1.0, 8.0)
    document = found.document()
    document["claims"][0]["cells"][0]["rests"] = stated

    from takagi.certificates.checker import check_document

    checked = check_document(resealed(document))

    assert checked.verdict is Verdict.UNDECIDED
    assert "(one at the trim)" in checked.claims[0].text


def test_winds_that_no_cell_covers_are_named() -> None:
    """What is left out of the claim is said, and the ends are rounded inward."""
    text = published_equilibria("paper", 1.0, 8.0).check().claims[0].text

    assert "one at the trim at 8 to 8.02 m/s" in text
    assert "not decided: 3 to 8, 8.02 to 25 m/s" in text


def test_misuse_is_refused(built: Built) -> None:
    """Winds outside the law's, an empty range, a width of zero, another law."""
    for winds in ((2.0, 5.0), (24.0, 26.0), (9.0, 8.0)):
        with pytest.raises(ModelError, match="within 3 to 25 m/s is needed"):
            closed_loop_equilibria(TURBINE, built.law, winds=winds)
    with pytest.raises(ModelError, match="must be positive"):
        closed_loop_equilibria(TURBINE, built.law, narrowest=0.0)
    with pytest.raises(ModelError, match="an EffortSharingLaw or a PublishedLaw"):
        closed_loop_equilibria(TURBINE, "coherent")  # type: ignore[arg-type]
