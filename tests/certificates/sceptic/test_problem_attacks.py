"""Forged certificates about conic problems, and readers of files beside numpy and cvxpy."""

from __future__ import annotations

import json
from fractions import Fraction
from math import isqrt, nextafter, sqrt
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
from takagi.certificates.document.certificate_file import certificate_document
from takagi.lmi import save_cvxpy
from takagi.lmi.problem_files.problem import ConicProblem
from takagi.lmi.problem_files.reading import read_problem_file
from takagi.models.errors import ModelError
from tests.certificates.kinds.claims import resealed

Data = dict[str, Any]
LINE = {"cone": "nonnegative", "size": 2, "entries": [[0, 0, -1], [1, 0, 1], [0, 1, 3], [1, 1, -1]]}


def problem(*blocks: Data, objective: Any = (1,), **members: Any) -> Data:
    """Return the problem of these blocks; without any 1 <= x <= 3."""
    model = {"kind": "conic-problem", "objective": list(objective), "offset": 0}
    return {**model, "sense": "minimise", "blocks": list(blocks or (LINE,)), **members}


def document(model: Data, kind: str, point: Any, **members: Any) -> Data:
    claim = {"name": "forged", "kind": kind, "point": list(point), "basis": [], **members}
    return certificate_document(model=model, gains=None, claims=[claim], provenance={})


def verdict(model: Data, kind: str, point: Any, **members: Any) -> str:
    """Return the verdict, or that the file is refused."""
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


@pytest.mark.parametrize("point", [0, nextafter(1, 0), nextafter(3, 4), 1e40, -1e40])
def test_a_point_outside(point: float) -> None:
    assert verdict(problem(), "feasible-point", [point]) == "UNDECIDED"


@pytest.mark.parametrize(
    "block",
    [
        constant("second-order", 1, [-1e-40]),
        constant("second-order", 2, [1, nextafter(-1, -2)]),
        constant("second-order", 2, [-1, 0]),
        constant("second-order", 3, [1e40, 1e40, 1e-40]),
        semidefinite(-1e-40),
        semidefinite(-1e-40, scaled=True),
        semidefinite(0, 1e-40, 1e40),
        semidefinite(0, 1e-40, 1e40, scaled=True),
        semidefinite(1e-40, 1, 1e40, 0, 0, -1e-40),
        semidefinite(1, nextafter(sqrt(2), 2), 1, scaled=True),
        semidefinite(1e40, 1.4142135623730953e40, 1e40, scaled=True),
        semidefinite(1e-40, 1.4142135623730952e-40, 1e-40, scaled=True),
        semidefinite(1, 1.0000000001, 1),
        equation([0, 0, 1e-40]),
    ],
)
def test_constants_outside_their_cone(block: Data) -> None:
    assert verdict(problem(block), "feasible-point", [0]) == "UNDECIDED"


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


@pytest.mark.parametrize(
    ("point", "members"),
    [
        ([1, 0], {}),
        ([nextafter(1, 2), 0], {"radius": 1.5}),
        ([2, 1], {}),
        ([0, -1], {}),
        ([-1, -2], {}),
        ([2, 0], {"basis": [1]}),
        ([1, 1], {"basis": [1]}),
        ([0, 0], {"basis": [0, 0]}),
        ([0, 0], {"basis": [-1]}),
        ([0, 0], {"basis": [2]}),
        ([0, 0], {"basis": [0, 1]}),
        ([0, 0], {"radius": 0}),
        ([0, 0], {"radius": -1}),
        ([0, 0], {"radius": None}),
        ([0, 0], {"radius": 100}),
        ([2, -1], {"radius": 1}),
    ],
)
def test_a_bound_is_never_above_the_optimum(point: Any, members: Data) -> None:
    """The optimum of x in 1 <= x <= 3 is 1; within a radius no solution may be below."""
    try:
        checked = check_document(document(problem(), "optimum-bound", point, **members))
    except CertificateError:
        return
    if checked.verdict.name == "PROVED":
        assert checked.claims[0].figures[0].value <= 1  # type: ignore[union-attr, operator]


