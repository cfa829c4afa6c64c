"""The verdict on a certificate is what its claims allow, and no more."""

from __future__ import annotations

from itertools import product

import pytest

from takagi.certificates.checker import Verdict
from takagi.certificates.checker.kernel.result import Checked, Claim

PROVED, DISPROVED, UNDECIDED = Verdict.PROVED, Verdict.DISPROVED, Verdict.UNDECIDED


PAIRS = list(product(Verdict, repeat=2))


@pytest.mark.parametrize("verdicts", PAIRS, ids=lambda pair: "-".join(v.name for v in pair))
def test_two_claims(verdicts: tuple[Verdict, Verdict]) -> None:
    """PROVED when both are, DISPROVED when one is, UNDECIDED otherwise; messages are kept."""
    checked = Checked.of([Claim("a", verdict, "text") for verdict in verdicts], ["note"])

    expected = DISPROVED if DISPROVED in verdicts else UNDECIDED
    if verdicts == (PROVED, PROVED):
        expected = PROVED
    assert checked.verdict is expected
    assert [claim.verdict for claim in checked.claims] == list(verdicts)
    assert checked.messages == ["note"]


def test_no_claim_is_not_proved() -> None:
    assert Checked.of([], []).verdict is UNDECIDED
