"""Wind rates: a peak between the ends of a wind cell, and places of claims that are none."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker import check_document
from tests.certificates.conftest import resealed


def peaked(short: dict[str, Any], peak: float) -> dict[str, Any]:
    """Return the short certificate with a still estimate and phi up to ``peak`` inside a cell."""
    cells = short["claims"][0]["cells"]
    low, high = cells[2]["wind"]
    winds = [cells[0]["wind"][0], low, round((low + high) / 2, 9), high, cells[-1]["wind"][1]]
    still = {
        "wind": winds,
        "estimate_rate": [0.0] * 5,
        "schedule_rate": [0.0, 0.0, peak, 0.0, 0.0],
        "estimate_error": 0.0,
    }
    claim = {"kind": "wind-rate", "name": "rate", "loop": 0, "ranges": [still]}
    return short | {"claims": [*short["claims"], claim]}


@pytest.mark.parametrize(("more", "verdict"), [(0.0, Verdict.PROVED), (1e-6, Verdict.UNDECIDED)])
def test_a_peak_inside_a_wind_cell_counts(
    short: dict[str, Any], more: float, verdict: Verdict
) -> None:
    """phi is compared at its own nodes too, not only where wind cells end."""
    # A fast filter: a slow one would not follow so steep a peak.
    short["gains"]["wind_filter"] = tau = 0.05
    cell = short["claims"][0]["cells"][2]
    peak = min(cell["wind_rate"], cell["wind_error"] / tau)

    checked = check_document(resealed(peaked(short, round(peak - 1e-9, 9) + more)))

    assert checked.claims[0].verdict is Verdict.PROVED
    assert checked.claims[1].verdict is verdict


@pytest.mark.parametrize("place", [-1, -2, -3, 1, 2, 3])
def test_a_place_that_is_no_earlier_claim_is_refused(short: dict[str, Any], place: int) -> None:
    """Counted from the end, a place would pair the last claim with the verdict on another one."""
    document = peaked(short, 0.0)
    worse = deepcopy(document["claims"][0])
    worse["cells"][2]["wind_rate"] *= 100
    rate = document["claims"][1] | {"loop": place}

    with pytest.raises(CertificateError, match="earlier claim"):
        check_document(resealed(document | {"claims": [document["claims"][0], rate, worse]}))


def test_a_claim_of_another_kind_has_no_wind_class(short: dict[str, Any]) -> None:
    """A proved claim on rates is about the loop's cells, and has none itself."""
    document = peaked(short, 0.0)
    loop, proved = document["claims"]
    rate = peaked(short, 50.0)["claims"][1] | {"loop": 1}

    with pytest.raises(CertificateError, match="not of kind coherent-loop"):
        check_document(resealed(document | {"claims": [loop, proved, rate]}))
