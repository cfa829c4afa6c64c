r"""Problems as arrays: SeDuMi's in a MAT file, as YALMIP exports it, and cvxpy's data in npz.

SeDuMi, with y for x here, and K = {f, l, q, s} (free, linear, second-order, semidefinite):

    maximise  b'y   subject to   c - A'y  in  K

cvxpy, with the dimensions ``zero``, ``nonneg``, ``soc`` and ``psd`` of its cones, of which the
semidefinite ones are triangles with sqrt(2) off the diagonal:

    minimise  c'x   subject to   b - A x  in  K

``save_cvxpy`` writes such a file.  Nothing in it is a pickle.

Source: Sturm (1999), Using SeDuMi 1.02, Optimization Methods and Software 11; Diamond and Boyd
(2016), CVXPY, Journal of Machine Learning Research 17.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.problem_files.problem import (
    NONNEGATIVE,
    SECOND_ORDER,
    SEMIDEFINITE,
    ZERO,
    Block,
    ConicProblem,
    require,
    triangle_position,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.mat_file import mat_content

CVXPY_SOLVERS = ("CLARABEL", "SCS")


def read_sedumi(path: Path) -> ConicProblem:
    """Return the problem of a MAT file with A (or At), b, c and K.

    Raises
    ------
    ModelError : a member is missing or does not fit, a matrix is not symmetric, or a cone is not
        supported.
    """
    source, members = path.name, mat_content(path)
    for name in ("b", "c", "K"):
        require(name in members, source, f"the member {name} is missing; A, b, c and K are needed")
    require("A" in members or "At" in members, source, "the member A is missing")
    K = {name: np.ravel(members["K"][name][0, 0]) for name in members["K"].dtype.names or ()}
    b, c = (np.ravel(_dense(members[name])) for name in ("b", "c"))
    A = sp.csr_array(members["A"] if "A" in members else np.transpose(members["At"]))
    require(not np.iscomplexobj(A.data), source, "complex numbers are not supported")
    A = A if A.shape[0] == len(b) else sp.csr_array(A.T)
    require(A.shape == (len(b), len(c)), source, f"A has the shape {A.shape}, b and c others")
    supported = {"f", "l", "q", "s"}
    for name, sizes in K.items():
        used = name not in supported and any(np.ravel(x).any() for x in sizes if np.size(x))
        require(not used, source, f"K.{name} is not supported; f, l, q and s are")
    blocks = []
    first, columns = 0, sp.csc_array(A)
    for cone, size, length in _sedumi_cones(K):
        block = Block(cone, size)
        span = slice(first, first + length)
        require(first + length <= len(c), source, "K has more rows than c")
        _fill(block, 0, c[span], source)
        part = -columns[:, span].toarray()
        for i, row in enumerate(part):
            _fill(block, i + 1, row, source)
        blocks.append(block)
        first += length
    require(first == len(c), source, f"K has {first} rows, c {len(c)}")
    return ConicProblem(source, -b, 0.0, True, tuple(blocks))


def _sedumi_cones(K: dict[str, Any]) -> Iterator[tuple[str, int, int]]:
    """Yield (cone, size, rows of c) in SeDuMi's order."""
    for name, cone in (("f", ZERO), ("l", NONNEGATIVE)):
        count = int(sum(K.get(name, ())))
        if count > 0:
            yield cone, count, count
    for size in map(int, K.get("q", ())):
        if size > 0:
            yield SECOND_ORDER, size, size
    for size in map(int, K.get("s", ())):
        if size > 0:
            yield SEMIDEFINITE, size, size * size


def _fill(block: Block, index: int, values: Floats, source: str) -> None:
    """Put the values of one column into a block; those of a matrix are given as all of it."""
    if block.cone != SEMIDEFINITE:
        for k in np.flatnonzero(values):
            block.add(index, int(k), float(values[k]))
        return
    matrix = values.reshape(block.size, block.size)
    symmetric = bool((matrix == matrix.T).all())
    require(symmetric, source, "a matrix of a semidefinite cone is not symmetric")
    for row, column in zip(*np.nonzero(np.tril(matrix)), strict=True):
        value = float(matrix[row, column])
        block.add(index, triangle_position(int(row), int(column)), value)


