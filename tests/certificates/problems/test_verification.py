"""Conic problems of other programs: what is proved encloses the known optimum, from both sides."""

from __future__ import annotations

import json
from copy import deepcopy
from fractions import Fraction
from itertools import combinations
from math import cos, nextafter, pi, sqrt
from pathlib import Path
from typing import Any

import cvxpy as cp
import numpy as np
import pytest
import scipy.io
from flint import fmpq, fmpq_mat
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are

from takagi.certificates import check
from takagi.certificates.checker import CertificateError, check_document
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.problem.conic_problem import Block, corrected, triangle
from takagi.certificates.claims.problem_verification import Verification, verify
from takagi.certificates.cross_check.comparison import cross_checked_document
from takagi.certificates.document.certificate_file import as_read
from takagi.cli.main import main
from takagi.lmi import save_cvxpy
from takagi.lmi.problem_files.problem import ConicProblem
from takagi.lmi.problem_files.reading import FORMS, read_problem_file
from tests.certificates.kinds.claims import resealed, said_of
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

# Minimise x_1 + x_2 with [[x_1, 1], [1, x_2]] semidefinite and x_1 <= 4: the optimum is 2.
SDPA = """"two numbers whose product is at least one
2
2
2 -1
1.0 1.0
1 1 1 1 1.0
2 1 2 2 1.0
0 1 1 2 -1.0
1 2 1 1 -1.0
0 2 1 1 -4.0
"""
CBF = """VER
3
OBJSENSE
MIN
VAR
2 1
F 2
CON
1 1
L+ 1
PSDCON
1
2
OBJACOORD
2
0 1.0
1 1.0
ACOORD
1
0 0 -1.0
BCOORD
1
0 4.0
HCOORD
2
0 0 0 0 1.0
0 1 1 1 1.0
DCOORD
1
0 1 0 1.0
"""


def product(variables: Any) -> cp.Problem:
    x = variables
    return cp.Problem(cp.Minimize(x[0] + x[1]), [cp.bmat([[x[0], 1], [1, x[1]]]) >> 0, x[0] <= 4])


def written(form: str, folder: Path) -> Path:
    path = folder / f"problem{form}"
    if form in (".dat-s", ".cbf"):
        path.write_text(SDPA if form == ".dat-s" else CBF, encoding="utf-8")
    elif form == ".mat":
        # max b'y with c - A'y in K, y = x: the linear row first, then all of the matrix.
        columns = [[1.0, -1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, -1.0]]
        data = {"A": np.array(columns), "b": [-1.0, -1.0], "c": [4.0, 0.0, 1.0, 1.0, 0.0]}
        scipy.io.savemat(path, data | {"K": {"l": 1.0, "s": 2.0}})
    else:
        save_cvxpy(product(cp.Variable(2)), path)
    return path


def enclosed(verification: Verification) -> tuple[float, float]:
    values = [claim.figures[0].value for claim in verification.checked.claims]  # type: ignore[union-attr]
    assert [claim.verdict.name for claim in verification.checked.claims] == ["PROVED"] * 2
    assert None not in values
    return float(values[0]), float(values[1])  # type: ignore[arg-type]


@pytest.mark.parametrize("form", [".dat-s", ".cbf", ".mat", ".npz"])
def test_every_format_has_the_same_optimum(form: str, tmp_path: Path) -> None:
    """x_1 x_2 >= 1 has the least sum 2; SeDuMi maximises the opposite."""
    problem = read_problem_file(written(form, tmp_path))

    value, bound = enclosed(verify(problem))

    sign = -1 if form == ".mat" else 1
    assert sign * bound <= 2 <= sign * value
    assert sign * value - sign * bound < 1e-5