@pytest.mark.parametrize(
    "point", [[0, 0], [1, 1], [-1, -1], [1, 0], [0, 1e-40], [1e40, 1e40], [-1e-40, -1e-40]]
)
@pytest.mark.parametrize("basis", [[], [0], [1]])
def test_no_solution_of_a_problem_with_one(point: Any, basis: Any) -> None:
    assert verdict(problem(), "no-solution", point, basis=basis) == "UNDECIDED"
    line = equation([0, 0, -1], [1, 0, 1])
    assert verdict(problem(LINE, line), "no-solution", [*point, 5], basis=[2]) == "UNDECIDED"


@pytest.mark.parametrize("scaled", [False, True])
def test_weights_off_the_diagonal(scaled: bool) -> None:
    """[[1, x], [x, 1]] in its cone: -1 <= x <= 1, and with sqrt(2) off the diagonal sqrt(2) more.

    The multiplier [[h, h], [h, h]] needs 2 h = 1 of a matrix; counted once it would be h = 1 and
    bound x by -2; counted twice, h = 1/2 and with sqrt(2) bound x by -1, above the optimum.
    """
    block = cone("semidefinite", 2, [0, 0, 1], [1, 1, 1], [0, 2, 1], scaled=scaled)
    model = problem(block)
    assert verdict(model, "optimum-bound", [0.5, 0.5, 0.5]) != "PROVED" or not scaled
    # Diagonals are a little larger than 1/sqrt(2), so that the multiplier is inside.
    point = [0.7072, 1, 0.7072] if scaled else [0.5, 0.5, 0.5]
    checked = check_document(document(model, "optimum-bound", point))
    assert checked.verdict.name == "PROVED"
    bound = checked.claims[0].figures[0].value  # type: ignore[union-attr]
    assert bound <= (-sqrt(2) if scaled else -1)  # type: ignore[operator]


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


@pytest.mark.parametrize(
    "block",
    [
        cone("nonnegative", 1, [1, 0, 1], [1.0, 0, 1]),
        cone("nonnegative", 1, [1, 0, 1], [1e0, 0.0, -1]),
        cone("nonnegative", 1, [2, 0, 1]),
        cone("nonnegative", 1, [-1, 0, 1]),
        cone("nonnegative", 1, [0.5, 0, 1]),
        cone("nonnegative", 1, [1, 0.5, 1]),
        cone("nonnegative", 1, [1, -1, 1]),
        cone("nonnegative", 1, [1, 1, 1]),
        cone("nonnegative", 1, [1, 0]),
        cone("nonnegative", 1, [1, 0, 1, 1]),
        cone("nonnegative", 1, [1, 0, True]),
        cone("nonnegative", 1, [1, 0, "1"]),
        cone("nonnegative", 1, [1, 0, 1e41]),
        cone("nonnegative", 1, [1, 0, 1e-41]),
        cone("nonnegative", 1, [1, 0, float("inf")]),
        cone("nonnegative", 1, [1, 0, float("nan")]),
        cone("nonnegative", 0),
        cone("nonnegative", -1),
        cone("nonnegative", 1.5),
        cone("semidefinite", 0),
        cone("semidefinite", 2, [0, 3, 1]),
        cone("semidefinite", 201),
        cone("semidefinite", 1, scaled=1),
        cone("exponential", 3),
        cone("Zero", 1),
    ],
)
def test_malformed_blocks_are_refused(block: Data) -> None:
    assert verdict(problem(block), "feasible-point", [1]) == "REFUSED"


@pytest.mark.parametrize(
    ("members", "point"),
    [
        ({"sense": "maximize"}, [2]),
        ({"sense": None}, [2]),
        ({"objective": []}, []),
        ({"blocks": []}, [2]),
        ({"offset": "0"}, [2]),
        ({"kind": "plant"}, [2]),
        ({"kind": "takagi-sugeno"}, [2]),
        ({}, []),
        ({}, [2, 2]),
        ({"blocks": [cone("zero", 500_000)] * 100}, [2]),
        ({"blocks": [cone("semidefinite", 200)] * 11}, [2]),
    ],
)
def test_malformed_problems_are_refused(members: Data, point: Any) -> None:
    assert verdict({**problem(), **members}, "feasible-point", point) == "REFUSED"


