"""The claim about the effort-sharing loop: it is proved, and what its file has to be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import Verdict, check, check_document
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_UNCERTAINTY,
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import dumps
from takagi.models import Interval
from tests.certificates.kinds.claims import resealed

Document = dict[str, Any]


def test_the_whole_certificate_is_proved(built: Any, tmp_path: Path) -> None:
    """The emitted file proves for every wind from cut-in to cut-out, read back from disk."""
    path = tmp_path / "certificate.json"
    path.write_text(dumps(built.document), encoding="utf-8")

    checked = check(path)

    assert checked.verdict is Verdict.PROVED, checked.claims[0].text
    assert "winds 3 to 25 m/s" in checked.claims[0].text
    assert len(checked.messages) == 2, "embedded copies alone were checked: it has to say so"


def test_the_name_is_the_checkers_own(short: Document) -> None:
    """A forged name does not reach the reader: the claim is named by what was checked."""
    short["claims"][0]["name"] = "stable in every wind"
    short["claims"][0]["uncertainty"]["frozen_wake"] = False

    claim = check_document(resealed(short)).claims[0]

    assert claim.verdict is Verdict.PROVED
    assert (
        claim.name
        == f"effort-sharing loop, {claim.text.split(' m/s')[0][6:]} m/s, equilibrium wake"
    )


def test_a_file_without_a_power_coefficient_speaks_of_the_table(short: Document) -> None:
    """It says the same as one that states the table's, and does not mention another."""
    stated = check_document(short).claims[0].text
    del short["claims"][0]["uncertainty"]["power_coefficient"]

    claim = check_document(resealed(short)).claims[0]

    assert claim.verdict is Verdict.PROVED
    assert claim.text == stated and "of the table's c_P" not in claim.text


@pytest.mark.slow
def test_one_per_cent_of_power_is_proved_and_two_are_not(built: Any) -> None:
    """From both sides: near rated wind 2 % of the torque is more than the set holds."""
    for wrong, expected in ((1, Verdict.PROVED), (2, Verdict.UNDECIDED)):
        around = Interval.of(f"0.{100 - wrong}", f"1.{wrong:02d}")
        uncertainty = replace(DEFAULT_UNCERTAINTY, power_coefficient=around)
        candidate = effort_sharing_candidate(built.turbine, built.law, uncertainty=uncertainty)
        sealed = resealed(built.document | {"claims": [effort_sharing_claim(candidate)]})
        claim = check_document(sealed).claims[0]

        assert claim.verdict is expected
        if expected is Verdict.PROVED:
            assert "c_P 0.99 to 1.01 of the table's" in claim.text
            assert cross_checked_document(sealed).agrees
