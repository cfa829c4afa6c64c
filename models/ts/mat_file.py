"""A Takagi-Sugeno model from a MAT-file: the vertices that somebody has in MATLAB or Octave."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel


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
        # Axes of length one are kept: without them a shared B (n, m) is not told from (n, 1, r).
        content: Mapping[str, Any] = loadmat(path)
    except NotImplementedError as error:
        raise ModelError(
            f"{path}: a MAT-file of version 7.3 cannot be read; save it with save('-v7', ...)"
        ) from error
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (ValueError, TypeError) as error:
        raise ModelError(f"{path}: no MAT-file ({error})") from error
    found = _members(content.get("takagi", content))
    if "A" not in found:
        raise ModelError(f"{path}: has no A (n, n, r), the vertices of x' = A x + B u")
    matrices = _matrices(found, str(path))
    time = _real(found.get("sample_time", np.zeros(0)), "sample_time", str(path)).ravel()
    if time.size > 1:
        raise ModelError(f"{path}: sample_time has {time.size} numbers; one is needed, or none")
    step = float(time[0]) if time.size else None
    try:
        return TSModel(
            matrices["A"],
            matrices.get("B"),
            C=matrices.get("C"),
            D=matrices.get("D"),
            E=matrices.get("E"),
            sample_time=step,
        )
    except ModelError as error:
        raise ModelError(
            f"{path}: {error} (the rules are the first axis here, and the last one in the file)"
        ) from error


def _members(found: Any) -> Mapping[str, Any]:
    """Return the variables of a file, or the members of its struct; nothing of anything else."""
    if isinstance(found, Mapping):
        return found
    if found.dtype.names is None or found.size != 1:
        return {}
    return {name: found[name].item() for name in found.dtype.names}


def _real(value: Any, name: str, path: str) -> Floats:
    """Return real numbers; a sparse matrix becomes a full one."""
    full = np.asarray(value.toarray() if hasattr(value, "toarray") else value)
    if full.dtype.kind not in "fiub":
        raise ModelError(f"{path}: {name} is of type {full.dtype}; real numbers are needed")
    return full.astype(np.float64)


def _matrices(found: Mapping[str, Any], path: str) -> dict[str, Floats]:
    """Return the matrices as (r, rows, columns), or (rows, columns) for the same in every rule."""
    made = {k: _real(found[k], k, path) for k in ("A", "B", "C", "D", "E") if k in found}
    A = made["A"]
    if A.ndim not in (2, 3) or A.shape[1] != A.shape[0] or A.shape[0] == 0:
        raise ModelError(f"{path}: A has shape {A.shape}; (n, n, r) is needed")
    made["A"] = A if A.ndim == 3 else A[:, :, None]
    return {
        k: np.ascontiguousarray(np.moveaxis(value, 2, 0)) if value.ndim == 3 else value
        for k, value in made.items()
    }
