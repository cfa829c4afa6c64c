"""A law that comes back from its gain file commands the same, bit for bit, or is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, TurbineDesign, law_from_gains
from takagi.certificates.design.turbine.published_law import designed_law
from takagi.certificates.document.certificate_file import (
    effort_sharing_law_data,
    published_law_data,
)
from takagi.models import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.laws.protocol import Law, Measurement
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import derated
from takagi.reports.gains_file.envelope import dump_gains, gain_file

TURBINE = nrel5mw()


def stored(law: dict[str, Any], folder: Path, **other: Any) -> Path:
    path = folder / "gains.json"
    content = {"format": "takagi-gains", "version": 2, "law": law, **other}
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def require_same(one: Law, other: Law) -> None:
    rng, count = np.random.default_rng(7), len(one.state_names)
    assert one.state_names == other.state_names and one.name == other.name
    for _ in range(100):
        measured = Measurement(rng.uniform(0.5, 1.6), rng.uniform(-0.1, 0.5), rng.uniform(2, 27))
        state = np.array([rng.uniform(-0.1, 0.1), rng.uniform(3, 25)])
        if one.name != "coherent":
            state = rng.uniform(-10, 2, count)
        assert one.command(state, measured) == other.command(state, measured)
        assert np.array_equal(one.state_rate(state, measured), other.state_rate(state, measured))


def test_the_file_of_a_design_gives_its_law(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    """As `takagi design` writes it; no turbine is needed, and none does harm."""
    path = tmp_path / "gains.json"
    path.write_text(dump_gains(gain_file(turbine_design)), encoding="utf-8")

    require_same(turbine_design.law, law_from_gains(path))
    require_same(turbine_design.law, law_from_gains(path, TURBINE))


@cache
def default_law() -> EffortSharingLaw:
    return law_of(TURBINE)


def law_of(
    turbine: Turbine, *, speed_setpoint: float | None = None, **asked: Any
) -> EffortSharingLaw:
    schedule = effort_schedule(turbine, speed_setpoint=speed_setpoint, **asked)
    count = len(schedule.wind)
    gains = EffortGains(np.linspace(1 / 3, 2 / 3, count), np.linspace(1 / 7, 3 / 7, count - 1))
    return EffortSharingLaw.of(turbine, schedule, gains)


OPTIONS: dict[str, Callable[[], EffortSharingLaw]] = {
    "overlap": lambda: law_of(TURBINE, overlap=0.02),
    "pitch effectiveness": lambda: law_of(TURBINE, effectiveness_share=0.9),
    "speed set-point": lambda: law_of(TURBINE, speed_setpoint=1.15),
    "torque set-point": lambda: law_of(derated(TURBINE, 0.8 * TURBINE.rated_torque)),
    "wind filter": lambda: replace(default_law(), wind_filter=0.05),
    "integral limit": lambda: replace(default_law(), integral_limit=0.02),
    "no filter": lambda: replace(default_law(), wind_filter=0.0),
}


@pytest.mark.parametrize("option", OPTIONS)
def test_every_option_comes_back(option: str, tmp_path: Path) -> None:
    """Each of them changes the law, and is in the file."""
    law = OPTIONS[option]()
    read = law_from_gains(stored(effort_sharing_law_data(law), tmp_path))

    require_same(law, read)
    assert isinstance(read, EffortSharingLaw)
    assert effort_sharing_law_data(read) != effort_sharing_law_data(default_law())


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_law_that_fed_the_winds_rate_forward_is_refused(version: int, tmp_path: Path) -> None:
    """It is another law than the one that would be read without these members."""
    data = effort_sharing_law_data(default_law())
    require_same(default_law(), law_from_gains(stored(data, tmp_path, version=version)))
    data["pitch_lead"] = 0.2

    with pytest.raises(CertificateError, match="pitch_lead"):
        law_from_gains(stored(data, tmp_path, version=version))


@pytest.mark.slow
def test_laws_of_the_paper_come_back_with_their_turbine(
    turbine_design: TurbineDesign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Linear ramp off centre; other tables are refused."""
    asked = replace(
        turbine_design.settings,
        law="paper",
        ramp_shape="linear",
        ramp_placement=0.25,
    )
    models = (turbine_design.partial_load, turbine_design.full_load, turbine_design.regional)
    law = designed_law(TURBINE, asked, models)
    path = stored(published_law_data(law), tmp_path)

    read = law_from_gains(path, TURBINE)

    require_same(law, read)
    assert law.coupling.speed_ramp.shape == "linear"
    assert law.coupling.speed_ramp.at(TURBINE.rated_rotor_speed) == pytest.approx(0.75)
    with pytest.raises(ModelError, match="give the turbine too"):
        law_from_gains(path)
    data = published_law_data(law)
    data["partial"]["pitch"][3] += 1e-9
    # The models are made once: they are what is compared, not how they are made.
    made = [law.partial, law.full]
    monkeypatch.setattr("takagi.certificates.design.given.turbine_law._schedules", lambda *_: made)
    with pytest.raises(CertificateError, match=r"not made for this turbine: partial\.pitch"):
        law_from_gains(stored(data, tmp_path), TURBINE)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"format": "takagi-certificate"}, "not a gain file of a turbine"),
        ({"version": 4}, "version 4; versions 1 to 3"),
        ({"law": {"name": "other"}}, "the law is 'other', not a wind turbine's"),
    ],
)
def test_other_files_are_refused_with_words(
    other: dict[str, Any], words: str, tmp_path: Path
) -> None:
    """A certificate, a file from the future, a law that is none of ours."""
    with pytest.raises(CertificateError, match=words):
        law_from_gains(stored({"name": "coherent"} | other.pop("law", {}), tmp_path, **other))
