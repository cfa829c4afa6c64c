"""A Takagi-Sugeno model from a MAT-file: the vertices that somebody has in MATLAB or Octave."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel

__all__ = ["load_ts_model"]

# Letter -> which of (n, m, p, q) its rows and columns are.
SHAPES = {"B": ("n", "m"), "C": ("p", "n"), "D": ("p", "m"), "E": ("n", "q")}


def load_ts_model(path: str | Path) -> TSModel:
    """Return the model with the vertices of a MAT-file, without premises: a polytope.

    The file has ``A`` (n, n, r), and as it needs ``B`` (n, m, r), ``C`` (p, n, r), ``D`` (p, m, r),
    ``E`` (n, q, r), and ``sample_time`` [s] for discrete time; rules are the last axis, and a
    matrix without it is the same in every rule.  They are variables of the file, or members of a
    struct ``takagi``, as ``takagi export --to mat`` writes it.

    Raises
    ------
    ModelError : no MAT-file of version 4 to 7.2, no A, shapes that do not fit, a number that is not
        finite.
    """
    # Imported here: most models are files of takagi.
    from scipy.io import loadmat

    try:
        content: Mapping[str, Any] = loadmat(path, simplify_cells=True)
    except NotImplementedError as error:
        raise ModelError(
            f"{path}: a MAT-file of version 7.3 cannot be read; save it with save('-v7', ...)"
        ) from error
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (ValueError, TypeError) as error:
        raise ModelError(f"{path}: no MAT-file ({error})") from error
    found = content.get("takagi", content)
    if not isinstance(found, Mapping) or "A" not in found:
        raise ModelError(f"{path}: has no A (n, n, r), the vertices of x' = A x + B u")
    matrices = _matrices(found, str(path))
    time = np.atleast_1d(np.asarray(found.get("sample_time", []), dtype=np.float64))
    step = float(time[0]) if time.size else None
    return TSModel(
        matrices["A"],
        matrices.get("B"),
        C=matrices.get("C"),
        D=matrices.get("D"),
        E=matrices.get("E"),
        sample_time=step,
    )


def _matrices(found: Mapping[str, Any], path: str) -> dict[str, Floats]:
    """Return the matrices as (r, rows, columns); scipy drops axes of length one."""
    A = np.asarray(found["A"], dtype=np.float64)
    if A.ndim == 0:
        A = A.reshape(1, 1)
    n = A.shape[0]
    if A.ndim == 1:
        # One state: the axis is that of the rules.
        n, A = 1, A.reshape(1, 1, -1)
    if A.ndim not in (2, 3) or A.shape[1] != n:
        raise ModelError(f"{path}: A has shape {A.shape}; (n, n, r) is needed")
    A = A if A.ndim == 3 else A[:, :, None]
    r = A.shape[2]
    sizes: dict[str, int] = {"n": n}
    made = {"A": A}
    for letter, (rows, columns) in SHAPES.items():
        if letter not in found:
            continue
        value = np.asarray(found[letter], dtype=np.float64)
        made[letter] = _shaped(value, (sizes.get(rows), sizes.get(columns)), r, letter, path)
        sizes |= {rows: made[letter].shape[0], columns: made[letter].shape[1]}
    for letter, value in made.items():
        if not np.all(np.isfinite(value)):
            raise ModelError(f"{path}: {letter} has a number that is not finite")
    return {
        letter: np.ascontiguousarray(
            np.moveaxis(np.broadcast_to(value, (*value.shape[:2], r)), 2, 0)
        )
        for letter, value in made.items()
    }


def _shaped(
    value: Floats, sizes: tuple[int | None, int | None], r: int, letter: str, path: str
) -> Floats:
    """Return (rows, columns, r) or (rows, columns, 1) from what is left of such an array."""
    rows, columns = sizes
    for last in (r, 1):
        for height in (rows,) if rows is not None else (1, value.size // last or 1):
            width = columns if columns is not None else value.size // (last * (height or 1))
            shape = (height or 1, width, last)
            if value.size == np.prod(shape) and [k for k in shape if k != 1] == [
                k for k in value.shape if k != 1
            ]:
                return value.reshape(shape)
    raise ModelError(
        f"{path}: {letter} has shape {value.shape}; with A of {r} rules and {rows or 'p'} rows "
        f"({rows or 'p'}, {columns or 'm'}, {r}) is needed, or without the rules"
    )
