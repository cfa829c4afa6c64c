"""Conic problems of other programs: what is proved encloses the known optimum, from both sides."""

from __future__ import annotations

import json
from copy import deepcopy
from itertools import combinations
from math import cos, nextafter, pi, sqrt
from pathlib import Path
from typing import Any

import cvxpy as cp
import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates import check
from takagi.certificates.checker import check_document
from takagi.certificates.claims.problem_verification import Verification, verify
from takagi.cli.main import main
from takagi.lmi import save_cvxpy
from takagi.lmi.problem_files.problem import ConicProblem
from takagi.lmi.problem_files.reading import read_problem_file
from tests.certificates.kinds.claims import resealed

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
