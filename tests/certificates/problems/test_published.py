"""Published LMIs through their files: what is proved is what is known, from both sides."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from takagi.certificates.claims.problem_verification import Verification, verify
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import as_read
from takagi.lmi.problem_files.reading import read_problem_file
from tests.certificates.problems.published import (
    FEASIBLE,
    INFEASIBLE,
    OPEN,
    PUBLISHED,
    UNBOUNDED,
    Published,
    table,
)

PAGE = Path(__file__).resolve().parents[3] / "docs" / "verify.md"
KINDS = {FEASIBLE: "feasible-point", INFEASIBLE: "no-solution", UNBOUNDED: "unbounded"}


@pytest.mark.parametrize("problem", PUBLISHED, ids=[problem.name for problem in PUBLISHED])
def test_what_is_known_is_proved(problem: Published, tmp_path: Path) -> None:
    """An answer, or bounds that enclose the published optimum and lie close together."""
    verification = verify(read_problem_file(problem.written(tmp_path)))

    assert cross_checked_document(as_read(verification.document)).agrees
    kinds = [claim["kind"] for claim in verification.document["claims"]]
    if problem.known == OPEN:
        assert not verification.settled and verification.verdict.name == "UNDECIDED"
        assert "misses" in " ".join(verification.notes)
        assert not {"no-solution", "unbounded"} & {*kinds}
        return
    assert verification.settled and verification.verdict.name == "PROVED"
    if isinstance(problem.known, str):
        assert kinds[0] == KINDS[problem.known]
        return
    assert kinds == ["feasible-point", "optimum-bound"]
    low, high = enclosure(verification)
    assert low - problem.digits <= problem.known <= high + problem.digits
    assert high - low <= 2e-7 * max(1.0, abs(problem.known))


def enclosure(verification: Verification) -> tuple[float, float]:
    """Return both proved bounds of the optimum, the lower one first."""
    values = [claim.figures[0].value for claim in verification.checked.claims]  # type: ignore[union-attr]
    low, high = sorted(float(value) for value in values)  # type: ignore[arg-type]
    return low, high


def test_the_trace_of_mincx_is_that_of_the_riccati_equation(tmp_path: Path) -> None:
    """A'X + XA + XBB'X + Q = 0: the least X is the stabilising solution, which scipy computes."""
    (problem,) = (problem for problem in PUBLISHED if problem.name == "mincx.cbf")
    A = np.array([[-1.0, -2, 1], [3, 2, 1], [1, -2, -1]])
    Q = np.array([[1.0, -1, 0], [-1, -3, -12], [0, -12, -36]])
    X = solve_continuous_are(A, np.array([[1.0], [0], [1]]), Q, -np.eye(1))

    low, high = enclosure(verify(read_problem_file(problem.written(tmp_path))))

    assert low - 1e-9 <= np.trace(X) <= high + 1e-9


def test_every_reader_has_published_problems() -> None:
    endings = [Path(problem.name).suffix for problem in PUBLISHED]
    assert {ending: endings.count(ending) >= 4 for ending in endings} == {
        ending: True for ending in (".dat-s", ".cbf", ".mat", ".npz")
    }


def test_the_page_lists_them() -> None:
    assert table() in PAGE.read_text(encoding="utf-8")
