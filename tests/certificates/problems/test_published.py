"""Published LMIs through their files: what is proved is what is known, from both sides."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import fmpq, fmpq_mat
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are

from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.problem.conic_problem import Block, corrected, triangle
from takagi.certificates.claims.problem_verification import Verification, verify
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import as_read
from takagi.cli.main import main
from takagi.lmi.problem_files.reading import FORMS, read_problem_file
from tests.certificates.kinds.claims import said_of
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


ENTRY = st.fractions(-4, 4, max_denominator=5)


@given(st.integers(1, 5).flatmap(lambda n: st.lists(st.lists(ENTRY, min_size=n + 2, max_size=n + 2),
                                                    min_size=n, max_size=n)))  # fmt: skip
def test_equations_are_solved_as_flint_solves_them(rows: list[list[Fraction]]) -> None:
    """M v + b = r in the first places of v; the last one, which is no basis, stays."""
    n = len(rows)
    sparse = [{k: a for k, a in enumerate(row[: n + 1]) if a} for row in rows]
    start, right = [Fraction(1)] * (n + 1), [row[-1] for row in rows]
    M = fmpq_mat(n, n, [fmpq(a.numerator, a.denominator) for row in rows for a in row[:n]])

    if M.det() == 0:
        with pytest.raises(Refused):
            corrected(sparse, right, start, range(n))
        return

    rest = [r - row[n] for r, row in zip(right, rows, strict=True)]
    solution = M.solve(fmpq_mat(n, 1, [fmpq(a.numerator, a.denominator) for a in rest]))
    solved = corrected(sparse, right, start, range(n))
    assert solved[n] == 1
    assert solved[:n] == [Fraction(int(x.p), int(x.q)) for x in solution.entries()]


def test_equations_that_are_left_over_must_hold() -> None:
    """x = 2 twice, and x = 2 beside x = 3."""
    rows = [{0: Fraction(1)}, {0: Fraction(2)}]
    assert corrected(rows, [Fraction(2), Fraction(4)], [Fraction(0)], [0]) == [2]
    with pytest.raises(Refused, match="contradict"):
        corrected(rows, [Fraction(2), Fraction(6)], [Fraction(0)], [0])


def test_the_weights_of_a_large_triangle() -> None:
    """Once on the diagonal and twice beside it; once everywhere where values are scaled."""
    plain = Block("semidefinite", 12, False, {}, {})
    scaled = Block("semidefinite", 12, True, {}, {})
    for i, j, position in triangle(12):
        assert plain.weight(position) == (1 if i == j else 2)
        assert scaled.weight(position) == 1


def bound_within(sense: str, **members: Any) -> Any:
    """Return what is proved of: x_1 + 3 x_2 + 5 with x_1 >= 1 and x_2 >= 2, y = (0.9, 3.02)."""
    entries = [[0, 0, -1], [0, 1, -2], [1, 0, 1], [2, 1, 1]]
    model = {
        "kind": "conic-problem",
        "name": "two bounds",
        "objective": [1, 3],
        "offset": 5,
        "sense": sense,
        "blocks": [{"cone": "nonnegative", "size": 2, "entries": entries}],
    }
    claim = {"name": "b", "kind": "optimum-bound", "point": [0.9, 3.02], "basis": []} | members
    return said_of(model, None, claim)


@pytest.mark.parametrize(("sense", "sign"), [("minimise", 1), ("maximise", -1)])
def test_a_bound_within_a_box_by_hand(sense: str, sign: int) -> None:
    """5 + 0.9 + 2 * 3.02 - 10 (0.1 + 0.02) = 10.74; the optimum is 12, or -12 of the opposite."""
    claim = bound_within(sense, radius=10)

    bound, size = claim.figures
    assert claim.verdict.name == "PROVED"
    assert bound.value == sign * Fraction("10.74") and bound.larger == (sign == 1)
    assert size.value == 10 and size.larger


def test_a_bound_of_all_solutions_by_hand() -> None:
    """With y = (1, 3) it is the optimum itself, 12: the equations are solved in both places."""
    claim = bound_within("minimise", basis=[0, 1])

    (bound,) = claim.figures
    assert claim.verdict.name == "PROVED" and bound.value == 12


def test_more_variables_than_are_read() -> None:
    model = {"kind": "conic-problem", "name": "n", "objective": [1] * 2001, "offset": 0}
    model |= {"sense": "minimise", "blocks": [{"cone": "zero", "size": 1, "entries": []}]}
    claim = {"name": "p", "kind": "feasible-point", "point": [0] * 2001, "basis": []}
    with pytest.raises(CertificateError, match="variables"):
        said_of(model, None, claim)
