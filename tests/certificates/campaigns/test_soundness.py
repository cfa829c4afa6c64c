"""No verdict is false on problems whose truth is known; reduced forms of the campaign."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
campaign: Any = import_module("soundness")
LOOPS: dict[str, Any] = campaign.LOOPS
CLAIMS: dict[str, Any] = campaign.DIRECT
# Evidence that cannot fit: multipliers are thrown blindly there.
BLIND = {"multipliers against pairs", "single blends against decay"}


@pytest.mark.slow
@pytest.mark.parametrize("name", CLAIMS)
def test_claims_with_closed_forms(name: str) -> None:
    """Best evidence and wrong evidence, on both sides of the limit: true is proved, false never."""
    counts = campaign.family_of_claims(CLAIMS[name], np.random.default_rng(7), 240)

    assert counts["false proved"] == counts["false disproved"] == 0
    if name not in BLIND:
        assert counts["fitting proved"] > 0.2 * counts["fitting"] > 0
        assert counts["number"] > counts["true"]


@pytest.mark.slow
def test_loops_beside_their_threshold() -> None:
    """Four of each family: whatever ``certify`` finds, it is not false."""
    rng, totals = np.random.default_rng(8), dict.fromkeys(("PROVED", "DISPROVED"), 0)
    for family in LOOPS.values():
        counts = campaign.family_of_loops(family, rng, 4)
        assert counts["false proved"] == counts["false disproved"] == 0
        for key in totals:
            totals[key] += counts[key]

    assert min(totals.values()) > 4


def test_a_slack_that_is_no_share_of_the_range_would_be_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With the absolute 1e-12 of earlier releases laws of another rest are counted as false."""
    from takagi.certificates.checker.plant import trim

    family = campaign.ANSWERS["laws that rest beside the plant"]
    honest = campaign.family_of_answers(family, np.random.default_rng(4), 100)
    monkeypatch.setattr(trim, "allowed", lambda variable, stated: Fraction(1, 10**12))
    absolute = campaign.family_of_answers(family, np.random.default_rng(4), 100)

    assert honest["false proved"] == 0 < honest["PROVED"] < honest["number"]
    assert absolute["false proved"] > 0


def test_a_false_verdict_would_be_seen() -> None:
    """The count of false verdicts is of the truth, not of what was said: turn the truth round."""

    def turned(rng: np.random.Generator) -> Any:
        return [known._replace(truth=not known.truth) for known in CLAIMS["gain of energy"](rng)]

    counts = campaign.family_of_claims(turned, np.random.default_rng(9), 100)

    assert counts["false proved"] > 0


@pytest.mark.slow
def test_the_campaign_finds_nothing_false(reduced: bool) -> None:
    """As ``make campaigns`` runs it, with another seed; reduced: one in forty."""
    count = "600" if reduced else "24000"
    command = [sys.executable, "benchmarks/soundness.py", "--count", count, "--seed", "2"]

    ran = subprocess.run([*command, "--print-only"], cwd=ROOT, capture_output=True, text=True)

    assert ran.returncode == 0, ran.stdout + ran.stderr
