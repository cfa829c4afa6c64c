r"""A plant from matrices: one linear system, or all blends of the vertices of a polytope.

Of r vertices the weights h_i >= 0 with sum 1 are made of r - 1 signals in [0, 1],

    h_1 = w_1,   h_2 = (1 - w_1) w_2,   ...,   h_r = (1 - w_1) ... (1 - w_(r-1)),

which reach every such h and no other: the plant is every blend of the vertices, A = sum h_i A_i,
and its model at the corners of the signals has these vertices, some of them more than once.

A linear plant from a ``.lin`` file of OpenFAST: A, B, C, D about one operating point.

States of which the others are kept settle at once where the file has more states than are wanted:
with x1 kept and 0 = A21 x1 + A22 x2 + B2 u,

    A = A11 - A12 A22^-1 A21,   B = B1 - A12 A22^-1 B2,

which has the file's gain at rest and is an approximation elsewhere.  The rotor's angle has no rest;
it and its column are left out.
"""

from __future__ import annotations

import contextlib
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import dropwhile, islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.csv_table import read_matrix
from takagi.models.files.library import read_text
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


# What a law of a turbine commands, and what comes from outside, by OpenFAST's descriptions.
COMMANDED = ("collective blade-pitch command", "Generator torque")
FROM_OUTSIDE = ("horizontal wind speed",)
AZIMUTH = "GeAz"
FEW = 4  # inputs, which are all taken where none has a description of these
_ROW = re.compile(r"\s*\d+\s+\S+(?:\s+\S+)*?\s+([TF])\s+(?:\d+\s+)?(\S.*?)\s*$")


class Signal(NamedTuple):
    """A state or input of the file: its name here, OpenFAST's description, and its frame."""

    name: str
    description: str
    rotates: bool


def from_lin(
    path: str | Path,
    *,
    states: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
    disturbances: Sequence[str] | None = None,
    ranges: Mapping[Any, Any] | None = None,
    units: Mapping[Any, str] | None = None,
) -> Plant:
    """Return the plant of a linearisation file of OpenFAST, in deviations from its operating point.

    Names are the indices that OpenFAST gives its degrees of freedom, TFA1, GeAz, ..., with ``d_``
    for rates, else the words of the description.

    Parameters
    ----------
    states : those to keep, the others settle at once; all but the rotor's angle if left out.
    inputs, disturbances : those to keep; if left out, collective pitch, generator torque and
        horizontal wind where the file has them, else all of up to four inputs.
    ranges, units : name -> (low, high) of deviations, and their units, as ``from_sympy`` has them.

    Raises
    ------
    ModelError : no such file, a name that it does not have, states in the rotating frame that are
        kept, states that cannot settle.
    """
    lines = read_text(Path(path)).splitlines()
    signals, columns = (
        _signals(lines, f"Order of {what}:") for what in ("continuous states", "inputs")
    )
    if not signals:
        raise ModelError(
            f"{path}: has no 'Order of continuous states'; a .lin file of OpenFAST's linearisation "
            "of the whole turbine is needed"
        )
    A = _matrix(lines, "A", (len(signals), len(signals)), path)
    B = _matrix(lines, "B", (len(signals), len(columns)), path)
    moving = [k for k, signal in enumerate(signals) if signal.name != AZIMUTH]
    kept = _places(signals, states, moving, "state", path)
    commanded, outside = _chosen_inputs(columns, inputs, disturbances, path)
    rotating = [signals[k].name for k in kept if signals[k].rotates]
    if rotating:
        raise ModelError(
            f"{path}: {len(rotating)} states are in the rotating frame ({', '.join(rotating[:6])}"
            f"{', ...' if len(rotating) > 6 else ''}), and one file has them at one azimuth alone; "
            "switch these degrees of freedom off in OpenFAST, or name the states to keep "
            "(--state), and the others settle at once"
        )
    # One whose row is 0 stays where it is.
    settled = [k for k in moving if k not in kept and (np.any(A[k]) or np.any(B[k]))]
    A, B = _residual(A, B, kept, settled, path)
    plant = from_arrays(
        A,
        B[:, commanded] if commanded else None,
        E=B[:, outside] if outside else None,
        states=[signals[k].name for k in kept],
        inputs=[columns[k].name for k in commanded],
        disturbances=[columns[k].name for k in outside],
        ranges=ranges,
        units=units,
        name=Path(path).stem,
    )
    words = {signal.name: signal.description for signal in (*signals, *columns)}
    described: dict[str, Any] = {
        what: tuple(replace(v, description=words[v.name]) for v in getattr(plant, what))
        for what in ("states", "inputs", "disturbances")
    }
    source = f"OpenFAST's linearisation {Path(path).name}, deviations from its operating point"
    if settled:
        source += f"; {len(settled)} of its states settle at once"
    return replace(plant, source=source, **described)