def test_equations_that_do_not_hold() -> None:
    """A basis that leaves equations open, contradicts them, or has more than one solution."""
    pair = equation([0, 0, -1], [1, 0, 1], [2, 0, 1], [0, 1, -1], [1, 1, 1], [2, 1, 1], size=2)
    model = problem(pair, objective=(1, 1))
    for point, basis, expected in (
        ([1, 0], [], "PROVED"),
        ([1, 1], [], "UNDECIDED"),
        ([1, 1], [0], "PROVED"),
        ([1, 1], [0, 1], "UNDECIDED"),
        ([1, 1], [1, 1], "UNDECIDED"),
    ):
        assert verdict(model, "feasible-point", point, basis=basis) == expected
    pair["entries"][3] = [0, 1, -2]
    for basis in ([], [0], [1], [0, 1]):
        assert verdict(model, "feasible-point", [1, 1], basis=basis) == "UNDECIDED"


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


def test_claims_of_other_kinds_beside_it() -> None:
    forged = document(problem(), "feasible-point", [2])
    forged["claims"].append({"name": "decay", "kind": "decay", "rate": 1})
    with pytest.raises(CertificateError, match="no vertices"):
        check_document(resealed(forged))


def values_at(problem: ConicProblem, x: Any) -> list[np.ndarray[Any, Any]]:
    """Return S_k(x), of a semidefinite cone as the symmetric matrix."""
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
    """Return cvxpy's data for a solver through an npz file with a dense A."""
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
HAIR = 1e-40


def without_bound(model: Data, point: Any, ray: Any, **members: Any) -> str:
    """Return the verdict on the claim that the objective has no bound."""
    members = {"form": "problem", **members}
    return verdict(model, "unbounded", point, ray=list(ray), **members)


@pytest.mark.parametrize(
    ("point", "ray", "expected"),
    [
        ([1], [HAIR], "PROVED"),
        ([1], [1], "PROVED"),
        ([nextafter(1, 0)], [1], "UNDECIDED"),
        ([1], [0], "UNDECIDED"),
        ([1], [-HAIR], "UNDECIDED"),
        ([1], [], "REFUSED"),
        ([1], [1, 1], "REFUSED"),
        ([1], [None], "REFUSED"),
    ],
)
def test_a_half_line_by_hand(point: Any, ray: Any, expected: str) -> None:
    """-x has no bound on x >= 1; a point outside, a ray that stands still or goes back."""
    assert without_bound(FREE, point, ray) == expected
    # A constant of the objective falls along no ray.
    assert without_bound({**FREE, "offset": -5}, point, ray) == expected
    # Of the opposite objective it is the least that has a bound.
    assert without_bound(problem(HALF), point, ray) != "PROVED"


@pytest.mark.parametrize(
    ("columns", "hair"),
    [
        (cone("semidefinite", 2, [1, 0, 1], [1, 1, 1], [1, 2, 1]), 1),
        (cone("semidefinite", 2, [1, 0, 1], [1, 1, 1.4142135623730950], [1, 2, 1], scaled=True), 1),
        (cone("second-order", 3, [1, 0, 5], [1, 1, 3], [1, 2, 4]), 2),
        (cone("nonnegative", 2, [1, 0, 1], [1, 1, HAIR]), 1),
        (cone("zero", 1), 0),
    ],
)
def test_a_ray_that_leaves_its_cone_by_a_hair(columns: Data, hair: int) -> None:
    """At the edge of its cone; then one value more, or one the other way."""
    assert without_bound(problem(columns, objective=(-1,)), [0], [1]) == "PROVED"
    entries = [list(entry) for entry in columns["entries"]]
    if not entries:
        entries = [[1, 0, HAIR]]
    elif columns["cone"] == "nonnegative":
        entries[hair][2] = -HAIR
    else:
        entries[hair][2] = nextafter(nextafter(entries[hair][2], 9), 9)
    outside = {**columns, "entries": entries}
    assert without_bound(problem(outside, objective=(-1,)), [0], [1]) == "UNDECIDED"


