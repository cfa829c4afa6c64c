"""Forged certificates about conic problems, and readers of files beside numpy and cvxpy."""

from __future__ import annotations

import json
from fractions import Fraction
from math import isqrt, sqrt
from pathlib import Path
from typing import Any

import cvxpy as cp
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from takagi.certificates import check
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.problem import conic_problem
from takagi.certificates.checker.problem.conic_problem import HALF_ROOT, UNIT
from takagi.lmi import save_cvxpy
from takagi.lmi.problem_files.problem import ConicProblem
from takagi.lmi.problem_files.reading import read_problem_file
from takagi.models.errors import ModelError
from tests.certificates.kinds.claims import Data, resealed, sealed

LINE = {"cone": "nonnegative", "size": 2, "entries": [[0, 0, -1], [1, 0, 1], [0, 1, 3], [1, 1, -1]]}


def problem(*blocks: Data, objective: Any = (1,), **members: Any) -> Data:
    model = {"kind": "conic-problem", "objective": list(objective), "offset": 0}
    return {**model, "sense": "minimise", "blocks": list(blocks or (LINE,)), **members}


def document(model: Data, kind: str, point: Any, **members: Any) -> Data:
    claim = {"name": "forged", "kind": kind, "point": list(point), "basis": [], **members}
    return sealed(model, None, claim)


def verdict(model: Data, kind: str, point: Any, **members: Any) -> str:
    try:
        return check_document(document(model, kind, point, **members)).verdict.name
    except CertificateError:
        return "REFUSED"


def cone(name: str, size: float, *entries: Any, **members: Any) -> Data:
    return {"cone": name, "size": size, "entries": list(entries), **members}


def equation(*entries: Any, size: int = 1) -> Data:
    return cone("zero", size, *entries)


def constant(name: str, size: int, values: Any, **members: Any) -> Data:
    return cone(name, size, *([0, k, value] for k, value in enumerate(values)), **members)


def semidefinite(*values: Any, **members: Any) -> Data:
    return constant("semidefinite", round(sqrt(2 * len(values))), values, **members)


def test_the_constants_of_the_rounding() -> None:
    """|HALF_ROOT - 1/sqrt(2)| < UNIT: (HALF_ROOT -+ UNIT)^2 are on both sides of 1/2."""
    assert (HALF_ROOT - UNIT) ** 2 < Fraction(1, 2) < (HALF_ROOT + UNIT) ** 2


@pytest.mark.parametrize("seed", range(20))
def test_the_rounded_matrix_is_within_its_error(seed: int) -> None:
    """Of numbers of any size and many digits: compared with 1/sqrt(2) to 200 digits."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 5))
    root = Fraction(isqrt(2 * 10**400), 2 * 10**200)
    values = [
        Fraction(int(rng.integers(-(10**9), 10**9)), int(rng.integers(1, 10**9)))
        ** int(rng.integers(1, 9))
        * Fraction(10) ** int(rng.integers(-60, 60))
        for _ in range(size * (size + 1) // 2)
    ]
    block = conic_problem.Block("semidefinite", size, bool(seed % 2), {}, {})
    matrix, error = conic_problem._symmetric(block, values)
    for i, j, k in conic_problem.triangle(size):
        exact = values[k] * (root if block.scaled and i != j else 1)
        assert abs(matrix[i, j] - exact) <= error
        assert matrix[i, j] == matrix[j, i]


def test_sentences_round_towards_less() -> None:
    """A point's value up, a bound down, a radius down; for a maximum the other way."""
    third = equation([0, 0, -1], [1, 0, 3])
    for sense, point, bound in (
        ("minimise", "at most 0.3333333334", "at least 0.3333333333"),
        ("maximise", "at least -0.3333333334", "at most -0.3333333333"),
    ):
        model = problem(third, sense=sense)
        told = check_document(document(model, "feasible-point", [0], basis=[0]))
        assert told.claims[0].text.endswith(point)
        figure, largest = told.claims[0].figures[0], sense == "maximise"
        assert figure.value == Fraction(-1 if largest else 1, 3)  # type: ignore[union-attr]
        assert figure.larger == largest  # type: ignore[union-attr]
        told = check_document(document(model, "optimum-bound", [0], basis=[0]))
        assert told.claims[0].text.endswith(bound)
        far = document(model, "optimum-bound", [0], radius=1.00000000009)
        assert "at most 1 in size" in check_document(far).claims[0].text


