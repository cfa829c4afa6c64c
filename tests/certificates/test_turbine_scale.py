"""Design settings in a turbine's own scale."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from takagi.certificates import DesignSettings
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine import (
    DEFAULT_BOX,
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.design.turbine import default_settings, scale
from takagi.certificates.design.turbine.regions import regional_design
from takagi.certificates.document import certificate_document, effort_sharing_law_data, turbine_data
from takagi.certificates.document.provenance import provenance
from takagi.lmi.turbine import FULL_LOAD, PARTIAL_LOAD, EffortSettings, effort_gains
from takagi.models import ModelError, nrel5mw
from takagi.models.laws import EffortSharingLaw, effort_schedule
from takagi.models.turbine import load_turbine, model_files, reference_speed
from takagi.models.turbine.trim import TABLE_SHARE


def test_the_reference_keeps_its_settings() -> None:
    """On the NREL 5-MW turbine every ratio is 1, to the last digit."""
    turbine = nrel5mw()

    assert default_settings(turbine) == replace(DesignSettings(), effort=EffortSettings())
    assert scale.scaled_box(turbine) == DEFAULT_BOX
    assert scale.region_requirements(turbine) == (PARTIAL_LOAD, FULL_LOAD)


def test_a_larger_rotor_gets_smaller_bands() -> None:
    """15 MW: speeds by 0.62, effort by 0.66, lag by 0.24."""
    found = default_settings(load_turbine("iea15mw"))

    assert found.box.speed_error == Fraction("0.024")
    assert found.box.speed_signal == Fraction("0.018")
    assert found.box.effort_lag == Fraction("0.0019")
    assert found.effort == EffortSettings(
        bandwidth=0.21, bandwidth_growth=1.9, partial_bandwidth=0.2, speed_error=0.018
    )
    assert found.effectiveness_share == 0.8
    assert found.overlap == 0.0066
    assert found.speed_overlap == 0.062
    assert found.torque_overlap == 920000.0
    # Slow beside wake and tower, which are twice as slow: 1.1 in place of 2.0 rad/s.
    assert found.wind_filter == 23.0
    assert found.speed_filter == 5.0
    assert default_settings(nrel5mw()).wind_filter == 12.0
    assert found.torsion_filter == 0.0  # its file states no torsion mode
    five = default_settings(nrel5mw())
    assert (five.speed_filter, five.torsion_filter) == (30.0, 9.3)


@pytest.mark.parametrize("name", ["nrel5mw", "iea15mw"])
def test_the_band_stays_inside_the_table_at_cut_in(name: str) -> None:
    """(omega* + e) R / ((1 - share) v) is within the tip-speed ratios; a quarter more is not."""
    turbine = load_turbine(name)
    box, v = scale.scaled_box(turbine), turbine.cut_in
    speed, largest = reference_speed(turbine, v), turbine.torque.x_range[1]
    assert speed * turbine.rotor_radius / v == pytest.approx(TABLE_SHARE * largest)

    def ratio(error: float) -> float:
        return (speed + error) * turbine.rotor_radius / (v * (1 - float(box.wind_share)))

    assert ratio(float(box.speed_error)) <= largest < ratio(1.25 * float(box.speed_error))


@pytest.mark.parametrize("scale", [0.5, 0.8, 2.0])
def test_a_turbine_in_other_units_of_length_and_time(scale: float) -> None:
    """Speed and effort scale with their measures: rated speed s times, torque s^2 times."""
    turbine = nrel5mw()
    changed = replace(
        turbine,
        rated_rotor_speed=scale * turbine.rated_rotor_speed,
        rated_torque=scale**2 * turbine.rated_torque,
    )
    found = default_settings(changed)

    assert found.overlap == pytest.approx(0.01 * scale**2, rel=0.05)
    assert found.speed_overlap == pytest.approx(0.1 * scale, rel=0.05)
    assert float(found.box.speed_error) <= 0.0484  # the table's end at cut-in


@pytest.mark.parametrize(
    ("time_constant", "pitch_error"),
    # The last two are both sides of what the model allows.
    [pytest.param(0.2, 0.0025, marks=pytest.mark.slow), (2.5, 0.031), (3, 0.034)],
)
def test_pitch_errors_of_a_region_stay_where_its_model_is_exact(
    time_constant: float, pitch_error: float
) -> None:
    """A drive of 3 s would ask for 0.038 rad; the model is exact up to 0.034907 rad."""
    turbine = replace(nrel5mw(), pitch_time_constant=time_constant)

    assert scale.region_requirements(turbine)[1].pitch_error == pitch_error
    assert regional_design(turbine)[2].full.requirement.pitch_error == pitch_error


@pytest.mark.slow
def test_fifteen_megawatt_is_proved_in_its_own_scale_and_not_in_another() -> None:
    """One P for all 71 cells, accepted by the checker; the 5-MW box asks too much."""
    turbine = load_turbine("iea15mw")
    asked = default_settings(turbine)
    schedule = effort_schedule(
        turbine, overlap=asked.overlap, effectiveness_share=asked.effectiveness_share
    )
    gains = effort_gains(turbine, schedule, asked.effort).gains
    law = EffortSharingLaw.of(turbine, schedule, gains)
    candidate = effort_sharing_candidate(turbine, law, box=asked.box)
    document = certificate_document(
        model=turbine_data(turbine, model_files("iea15mw")),
        gains=effort_sharing_law_data(law),
        claims=[effort_sharing_claim(candidate)],
        provenance=provenance(asked, {"joint analysis": candidate.words}),
    )
    checked = check_document(document)

    assert checked.verdict.name == "PROVED"
    assert min(candidate.wind_error) > 0.003  # m/s; the design widens it to 0.01
    with pytest.raises(ModelError, match=r"wind cell .3, 3.25. m/s: c_Q: tip-speed ratio"):
        effort_sharing_candidate(turbine, law, box=DEFAULT_BOX)
