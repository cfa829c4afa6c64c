"""De-rated operation is proved like any other, and the checker says that it is de-rated."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict, check
from takagi.certificates.claims.turbine.effort_sharing import (
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    provenance,
    turbine_data,
)
from takagi.lmi.turbine.effort import effort_gains
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.loader import model_files, nrel5mw
from takagi.models.turbine.trim import derated

# A design of its own takes ten seconds.
pytestmark = pytest.mark.slow

SHARE = 0.8
FILES = model_files("nrel5mw")
TURBINE_FILE = next(file for file in FILES if file.suffix == ".toml")


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    """The certificate of the effort-sharing loop at 80 % of rated torque, gains in two steps."""
    turbine = nrel5mw()
    lower = derated(turbine, SHARE * turbine.rated_torque)
    schedule = effort_schedule(lower)
    law = EffortSharingLaw.of(lower, schedule, effort_gains(lower, schedule).gains)
    candidate = effort_sharing_candidate(lower, law)
    return certificate_document(
        model=turbine_data(lower, FILES),
        gains=effort_sharing_law_data(law),
        claims=[effort_sharing_claim(candidate)],
        provenance=provenance({}, {}),
    )


def written(document: dict[str, Any], folder: Path) -> Path:
    path = folder / "certificate.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_eighty_percent_of_power_is_proved(document: dict[str, Any], tmp_path: Path) -> None:
    """All winds from 3 to 25 m/s, with the turbine's own file beside the certificate."""
    checked = check(written(document, tmp_path), model=TURBINE_FILE)

    assert checked.verdict is Verdict.PROVED
    assert "3 to 25 m/s" in checked.claims[0].text
    assert any(
        "de-rated: the law holds torque at 34474.84 N m, 80 %" in words
        for words in checked.messages
    )


def test_more_than_the_file_s_torque_is_refused(document: dict[str, Any], tmp_path: Path) -> None:
    """A law that asks for more than the generator of the file may give is not its law."""
    gains = {**document["gains"], "rated_torque": 43093.56}
    other = certificate_document(
        model=document["model"],
        gains=gains,
        claims=document["claims"],
        provenance=provenance({}, {}),
    )

    with pytest.raises(CertificateError, match=r"rated_torque is 43093\.55 there"):
        check(written(other, tmp_path), model=TURBINE_FILE)