def read_cvxpy(path: Path) -> ConicProblem:
    """Return the problem of an npz file with cvxpy's data; see ``save_cvxpy``.

    Raises
    ------
    ModelError : a member is missing or does not fit.
    """
    source = path.name
    try:
        with np.load(path, allow_pickle=False) as stored:
            members = {name: stored[name] for name in stored.files}
    except (ValueError, OSError) as error:
        require(False, source, f"not an npz file of plain arrays: {error}")
    needed = {"A", "A_shape"} & members.keys() and {"b", "c"} <= members.keys()
    require(bool(needed), source, "A, b and c are needed; takagi.lmi.save_cvxpy writes them")
    A, b, c = _stored_matrix(members), np.ravel(members["b"]), np.ravel(members["c"])
    require(A.shape == (len(b), len(c)), source, f"A has the shape {A.shape}, b and c others")
    solver = str(members.get("solver", CVXPY_SOLVERS[0]))
    require(solver in CVXPY_SOLVERS, source, f"solver {solver!r}; {' or '.join(CVXPY_SOLVERS)}")
    blocks, first = [], 0
    for cone, size in _cvxpy_cones(members):
        block = Block(cone, size, scaled=cone == SEMIDEFINITE and size > 1)
        order = _order(size, solver) if cone == SEMIDEFINITE else np.arange(size)
        rows = sp.coo_array(A[first : first + block.length])
        require(first + block.length <= len(b), source, "the cones have more rows than b")
        for k, value in enumerate(b[first : first + block.length]):
            block.add(0, int(order[k]), float(value))
        for row, column, value in zip(*rows.coords, rows.data, strict=True):
            block.add(int(column) + 1, int(order[row]), -float(value))
        blocks.append(block)
        first += block.length
    require(first == len(b), source, f"the cones have {first} rows, b {len(b)}")
    offset = float(members.get("offset", 0.0))
    return ConicProblem(source, c, offset, False, tuple(blocks))


def save_cvxpy(problem: Any, path: Path | str) -> None:
    """Write a cvxpy problem as plain arrays (npz), for ``takagi verify``.

    Parameters
    ----------
    problem : a ``cvxpy.Problem`` with linear, second-order and semidefinite cones.
    path : the file, which ends with .npz.

    Raises
    ------
    ModelError : a cone of another kind, or a quadratic objective that is none in cones.
    """
    data, _, inverse = problem.get_problem_data("CLARABEL", solver_opts={"use_quad_obj": False})
    dims = data["dims"]
    other = {name for name in ("exp", "p3d", "pnd") if np.size(getattr(dims, name, ())) and
             np.any(getattr(dims, name))}  # fmt: skip
    require(not other, str(path), f"cones {', '.join(sorted(other))} are not supported")
    A = sp.csc_array(data["A"])
    np.savez(
        path,
        A_shape=np.array(A.shape),
        A_data=A.data,
        A_indices=A.indices,
        A_indptr=A.indptr,
        b=data["b"],
        c=data["c"],
        # What the objective has beside c'x is none of the solver's data.
        offset=np.array(float(inverse[-1]["offset"])),
        zero=np.array(dims.zero),
        nonneg=np.array(dims.nonneg),
        soc=np.array(dims.soc, dtype=int),
        psd=np.array(dims.psd, dtype=int),
        solver=np.array("CLARABEL"),
    )


def _stored_matrix(members: dict[str, Any]) -> sp.csr_array:
    if "A" in members:
        return sp.csr_array(np.atleast_2d(members["A"]))
    parts = tuple(members[f"A_{name}"] for name in ("data", "indices", "indptr"))
    return sp.csr_array(sp.csc_array(parts, shape=tuple(members["A_shape"])))


def _cvxpy_cones(members: dict[str, Any]) -> Iterator[tuple[str, int]]:
    """Yield (cone, size) in cvxpy's order."""
    for name, cone in (("zero", ZERO), ("nonneg", NONNEGATIVE)):
        count = int(members.get(name, 0))
        if count > 0:
            yield cone, count
    for name, cone in (("soc", SECOND_ORDER), ("psd", SEMIDEFINITE)):
        for size in np.ravel(members.get(name, ())):
            if size > 0:
                yield cone, int(size)


def _order(size: int, solver: str) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the positions of a triangle's values in the solver's order.

    Clarabel has the upper triangle column by column, which is the lower one row by row; SCS has the
    lower triangle column by column.
    """
    if solver == "CLARABEL":
        return np.arange(size * (size + 1) // 2)
    pairs = ((row, column) for column in range(size) for row in range(column, size))
    return np.array([triangle_position(row, column) for row, column in pairs])


def _dense(value: Any) -> Floats:
    array = sp.csr_array(value).toarray()
    if np.iscomplexobj(array):
        raise ModelError("complex numbers in b or c are not supported")
    return np.asarray(array, dtype=np.float64)