def test_the_command_writes_what_check_proves(tmp_path: Path, capsys: Any) -> None:
    path, out = written(".dat-s", tmp_path), tmp_path / "certificate.json"

    assert main(["verify", str(path), "--out", str(out), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert main(["check", str(out)]) == 0
    assert main(["check", str(out), "--cross"]) == 0

    assert printed["settled"] and printed["verdict"] == "PROVED"
    assert [claim["figures"][0]["name"] for claim in printed["claims"]] == [
        "objective",
        "bound of the optimum",
    ]


def theta(edges: list[tuple[int, int]], count: int) -> ConicProblem:
    """Return Lovasz's problem: maximise sum X with trace X = 1 and X_ij = 0 on the edges."""
    X = cp.Variable((count, count), symmetric=True)
    constraints = [X >> 0, cp.trace(X) == 1] + [X[i, j] == 0 for i, j in edges]
    problem = cp.Problem(cp.Maximize(cp.sum(X)), constraints)
    return in_file(problem)


def in_file(problem: cp.Problem) -> ConicProblem:
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        path = Path(folder) / "problem.npz"
        save_cvxpy(problem, path)
        return read_problem_file(path)


@pytest.mark.parametrize(
    ("count", "value"), [(5, sqrt(5)), (7, 7 * cos(pi / 7) / (1 + cos(pi / 7)))]
)
def test_the_theta_number_of_a_cycle(count: int, value: float) -> None:
    """Lovasz (1979), On the Shannon capacity of a graph: n cos(pi/n) / (1 + cos(pi/n)), n odd."""
    cycle = [(k, (k + 1) % count) for k in range(count)]

    point, bound = enclosed(verify(theta([(max(e), min(e)) for e in cycle], count)))

    # cvxpy minimises the opposite.
    assert -point <= value <= -bound
    assert point - bound < 1e-5


def test_the_maximum_cut_of_a_complete_graph() -> None:
    """Goemans and Williamson (1995): of K_n the relaxation is n^2 / 4."""
    n = 4
    X = cp.Variable((n, n), symmetric=True)
    cut = sum((1 - X[i, j]) / 2 for i, j in combinations(range(n), 2))
    problem = cp.Problem(cp.Maximize(cut), [X >> 0, cp.diag(X) == 1])

    point, bound = enclosed(verify(in_file(problem)))

    # What cvxpy takes out of the objective as a constant, n (n - 1) / 4, is in the file.
    assert -point <= n * n / 4 <= -bound
    assert point - bound < 1e-5


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_a_second_solver_s_optimum_is_enclosed(seed: int) -> None:
    """Random linear, second-order and semidefinite constraints with a point inside."""
    rng = np.random.default_rng(seed)
    x = cp.Variable(3)
    A = rng.integers(-3, 4, (4, 3, 3))
    M = sum(x[i] * (A[i] + A[i].T) for i in range(3)) + 9 * np.eye(3)
    c, G = rng.integers(-3, 4, 3), rng.integers(-3, 4, (2, 3))
    problem = cp.Problem(cp.Minimize(c @ x), [M >> 0, cp.norm(G @ x) <= 5, x <= 4, x >= -4])

    verification = verify(in_file(problem))

    problem.solve(solver=cp.SCS, eps=1e-8)
    if not np.any(c):
        assert verification.settled
        return
    point, bound = enclosed(verification)
    assert bound - 1e-4 <= problem.value <= point + 1e-4
    assert bound <= point


def test_constraints_that_contradict_one_another(tmp_path: Path) -> None:
    """x >= 1 and x <= 0.999; with x <= 1 there is one point, which is found."""
    head = "1\n1\n-2\n0.0\n1 1 1 1 1.0\n1 1 2 2 -1.0\n0 1 1 1 1.0\n"
    path = tmp_path / "p.dat-s"
    path.write_text(head + "0 1 2 2 -0.999\n", encoding="utf-8")
    verification = verify(read_problem_file(path))
    assert [claim["kind"] for claim in verification.document["claims"]] == ["no-solution"]
    assert verification.settled and verification.checked.verdict.name == "PROVED"

    path.write_text(head + "0 1 2 2 -1.0\n", encoding="utf-8")
    verification = verify(read_problem_file(path))
    assert [claim["kind"] for claim in verification.document["claims"]] == ["feasible-point"]
    assert verification.settled


def test_damaged_certificates_are_not_proved(tmp_path: Path) -> None:
    verification = verify(read_problem_file(written(".dat-s", tmp_path)))
    for number, change in ((0, -1e-3), (1, 1e-3)):
        document = deepcopy(verification.document)
        claim = document["claims"][number]
        # The first diagonal entry; the basis of the bound restores its equation in another.
        free = [k for k in range(len(claim["point"])) if k not in claim["basis"]]
        for k in free:
            altered = deepcopy(document)
            altered["claims"][number]["point"][k] += change
            checked = check_document(resealed(altered))
            proved = checked.claims[number]
            if proved.verdict.name == "PROVED":
                value = float(proved.figures[0].value)  # type: ignore[union-attr, arg-type]
                assert value >= 2 if number == 0 else value <= 2
            else:
                assert proved.verdict.name == "UNDECIDED"
    moved = deepcopy(verification.document)
    moved["claims"][0]["point"] = [1, nextafter(1, 0)]
    assert check_document(resealed(moved)).claims[0].verdict.name == "UNDECIDED"


def test_a_bound_within_a_box(tmp_path: Path) -> None:
    """x_1 >= 0 with [[x_1, 1], [1, x_2]] semidefinite: the infimum 0 of x_1 is not attained.

    Multipliers have no point inside: of the matrix's the second diagonal entry must be 0.
    """
    path = tmp_path / "p.dat-s"
    text = "2\n1\n2\n1.0 0.0\n1 1 1 1 1.0\n2 1 2 2 1.0\n0 1 1 2 -1.0\n"
    path.write_text(text, encoding="utf-8")

    verification = verify(read_problem_file(path))

    bounds = [c for c in verification.document["claims"] if c["kind"] == "optimum-bound"]
    for claim in bounds:
        exact = "radius" not in claim
        assert verification.settled == exact
    assert verification.checked.verdict.name == "PROVED"
    value = float(verification.checked.claims[0].figures[0].value)  # type: ignore[union-attr, arg-type]
    assert value >= 0


@pytest.mark.parametrize(
    ("name", "text", "word"),
    [
        ("a.txt", "", ".dat-s"),
        ("a.dat-s", "1\n1\n2\n", "four lines"),
        ("a.dat-s", "1\n1\n2\n1.0\n1 1 3 3 1.0\n", "outside the block"),
        ("a.dat-s", "1\n1\n2\n1.0\n1 1 1 1 nan\n", "finite"),
        ("a.dat-s", "1\n1\n-2\n1.0\n1 1 1 2 1.0\n", "diagonal"),
        ("a.cbf", "VER\n3\nINT\n1\n0\n", "INT"),
        ("a.cbf", "VAR\n3 1\nQR 3\n", "QR"),
        ("a.mat", "no", "MAT"),
        ("a.npz", "no", "npz"),
    ],
)
def test_files_that_do_not_fit(
    name: str, text: str, word: str, tmp_path: Path, capsys: Any
) -> None:
    """Status 2, and a sentence with the file, the line and what is needed."""
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")

    assert main(["verify", str(path)]) == 2

    message = capsys.readouterr().err
    assert word in message and name in message


def test_a_solution_of_another_solver(tmp_path: Path) -> None:
    """CSDP's text and JSON; a solution that is far off is replaced by what can be proved."""
    path = written(".dat-s", tmp_path)
    problem = read_problem_file(path)
    from takagi.lmi.problem_files.reading import read_solution_file

    for name, text in (
        ("s.sol", "1 1\n1 1 1 1 0.0\n2 1 1 1 1.0\n2 1 1 2 -1.0\n2 1 2 2 1.0\n"),
        ("s.json", '{"x": [1, 1], "y": [[1, -1, 1], [0]]}'),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
        solution = read_solution_file(tmp_path / name, problem)
        value, bound = enclosed(verify(problem, solution))
        # Both are exact here, and so is the claim.
        assert value == bound == 2


def test_a_certificate_is_read_from_its_file(tmp_path: Path) -> None:
    path, out = written(".cbf", tmp_path), tmp_path / "c.json"

    assert main(["verify", str(path), "-o", str(out)]) == 0

    checked = check(out)
    assert checked.verdict.name == "PROVED"
    assert "problem inside" in " ".join(checked.messages)


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
