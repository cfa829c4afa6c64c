"""A Takagi-Sugeno model from a MAT-file: the vertices that somebody has in MATLAB or Octave."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import LETTERS, TSModel


def load_ts_model(path: str | Path) -> TSModel:
    """Return the model with the vertices of a MAT-file, without premises: a polytope.

    The file has ``A`` (n, n, r), and as it needs ``B`` (n, m, r), ``C`` (p, n, r), ``D`` (p, m, r),
    ``E`` (n, q, r), and ``sample_time`` [s] for discrete time; rules are the last axis, and a
    matrix without it is the same in every rule.  A cell array with one matrix a rule, ``A1``,
    ``A2``, ..., and a struct array with one member a rule stand for the last axis.  They are
    variables of the file, or members of its only struct with an A, such as ``takagi``, which
    ``takagi export --to mat`` writes; ``Ts`` of a struct is its sample time, 0 for none.

    Raises
    ------
    ModelError : no MAT-file of version 4 to 7.2, no A, shapes that do not fit, a number that is not
        finite.
    """
    content = mat_content(path)
    members = _members(content, str(path))
    matrices = _matrices(members, str(path))
    step = _sample_time(members, str(path))
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


def mat_content(path: Path | str) -> Mapping[str, Any]:
    """Return the members of a MAT-file.

    Raises
    ------
    ModelError : no MAT-file of version 4 to 7.2.
    """
    if not Path(path).is_file():
        raise ModelError(f"{path}: cannot be read (no such file); check the path")
    # Imported here: most models are files of takagi.
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        # Axes of length one are kept: without them a shared B (n, m) is not told from (n, 1, r).
        content: Mapping[str, Any] = loadmat(path)
    except NotImplementedError as error:
        raise ModelError(
            f"{path}: a MAT-file of version 7.3 cannot be read; save it with save('-v7', ...)"
        ) from error
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (ValueError, TypeError, MatReadError) as error:
        raise ModelError(f"{path}: no MAT-file ({error})") from error
    return content


def _members(content: Mapping[str, Any], path: str) -> Mapping[str, Any]:
    """Return the variables of a file, or the members of its struct; rules are the last axis."""
    structs = {k: v for k, v in content.items() if getattr(v, "dtype", np.dtype(int)).names}
    structs_with_A = [k for k, v in structs.items() if "A" in _rules_joined(_fields(v), path)]
    joined = _rules_joined(content, path)
    if "takagi" in structs_with_A or ("A" not in joined and len(structs_with_A) == 1):
        return _rules_joined(
            _fields(structs["takagi" if "takagi" in structs_with_A else structs_with_A[0]]), path
        )
    if "A" in joined and "takagi" not in content:
        # Beside matrices Ts may be that of anything.
        return {k: v for k, v in joined.items() if k != "Ts"}
    names = ", ".join(k for k in content if not k.startswith("__")) or "nothing that can be read"
    raise ModelError(
        f"{path}: has no A (n, n, r), the vertices of x' = A x + B u; it has {names}; write "
        "A = cat(3, sys1.A, sys2.A); B = cat(3, sys1.B, sys2.B); save('model.mat', 'A', 'B', '-v7')"
    )


def _fields(struct: Any) -> Mapping[str, Any]:
    """Return the members of a struct, and of a struct array cells with one entry a rule."""
    names = struct.dtype.names
    if struct.size == 1:
        return {name: struct[name].item() for name in names}
    return {name: struct[name].ravel() for name in names}


def _rules_joined(members: Mapping[str, Any], path: str) -> dict[str, Any]:
    """Return the members with cells, and numbered matrices A1, A2, ..., along the last axis."""
    joined = dict(members)
    for name in LETTERS:
        numbers = sorted(int(k[1:]) for k in members if k[0] == name and k[1:].isdigit())
        if numbers:
            if numbers != list(range(1, len(numbers) + 1)) or name in members:
                names_given = ", ".join(
                    [name] * (name in members) + [f"{name}{k}" for k in numbers]
                )
                raise ModelError(
                    f"{path}: has {names_given}; {name}1, {name}2, ... without gaps are needed, or "
                    f"{name} alone"
                )
            joined[name] = _stacked([members[f"{name}{k}"] for k in numbers], name, path)
        elif _is_cells(members.get(name)):
            joined[name] = _stacked(list(members[name].ravel()), name, path)
    return joined


def _is_cells(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind == "O"


def _stacked(rule_matrices: list[Any], name: str, path: str) -> Floats:
    matrices = [
        _real(rule_matrix, f"{name}, rule {k}", path)
        for k, rule_matrix in enumerate(rule_matrices, start=1)
    ]
    shapes = [matrix.shape for matrix in matrices]
    if len(set(shapes)) != 1 or len(shapes[0]) != 2:
        raise ModelError(
            f"{path}: {name} has shapes {', '.join(map(str, shapes))}; one matrix a rule, all of "
            "one shape, is needed"
        )
    return np.stack(matrices, axis=2)


def _sample_time(members: Mapping[str, Any], path: str) -> float | None:
    name = "sample_time" if "sample_time" in members else "Ts"
    stated = members.get(name, np.zeros(0))
    cells = stated.ravel() if _is_cells(stated) else [stated]
    times = np.unique(np.concatenate([_real(cell, name, path).ravel() for cell in cells]))
    if times.size > 1 or (times.size and name == "Ts" and times[0] < 0):
        raise ModelError(
            f"{path}: {name} has {times.size} numbers ({', '.join(map(str, times))}); one in s is "
            "needed, or none"
        )
    return float(times[0]) if times.size and (times[0] or name == "sample_time") else None


def _real(value: Any, name: str, path: str) -> Floats:
    """Return real numbers; a sparse matrix becomes a full one."""
    full = np.asarray(value.toarray() if hasattr(value, "toarray") else value)
    if full.dtype.kind not in "fiub":
        raise ModelError(f"{path}: {name} is of type {full.dtype}; real numbers are needed")
    return full.astype(np.float64)


def _matrices(members: Mapping[str, Any], path: str) -> dict[str, Floats]:
    """Return the matrices as (r, rows, columns), or (rows, columns) for the same in every rule."""
    matrices = {k: _real(members[k], k, path) for k in LETTERS if k in members}
    A = matrices["A"]
    if A.ndim not in (2, 3) or A.shape[1] != A.shape[0] or A.shape[0] == 0:
        raise ModelError(f"{path}: A has shape {A.shape}; (n, n, r) is needed")
    matrices["A"] = A if A.ndim == 3 else A[:, :, None]
    return {
        k: np.ascontiguousarray(np.moveaxis(value, 2, 0)) if value.ndim == 3 else value
        for k, value in matrices.items()
    }
