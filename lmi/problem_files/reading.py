"""The reader for a problem's or a solution's file, by how its name ends."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from takagi.lmi.problem_files.arrays import read_cvxpy, read_sedumi
from takagi.lmi.problem_files.problem import ConicProblem, Solution, require
from takagi.lmi.problem_files.text_formats import read_cbf, read_sdpa, read_solution
from takagi.models.errors import ModelError

# How a file's name ends -> what its format calls the problem that is read, and the dual of it.
FORMS = {
    ".dat-s": ("SDPA's primal, (P)", "SDPA's dual, (D)"),
    ".cbf": ("the problem of the file", "the dual of the file's problem"),
    ".mat": ("SeDuMi's dual, max b'y", "SeDuMi's primal, min c'x"),
    ".npz": ("cvxpy's cone program", "the dual of cvxpy's cone program"),
}
LARGEST_FILE = 50_000_000


def read_problem_file(path: Path) -> ConicProblem:
    """Return the problem of a file that ends with ``.dat-s``, ``.cbf``, ``.mat`` or ``.npz``.

    Raises
    ------
    ModelError : another ending, a file that cannot be read, or contents that do not fit.
    """
    ending = ending_of(path.name)
    require(bool(ending), str(path), f"a file that ends with {', '.join(FORMS)} is needed")
    if ending in (".dat-s", ".cbf"):
        text = _text(path)
        return read_sdpa(text, path.name) if ending == ".dat-s" else read_cbf(text, path.name)
    require(path.is_file(), str(path), "there is no such file")
    return read_sedumi(path) if ending == ".mat" else read_cvxpy(path)


def ending_of(name: str) -> str:
    """Return how a problem file's name ends; empty if no reader takes it."""
    return next((ending for ending in FORMS if name.lower().endswith(ending)), "")


def read_solution_file(path: Path, problem: ConicProblem) -> Solution:
    """Return a solution: JSON with ``x`` and, if known, ``y``, or the text of CSDP.

    Raises
    ------
    ModelError : a file that cannot be read, or numbers that do not fit the problem.
    """
    text, source = _text(path), path.name
    if path.suffix.lower() != ".json":
        return read_solution(text, problem, source)
    try:
        members = json.loads(text)
        x = np.asarray(members["x"], dtype=np.float64)
        y = np.concatenate([np.ravel(part) for part in members["y"]]) if members.get("y") else None
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ModelError(
            f'{source}: {{"x": [...], "y": [[...], ...]}} is needed, y by blocks ({error})'
        ) from error
    variables, length = len(problem.objective), sum(block.length for block in problem.blocks)
    require(x.shape == (variables,), source, f"x needs {variables} numbers")
    require(y is None or y.shape == (length,), source, f"y needs {length} numbers")
    finite = np.isfinite(x).all() and (y is None or np.isfinite(y).all())
    require(bool(finite), source, "all numbers must be finite")
    return Solution(x, y)


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        require(len(content) <= LARGEST_FILE, str(path), f"larger than {LARGEST_FILE} bytes")
        return content.decode("utf-8")
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"{path}: not a text: {error}") from error
