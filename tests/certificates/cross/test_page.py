"""docs/cross-check.md: what it counts of the stored certificate is what the commands count."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from takagi.certificates import check
from takagi.certificates.cross_check.comparison import FlintDecider
from takagi.cli.main import main

# The stored certificate of the turbine is replayed, which takes seconds.
pytestmark = pytest.mark.slow

DOCS = Path(__file__).resolve().parents[3] / "docs"
PAGE = " ".join((DOCS / "cross-check.md").read_text(encoding="utf-8").split())
STORED = DOCS / "figures" / "nrel5mw-certificate.json"


def test_the_page_counts_what_is_decided_and_exported(tmp_path: Path) -> None:
    """Matrices and numbers of the second decision; matrices of the Coq file, and its size."""
    deciders: dict[int, FlintDecider] = {}
    checked = check(STORED, decider_of=lambda k: deciders.setdefault(k, FlintDecider()))
    out = tmp_path / "nrel5mw.v"
    assert main(["export", str(STORED), "--coq", str(out)]) == 0

    assert checked.verdict.name == "PROVED" and len(checked.claims) == 4
    claims = json.loads(STORED.read_text(encoding="utf-8"))["claims"]
    cells, running = (len(claims[place]["cells"]) for place in (0, 3))
    matrices, numbers = (
        sum(getattr(decider, name) for decider in deciders.values())
        for name in ("matrices", "numbers")
    )
    of = f"{cells} wind cells and {running} of the running loop"
    assert f"its four claims with {of}) has {matrices} matrices and {numbers} numbers" in PAGE
    of = f"4 claims, all {cells} wind cells, and {running} of the running loop"
    assert f"{of} | {matrices} | {out.stat().st_size / 1e6:.1f} MB |" in PAGE
    assert not any(decider.left_open for decider in deciders.values())