def test_a_ray_that_leaves_an_equation() -> None:
    """x_1 = x_2 + 1: the ray (1, 1 + 1e-40) is mended in x_2, and refused without a place."""
    line = equation([0, 0, -1], [1, 0, 1], [2, 0, -1])
    model = problem(line, objective=(-1, 0))
    for ray in ([1, 1], [1, 1 + 1e-15], [1, 0]):
        expected = "PROVED" if ray == [1, 1] else "UNDECIDED"
        assert without_bound(model, [1, 0], ray) == expected
        assert without_bound(model, [1, 0], ray, basis=[1]) == "PROVED"
    # Mended in x_1 the ray (1, 0) stands still.
    assert without_bound(model, [1, 0], [1, 0], basis=[0]) == "UNDECIDED"
    # The point must hold the equation too, and is mended in the same place.
    assert without_bound(model, [1, 1], [1, 1]) == "UNDECIDED"
    assert without_bound(model, [1, 1], [1, 1], basis=[1]) == "PROVED"


def test_no_ray_where_the_objective_falls_without_end() -> None:
    """[[x_1, x_2], [x_2, 1]] semidefinite: x_2 <= sqrt(x_1) has no bound, but no ray raises x_2."""
    block = cone("semidefinite", 2, [1, 0, 1], [2, 1, 1], [0, 2, 1])
    model = problem(block, objective=(0, -1))
    for ray in ([1, 1], [1e40, 1e-40], [1e40, 1], [1, 0], [0, 1]):
        assert without_bound(model, [1, 1], ray) == "UNDECIDED"


@pytest.mark.parametrize(
    ("point", "ray", "members", "expected"),
    [
        ([1, 0], [1, 1], {}, "PROVED"),
        ([2, 1], [HAIR, HAIR], {}, "PROVED"),
        ([1, 1], [1, 1], {"basis": [0]}, "PROVED"),
        ([1, 0], [1, 2], {"basis": [0]}, "PROVED"),
        ([1, 1], [1, 1], {}, "UNDECIDED"),
        ([1, 1], [1, 1], {"radius": 1}, "UNDECIDED"),
        ([0, -1], [1, 1], {}, "UNDECIDED"),
        ([1, 0], [1, 1 + 1e-15], {}, "UNDECIDED"),
        ([1, 0], [0, 0], {}, "UNDECIDED"),
        ([1, 0], [-1, -1], {}, "UNDECIDED"),
        ([1], [1, 1], {}, "REFUSED"),
        ([1, 0], [1], {}, "REFUSED"),
        ([1, 0], [1, 1], {"form": "primal"}, "REFUSED"),
        ([1, 0], [1, 1], {"form": None}, "REFUSED"),
    ],
)
def test_multipliers_without_bound(point: Any, ray: Any, members: Any, expected: str) -> None:
    """x >= 3 and x <= 1 with the objective x: y_1 - y_2 = 1 and 3 y_1 - y_2 rises along (1, 1)."""
    rows = [[0, 0, -3], [1, 0, 1], [0, 1, 1], [1, 1, -1]]
    model = problem(cone("nonnegative", 2, *rows))
    assert without_bound(model, point, ray, **{"form": "dual", **members}) == expected
    # With one point left, x = 3, the value along the ray stays.
    touching = problem(cone("nonnegative", 2, *rows[:2], [0, 1, 3], rows[3]))
    assert without_bound(touching, point, ray, **{"form": "dual", **members}) != "PROVED"


def test_a_point_of_the_dual_is_none_of_the_problem() -> None:
    """The same numbers under the other form: neither point nor ray."""
    pair = problem(cone("nonnegative", 1, [0, 0, -1], [1, 0, 1]), objective=(-1,))
    assert without_bound(pair, [1], [1]) == "PROVED"
    assert without_bound(pair, [1], [1], form="dual") == "UNDECIDED"


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
