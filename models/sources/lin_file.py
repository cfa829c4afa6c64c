r"""A linear plant from a ``.lin`` file of OpenFAST: A, B, C, D about one operating point.

States of which the others are kept settle at once where the file has more states than are wanted:
with x1 kept and 0 = A21 x1 + A22 x2 + B2 u,

    A = A11 - A12 A22^-1 A21,   B = B1 - A12 A22^-1 B2,

which has the file's gain at rest and is an approximation elsewhere.  The rotor's angle has no rest;
it and its column are left out.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import dropwhile, islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.library import read_text
from takagi.models.plant.plant import Plant
from takagi.models.sources.linear import from_arrays

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
