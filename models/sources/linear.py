r"""A plant from matrices: one linear system, or all blends of the vertices of a polytope.

Of r vertices the weights h_i >= 0 with sum 1 are made of r - 1 signals in [0, 1],

    h_1 = w_1,   h_2 = (1 - w_1) w_2,   ...,   h_r = (1 - w_1) ... (1 - w_(r-1)),

which reach every such h and no other: the plant is every blend of the vertices, A = sum h_i A_i,
and its model at the corners of the signals has these vertices, some of them more than once.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.files.csv_table import read_matrix
from takagi.models.intervals.interval import rational
from takagi.models.plant.plant import Plant
from takagi.models.sources.symbolic import Quantity, Ranges, from_sympy
from takagi.models.ts.mat_file import load_ts_model
from takagi.models.ts.model import TSModel

MAX_VERTICES = 7  # 64 rules


def from_arrays(
    A: ArrayLike,
    B: ArrayLike | None = None,
    *,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    E: ArrayLike | None = None,
    states: Sequence[Quantity] | None = None,
    inputs: Sequence[Quantity] | None = None,
    disturbances: Sequence[Quantity] | None = None,
    outputs: Sequence[str] | None = None,
    ranges: Ranges | None = None,
    units: Mapping[Any, str] | None = None,
    sample_time: float | None = None,
    name: str = "linear plant",
) -> Plant:
    """Return the plant x' = A x + B u + E w, y = C x + D u; x(t + T) with a sample time.

    Parameters
    ----------
    A, B, C, D, E : (n, n), (n, m), (p, n), (p, m), (n, q), SI; or (r, ., .) for the r vertices of a
        polytope, all blends of which are the plant.  Numbers stand for their shortest decimals.
    states, inputs, disturbances, outputs : names; x1, x2, ..., u1, ..., d1, ..., y1, ... if left
        out.  The signals of the weights are w1, w2, ...
    ranges, units : as ``from_sympy`` has them; a linear plant needs none, and its units are not
        compared.

    Raises
    ------
    ModelError : shapes that do not fit, a number that is not finite, names of another count, more
        than 7 vertices.
    """
    vertices: Any = A
    with contextlib.suppress(ValueError):  # of a ragged list, which TSModel refuses with its reason
        vertices = [A] if np.ndim(A) == 2 else A
    model = TSModel(vertices, B, C=C, D=D, E=E, sample_time=sample_time)
    r = len(model.A)
    if r > MAX_VERTICES:
        raise ModelError(
            f"{r} vertices were given; their blends are a plant of 2^{r - 1} rules, and "
            f"{MAX_VERTICES} vertices are the most: keep them as takagi.models.TSModel(A, B), "
            "which takagi.lmi and certify take"
        )
    x = _symbols("states", states, "x", model.A.shape[2])
    u = _symbols("inputs", inputs, "u", model.B.shape[2])
    d = _symbols("disturbances", disturbances, "d", model.E.shape[2])
    y = _symbols("outputs", outputs, "y", model.C.shape[1])
    signals = [sp.Symbol(f"w{k}", real=True) for k in range(1, r)]

    def rows(*terms: tuple[Floats, list[sp.Symbol]]) -> list[sp.Expr]:
        """Return the sums of matrices times vectors, as blends of their vertices."""
        matrix = np.concatenate([matrices for matrices, _ in terms], axis=2)
        vector = [symbol for _, symbols in terms for symbol in symbols]
        return [
            sp.Add(*(_blend(matrix[:, k, j], signals) * v for j, v in enumerate(vector)))
            for k in range(matrix.shape[1])
        ]

    plant = from_sympy(
        rows((model.A, x), (model.B, u), (model.E, d)),
        x,
        u,
        {**(ranges or {}), **dict.fromkeys(signals, (0, 1))},
        disturbances=d,
        scheduling=signals,
        rest=dict.fromkeys(signals, "0.5"),
        outputs=dict(zip(map(str, y), rows((model.C, x), (model.D, u)), strict=True)),
        premises={f"weight{k}": signal for k, signal in enumerate(signals, start=1)},
        units=units,
        compare_units=False,
        sample_time=sample_time,
        name=name,
    )
    if not signals:
        return plant
    shares = " ".join(f"(1 - {w})" for w in signals)
    return replace(plant, source=f"blends of {r} vertices, h_1 = w1 to h_{r} = {shares}")


def _symbols(what: str, given: Sequence[Quantity] | None, letter: str, count: int) -> list[Any]:
    """Return the names as symbols; numbered letters where none are given."""
    if given is None:
        given = [f"{letter}{k}" for k in range(1, count + 1)]
    if len(given) != count:
        raise ModelError(
            f"{what}: {len(given)} names were given ({', '.join(map(str, given))}), and the "
            f"matrices have {count}; give each a name, or none"
        )
    return [sp.Symbol(str(name), real=True) for name in given]


def _blend(entries: Floats, signals: Sequence[sp.Symbol]) -> sp.Expr:
    """Return sum h_i a_i of the entries of r vertices; the number where all are the same."""
    numbers = [rational(float(entry)) for entry in entries]
    if len(set(numbers)) == 1:
        return numbers[0]
    blended = numbers[-1]
    for number, signal in zip(numbers[-2::-1], signals[::-1], strict=True):
        blended = signal * number + (1 - signal) * blended
    return blended


def from_csv(paths: Sequence[str | Path], **names: Any) -> Plant:
    """Return the linear plant of CSV files: A, then B, C, D as far as they are given.

    A file has one row of the matrix a line, its numbers between commas, semicolons or spaces.

    Parameters
    ----------
    names : ``states``, ``inputs``, ``ranges``, ... as ``from_arrays`` has them.

    Raises
    ------
    ModelError : a file that cannot be read, with its line; no file, or more than four; and
        whatever ``from_arrays`` refuses.
    """
    if not 1 <= len(paths) <= 4:
        raise ModelError(
            f"{len(paths)} files were given; A.csv is needed, then B.csv, C.csv and D.csv as far "
            "as there are such"
        )
    matrices = {
        letter: read_matrix(Path(path)) for letter, path in zip("ABCD", paths, strict=False)
    }
    return from_arrays(**{**names, **matrices})


def from_mat(path: str | Path, **names: Any) -> Plant:
    """Return the plant of a MAT-file: a linear system, or all blends of its vertices.

    The file is one of ``load_ts_model``: A, B, C, D, E, or A1, A2, ..., or the struct of
    ``takagi export --to mat``.

    Parameters
    ----------
    names : ``states``, ``inputs``, ``ranges``, ... as ``from_arrays`` has them.

    Raises
    ------
    ModelError : as ``load_ts_model`` and ``from_arrays``.
    """
    model = load_ts_model(path)
    matrices = {letter: getattr(model, letter) for letter in "ABCDE"}
    return from_arrays(**{"sample_time": model.sample_time, **names, **matrices})