def test_numbers_that_grow_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of equations gives x hundreds of thousands of digits."""
    count, large = 700, 1234567890123457e25
    entries = [[k, k, large + k * 1e26] for k in range(count)]
    entries += [[k + 1, k, large + k * 3e27] for k in range(count)]
    model = problem(equation(*entries, size=count), objective=[1] * count)
    monkeypatch.setattr(conic_problem, "MOST_WORK", 10**8)
    claim = document(model, "feasible-point", [0] * count, basis=list(range(count)))
    assert "work" in check_document(claim).claims[0].text


def test_semidefinite_cones_are_limited_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of order 60 are within the limit here, three are not."""
    blocks = [cone("semidefinite", 60, *([0, i * (i + 3) // 2, 1] for i in range(60)))]
    monkeypatch.setattr(conic_problem, "MOST_WORK", 2 * 60**4)
    assert verdict(problem(*blocks), "feasible-point", [0]) == "PROVED"
    assert verdict(problem(*blocks * 3), "feasible-point", [0]) == "UNDECIDED"


def test_no_law_stands_beside_a_problem(tmp_path: Path) -> None:
    """PROVED of x = 2 would be said of any gains, and of any file of a model."""
    forged = document(problem(), "feasible-point", [2])
    path = tmp_path / "c.json"
    path.write_text(json.dumps(forged), encoding="utf-8")
    assert check(path).verdict.name == "PROVED"
    for given in ({"gains": path}, {"model": path}):
        with pytest.raises(CertificateError, match="needed|no model file|no claim"):
            check(path, **given)  # type: ignore[arg-type]
    forged["gains"] = {"K": [[1]]}
    with pytest.raises(CertificateError, match="no gains"):
        check_document(resealed(forged))


def values_at(problem: ConicProblem, x: Any) -> list[np.ndarray[Any, Any]]:
    listed: list[np.ndarray[Any, Any]] = []
    for block in problem.blocks:
        A, constant = block.arrays(len(problem.objective))
        values = A @ np.asarray(x) + constant
        if block.cone == "semidefinite":
            matrix = np.zeros((block.size, block.size))
            k = 0
            for i in range(block.size):
                for j in range(i + 1):
                    off = sqrt(2) if block.scaled and i != j else 1.0
                    matrix[i, j] = matrix[j, i] = values[k] / off
                    k += 1
            values = matrix
        listed.append(values)
    return listed


def symmetric(rng: np.random.Generator, size: int) -> np.ndarray[Any, Any]:
    matrix = rng.integers(-5, 6, (size, size)).astype(float)
    return np.asarray(matrix + matrix.T)


@pytest.mark.parametrize("seed", range(5))
def test_sdpa_and_sedumi_are_the_definition(seed: int, tmp_path: Path) -> None:
    """SDPA: sum x_i F_i - F_0; SeDuMi: c - A'y with all of the matrix, the largest b'y."""
    rng = np.random.default_rng(seed)
    F = [symmetric(rng, 3) for _ in range(3)]
    d = rng.integers(-5, 6, (3, 2)).astype(float)
    c, x = rng.integers(-5, 6, 2).astype(float), rng.normal(size=2)
    lines = ["* comment", "2 = m", "2 = blocks", "(3, -2)", "{" + f"{c[0]}, {c[1]}" + "}"]
    for i in range(3):
        lines += [f"{i} 1 {r + 1} {s + 1} {F[i][r, s]}" for r in range(3) for s in range(r, 3)]
        lines += [f"{i} 2 {r + 1} {r + 1} {d[i, r]}" for r in range(2)]
    path = tmp_path / "p.dat-s"
    path.write_text("\n".join(lines), encoding="utf-8")
    read = read_problem_file(path)
    matrix, diagonal = values_at(read, x)
    assert np.allclose(matrix, x[0] * F[1] + x[1] * F[2] - F[0])
    assert np.allclose(diagonal, x @ d[1:] - d[0])
    assert np.allclose(read.objective, c) and not read.maximised

    A = np.array([np.concatenate([d[i], F[i].ravel()]) for i in (1, 2)])
    rows = np.concatenate([d[0], F[0].ravel()])
    for name, stored in (("A", A), ("At", A.T)):
        file = {name: sp.csc_matrix(stored), "b": c, "c": rows, "K": {"l": 2.0, "s": 3.0}}
        scipy.io.savemat(tmp_path / "p.mat", file)
        read = read_problem_file(tmp_path / "p.mat")
        diagonal, matrix = values_at(read, x)
        assert np.allclose(matrix, F[0] - x[0] * F[1] - x[1] * F[2])
        assert np.allclose(diagonal, d[0] - x @ d[1:])
        assert np.isclose(read.value(x), c @ x) and read.maximised


@pytest.mark.parametrize("sense", ["MIN", "MAX"])
def test_cbf_is_the_definition(sense: str, tmp_path: Path) -> None:
    """A scalar in L-, a matrix X: <F, X> counts off the diagonal twice, in objective and rows."""
    text = f"""VER\n3\nOBJSENSE\n{sense}\nPSDVAR\n1\n2\nVAR\n1 1\nL- 1\nPSDCON\n1\n2\nCON\n2 2
L- 1\nL= 1\nOBJFCOORD\n2\n0 0 0 2\n0 1 0 3\nOBJACOORD\n1\n0 5\nOBJBCOORD\n7\nFCOORD\n2\n0 0 1 0 4
1 0 1 1 6\nACOORD\n1\n1 0 8\nBCOORD\n2\n0 9\n1 10\nHCOORD\n1\n0 0 1 0 11\nDCOORD\n1\n0 1 1 12\n"""
    path = tmp_path / "p.cbf"
    path.write_text(text, encoding="utf-8")
    read = read_problem_file(path)
    t, X = -2.0, np.array([[3.0, 5.0], [5.0, 13.0]])
    variable, matrix, row, equal, semi = values_at(read, [t, 3.0, 5.0, 13.0])
    assert variable == [2.0] and np.array_equal(matrix, X)
    assert row == [-(2 * 4 * 5 + 9)] and equal == [6 * 13 + 8 * t + 10]
    assert np.array_equal(semi, [[0, 11 * t], [11 * t, 12]])
    assert read.value(np.array([t, 3.0, 5.0, 13.0])) == 2 * 3 + 2 * 3 * 5 + 5 * t + 7
    assert read.maximised == (sense == "MAX")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("FCOORD\n1\n0 0 1 0 4\n", "FCOORD\n2\n0 0 1 0 4\n0 0 0 1 4\n"),
        ("BCOORD\n1\n0 9\n", "BCOORD\n2\n0 9\n0 9\n"),
        ("BCOORD\n1\n0 9\n", "BCOORD\n1\n0 9\nBCOORD\n1\n0 8\n"),
        ("CON\n1 1\n", "CON\n² 1\n"),
    ],
)
def test_cbf_with_two_meanings_is_refused(old: str, new: str, tmp_path: Path) -> None:
    text = "VER\n3\nPSDVAR\n1\n2\nCON\n1 1\nL+ 1\nFCOORD\n1\n0 0 1 0 4\nBCOORD\n1\n0 9\n"
    path = tmp_path / "p.cbf"
    path.write_text(text, encoding="utf-8")
    assert read_problem_file(path).blocks
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ModelError, match="twice|no number"):
        read_problem_file(path)


def stored(problem: cp.Problem, solver: str, path: Path) -> ConicProblem:
    data, _, _ = problem.get_problem_data(solver, solver_opts={"use_quad_obj": False})
    dims, A = data["dims"], data["A"].toarray()
    sizes = {"zero": dims.zero, "nonneg": dims.nonneg, "soc": dims.soc, "psd": dims.psd}
    np.savez(path, A=A, A_shape=A.shape, b=data["b"], c=data["c"], solver=solver, **sizes)
    return read_problem_file(path)


@pytest.mark.parametrize("solver", ["CLARABEL", "SCS"])
@pytest.mark.parametrize("seed", range(3))
def test_cvxpy_s_triangles(solver: str, seed: int, tmp_path: Path) -> None:
    """The matrix of three rows is the one that cvxpy was given, at every x."""
    rng = np.random.default_rng(seed)
    F, G = [symmetric(rng, 3) for _ in range(3)], rng.integers(-3, 4, (2, 2))
    x, at = cp.Variable(2), rng.normal(size=2)
    constraints = [x[0] * F[1] + x[1] * F[2] - F[0] >> 0, cp.SOC(5 + x[0], G @ x + 1)]
    constraints += [x[0] + 2 * x[1] == 3, x[1] <= 4]
    read = stored(cp.Problem(cp.Minimize(x[1]), constraints), solver, tmp_path / "p.npz")
    equal, row, second, matrix = values_at(read, at)
    assert np.allclose(np.abs(equal), abs(at[0] + 2 * at[1] - 3)) and np.allclose(row, 4 - at[1])
    assert np.allclose(second, [5 + at[0], *(G @ at + 1)])
    assert np.allclose(matrix, at[0] * F[1] + at[1] * F[2] - F[0])


def test_the_constant_of_cvxpy_s_objective(tmp_path: Path) -> None:
    x = cp.Variable(bounds=[0, 2])
    save_cvxpy(cp.Problem(cp.Maximize(x + 7), [x <= 1]), tmp_path / "p.npz")
    read = read_problem_file(tmp_path / "p.npz")
    assert read.value(np.ones(1)) == -8
    assert sorted(np.concatenate(values_at(read, [0.25]))) == [0.25, 0.75, 1.75]


def test_a_number_that_would_not_be_written_out(tmp_path: Path) -> None:
    path = tmp_path / "p.dat-s"
    path.write_text("1\n1\n-1\n1.0\n1 1 1 1 1e-999999999\n0 1 1 1 1.0\n", encoding="utf-8")
    assert read_problem_file(path).rounded == 1


@pytest.mark.parametrize("member", ["A", "b", "c"])
def test_complex_numbers_are_refused(member: str, tmp_path: Path) -> None:
    members = {"A": [[1.0]], "b": [1.0], "c": [1.0], "K": {"l": 1.0}}
    scipy.io.savemat(tmp_path / "p.mat", {**members, member: np.array(members[member]) * (1 + 1j)})
    with pytest.raises(ModelError, match="complex"):
        read_problem_file(tmp_path / "p.mat")


# x >= 1, where -x falls without end.
HALF = cone("nonnegative", 1, [0, 0, -1], [1, 0, 1])
FREE = problem(HALF, objective=(-1,))


@pytest.mark.parametrize(
    ("sense", "falls", "rises"), [("minimise", "falls", "rises"), ("maximise", "rises", "falls")]
)
def test_the_sentence_says_which_way(sense: str, falls: str, rises: str) -> None:
    """The problem's objective goes one way, its dual's the other."""
    ray = {"ray": [1], "form": "problem"}
    told = check_document(document({**FREE, "sense": sense}, "unbounded", [1], **ray))
    assert f"the objective {falls} without end" in told.claims[0].text

    rows = cone("nonnegative", 2, [0, 0, -3], [1, 0, 1], [0, 1, 1], [1, 1, -1])
    rays = {"ray": [1, 1], "form": "dual"}
    told = check_document(document(problem(rows, sense=sense), "unbounded", [1, 0], **rays))
    assert f"of the dual {rises} without end" in told.claims[0].text