def _signals(lines: Sequence[str], title: str) -> list[Signal]:
    """Return the rows of a list of the file, with names that differ."""
    names: Counter[str] = Counter()
    signals: list[Signal] = []
    below = dropwhile(lambda line: line.strip() != title, lines)
    for line in islice(below, 1, None):
        row = _ROW.match(line)
        if row is None and signals:
            break
        if row is not None:
            name = _name(row[2])
            names[name] += 1
            suffix = f"_{names[name]}" if names[name] > 1 else ""
            signals.append(Signal(f"{name[: 40 - len(suffix)]}{suffix}", row[2], row[1] == "T"))
    return signals


def _name(description: str) -> str:
    """Return TFA1, or d_TFA1 of its rate, or the words of a description without an index."""
    index = re.search(r"DOF index = DOF_(\w+)(?:\((\d+),\s*(\d+)\))?", description)
    rate = "d_" if "time derivative of" in description else ""
    if index:
        return rate + "_".join(part for part in index.groups() if part)
    quantity = description.rpartition(",")[0] or description
    words = re.sub(r"^\w+ (Extended input: )?|\(.*?\)", "", quantity)
    return re.sub(r"^(?=\d|$)", "x", re.sub(r"\W+", "_", words).strip("_"))[:40].strip("_")


def _matrix(lines: Sequence[str], letter: str, shape: tuple[int, int], path: str | Path) -> Floats:
    """Return a matrix of the file, which stands below ``A: 4 x 4``."""
    title = re.compile(rf"\s*{letter}:\s*{shape[0]}\s*x\s*{shape[1]}\s*")
    below = dropwhile(lambda line: not title.fullmatch(line), lines)
    try:
        rows = [[float(cell) for cell in line.split()] for line in islice(below, 1, shape[0] + 1)]
        return np.array(rows, dtype=np.float64).reshape(shape)
    except ValueError as error:
        raise ModelError(
            f"{path}: '{letter}: {shape[0]} x {shape[1]}' and its numbers are needed, as many as "
            f"the lists above have ({error})"
        ) from error


def _places(
    signals: Sequence[Signal],
    wanted: Sequence[str] | None,
    default: Sequence[int],
    kind: str,
    path: str | Path,
) -> list[int]:
    """Return the places of names among signals."""
    if wanted is None:
        return list(default)
    names = [signal.name for signal in signals]
    for name in wanted:
        if name not in names:
            raise ModelError(
                f"{path}: {name} is no {kind}{did_you_mean(name, names)}; {kind}s are "
                f"{', '.join(names[:40])}{', ...' if len(names) > 40 else ''}"
            )
    return [names.index(name) for name in wanted]


def _chosen_inputs(
    columns: Sequence[Signal],
    inputs: Sequence[str] | None,
    disturbances: Sequence[str] | None,
    path: str | Path,
) -> tuple[list[int], list[int]]:
    """Return the places of what the law commands, and of what comes from outside."""

    def described(words: Sequence[str]) -> list[int]:
        return [k for k, signal in enumerate(columns) if any(w in signal[1] for w in words)]

    usual = described(COMMANDED) or (list(range(len(columns))) if len(columns) <= FEW else [])
    commanded = _places(columns, inputs, usual, "input", path)
    if not commanded:
        raise ModelError(
            f"{path}: none of its {len(columns)} inputs is collective pitch or generator torque; "
            "name those that the law commands (--input): "
            + (", ".join(signal.name for signal in columns[:40]) or "none")
        )
    outside = _places(columns, disturbances, described(FROM_OUTSIDE), "input", path)
    return commanded, [k for k in outside if k not in commanded]


def _residual(
    A: Floats, B: Floats, kept: Sequence[int], settled: Sequence[int], path: str | Path
) -> tuple[Floats, Floats]:
    """Return A and B of the kept states, with the others settled."""
    A11, B1 = A[np.ix_(kept, kept)], B[kept]
    if not settled:
        return A11, B1
    A12, A21 = A[np.ix_(kept, settled)], A[np.ix_(settled, kept)]
    A22, B2 = A[np.ix_(settled, settled)], B[settled]
    if max(np.linalg.eigvals(A22).real) >= 0:
        raise ModelError(
            f"{path}: the {len(settled)} states that are not kept do not settle by themselves "
            "(A22 has an eigenvalue without negative real part); keep more of them"
        )
    solved = np.linalg.solve(A22, np.hstack([A21, B2]))
    step = A12 @ solved
    return A11 - step[:, : len(kept)], B1 - step[:, len(kept) :]
