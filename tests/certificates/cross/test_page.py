"""docs/cross-check.md: what it counts of the stored certificate is what the commands count."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from takagi.certificates.cross_check.comparison import cross_checked
from takagi.certificates.cross_check.kernel.reading import load
from takagi.certificates.cross_check.opinion import claims_of, judge
from takagi.cli.main import main

# The stored certificate of the turbine is replayed, which takes seconds.
pytestmark = pytest.mark.slow

DOCS = Path(__file__).resolve().parents[3] / "docs"
PAGE = " ".join((DOCS / "cross-check.md").read_text(encoding="utf-8").split())
STORED = DOCS / "figures" / "nrel5mw-certificate.json"


@cache
def matrices_of_the_second_checker() -> int:
    return sum(one.inequalities for one in judge(STORED))


def test_the_page_counts_what_is_replayed() -> None:
    """Matrices as ``--cross`` prints them; facts about numbers as they are decided."""
    rows = cross_checked(STORED).rows
    cells, running = (len(load(STORED)["claims"][place]["cells"]) for place in (0, 3))
    obliged = Counter(
        type(one).__name__ for _, found in claims_of(load(STORED)) for one in found or ()
    )

    matrices = sum(row.inequalities for row in rows)
    assert {row.second for row in rows} == {"PROVED"} and len(rows) == 4
    assert matrices == matrices_of_the_second_checker() == obliged["Definite"]
    of = f"{cells} wind cells and {running} of the running loop"
    counted = f"{matrices} matrices and {obliged['Fact']} ranges, sizes and limits"
    assert f"its four claims with {of}, {counted}" in PAGE


def test_the_page_counts_what_is_exported(tmp_path: Path) -> None:
    """The matrices of the Coq file, and its size."""
    out = tmp_path / "nrel5mw.v"

    assert main(["export", str(STORED), "--coq", str(out)]) == 0

    matrices = matrices_of_the_second_checker()
    running = len(load(STORED)["claims"][3]["cells"])
    size = out.stat().st_size / 1e6
    of = f"4 claims, all 70 wind cells, and {running} of the running loop"
    assert f"{of} | {matrices} | {size:.1f} MB |" in PAGE
