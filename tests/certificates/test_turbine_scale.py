"""Design settings in a turbine's own scale."""

from __future__ import annotations

from dataclasses import replace

import pytest

from takagi.certificates import DesignSettings
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_BOX,
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.design.turbine import scale
from takagi.certificates.design.turbine.published_law import regional_design
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    provenance,
    turbine_data,
)
from takagi.lmi.turbine.effort import EffortSettings, effort_gains
from takagi.lmi.turbine.region_request import FULL_LOAD, PARTIAL_LOAD
from takagi.models import ModelError, nrel5mw
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.loader import load_turbine, model_files
from takagi.models.turbine.trim import TABLE_SHARE, reference_speed


def test_the_reference_keeps_its_settings() -> None:
    """On the NREL 5-MW turbine every ratio is 1, to the last digit."""
    turbine = nrel5mw()

    assert default_settings(turbine) == replace(DesignSettings(), effort=EffortSettings())
    assert scale.scaled_box(turbine) == DEFAULT_BOX
    assert scale.region_requirements(turbine) == (PARTIAL_LOAD, FULL_LOAD)


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
    with pytest.raises(ModelError, match=r"wind cell .3, 3.25. m/s"):
        effort_sharing_candidate(turbine, law, box=DEFAULT_BOX)
