"""The verdict on a certificate is what its claims allow, and no more."""

from __future__ import annotations

from itertools import product

import pytest

from takagi.certificates import Claim
from takagi.certificates.checker import CertificateError, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.checker.replay.claim_kinds import PLANT_KINDS, TURBINE_KINDS, replay

PROVED, DISPROVED, UNDECIDED = Verdict.PROVED, Verdict.DISPROVED, Verdict.UNDECIDED


PAIRS = list(product(Verdict, repeat=2))


@pytest.mark.parametrize("verdicts", PAIRS, ids=lambda pair: "-".join(v.name for v in pair))
def test_two_claims(verdicts: tuple[Verdict, Verdict]) -> None:
    """PROVED when both are, DISPROVED when one is, UNDECIDED otherwise; messages are kept."""
    checked = concluded([Claim("a", verdict, "text") for verdict in verdicts], ["note"])

    expected = DISPROVED if DISPROVED in verdicts else UNDECIDED
    if verdicts == (PROVED, PROVED):
        expected = PROVED
    assert checked.verdict is expected
    assert [claim.verdict for claim in checked.claims] == list(verdicts)
    assert checked.messages == ["note"]


def test_no_claim_is_not_proved() -> None:
    assert concluded([], []).verdict is UNDECIDED


@pytest.mark.parametrize("kind", [*PLANT_KINDS, *TURBINE_KINDS])
def test_a_claim_that_reads_the_file_needs_one(kind: str) -> None:
    with pytest.raises(CertificateError, match="is not one that this checker replays"):
        replay({"kind": kind, "name": "a"}, None, None, [], "claim 1")
