"""Published LMIs through their files: what is proved is what is known, from both sides."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from takagi.certificates.claims.problem_verification import Verification, verify
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import as_read
from takagi.cli.main import main
from takagi.lmi.problem_files.reading import FORMS, read_problem_file
from tests.certificates.problems.published import (
    FEASIBLE,
    INFEASIBLE,
    OPEN,
    PUBLISHED,
    UNBOUNDED,
    WRITERS,
    Published,
    affine,
    parabola,
    symmetric,
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


@pytest.mark.parametrize("ending", sorted(FORMS))
@pytest.mark.parametrize("form", ["problem", "dual"])
def test_the_answer_says_whose_objective_has_no_bound(
    ending: str, form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """-x with [[x, 1], [1, 2]] semidefinite; x_1 + x_2 with x_1 x_2 >= 1 and x_1 + x_2 <= 1."""
    if form == "problem":
        lmi = affine([-1], lambda x: symmetric(x[0], 1, 2))
    else:
        lmi = affine([1, 1], lambda x: symmetric(x[0], 1, x[1]), lambda x: [[1 - x[0] - x[1]]])
    path, out = tmp_path / f"p{ending}", tmp_path / "certificate.json"
    WRITERS[ending](lmi, path)

    assert main(["verify", str(path), "--out", str(out)]) == 0

    printed = capsys.readouterr().out
    assert f"without bound is that of {FORMS[ending][form == 'dual']}" in printed
    consequence = {"problem": "the dual has no solution", "dual": "no point satisfies"}
    assert consequence[form] in printed
    assert main(["check", str(out), "--cross"]) == 0


def test_a_bound_in_a_box_is_no_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where x_2 <= sqrt(x_1) alone limits x_2, its objective has no bound, and no ray shows it."""
    path = tmp_path / "parabola.dat-s"
    WRITERS[".dat-s"](parabola(), path)

    assert main(["verify", str(path)]) == 1

    printed = capsys.readouterr().out
    assert printed.splitlines()[0].endswith("UNDECIDED")
    assert "in a box alone" in printed and "misses the cones by" in printed
    assert main(["verify", str(path), "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "UNDECIDED" and not answer["settled"]
