"""The matrices of a vertex model, checked once against each other and against their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

Names: TypeAlias = tuple[str, ...]

# What the rows and columns of each matrix count.
AXES = {
    "A": ("states", "states"),
    "B": ("states", "inputs"),
    "C": ("outputs", "states"),
    "D": ("outputs", "inputs"),
    "E": ("states", "disturbances"),
}
# The matrix and axis that say how many of each there are, and the letter of a default name.
COUNTED_IN = {
    "states": ("A", -1, "x"),
    "inputs": ("B", -1, "u"),
    "outputs": ("C", -2, "y"),
    "disturbances": ("E", -1, "w"),
}


def vertex_arrays(
    A: ArrayLike, others: Mapping[str, ArrayLike | None], labels: Mapping[str, Sequence[str] | None]
) -> tuple[dict[str, Floats], dict[str, Names]]:
    """Return the matrices as read-only (r, ., .) float64 copies, and the names of their axes.

    Parameters
    ----------
    A : (r, n, n).
    others : B, C, D, E, each (r, ., .), (., .) for the same in every vertex, or None for zero.
    labels : states, inputs, outputs, disturbances; None takes "x1 [-]", ...

    Raises
    ------
    ModelError : a shape that does not fit, an entry that is not finite, names that do not fit.
    """
    given = {"A": _square_stack(A, labels["states"])}
    for letter, value in others.items():
        if value is not None:
            given[letter] = finite_array(letter, value)
    names = {}
    for axis, (letter, along, symbol) in COUNTED_IN.items():
        size = given[letter].shape[along] if letter in given else 0
        names[axis] = _names(axis, labels[axis], letter, size, symbol)
    count = len(given["A"])
    arrays = {
        letter: _stack(
            letter, given.get(letter), count, names[rows], names[columns], (rows, columns)
        )
        for letter, (rows, columns) in AXES.items()
    }
    return arrays, names


def check_unique(axis: str, names: Sequence[str]) -> None:
    """Raise ModelError when a name occurs twice."""
    doubled = sorted({name for name in names if list(names).count(name) > 1})
    if doubled:
        raise ModelError(f"{axis}: {', '.join(doubled)} named more than once; names must differ")


def finite_array(letter: str, value: ArrayLike) -> Floats:
    """Return a stack of matrices, or one matrix.

    Raises
    ------
    ModelError : no array of real numbers, or an entry that is not finite; names the entry.
    """
    try:
        if np.iscomplexobj(np.asarray(value)):
            # numpy would drop the imaginary parts with no more than a warning.
            raise TypeError("complex entries")
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"{letter} cannot be read as an array of numbers ({error}); give nested lists of equal "
            "length or a numpy array"
        ) from error
    if not np.all(np.isfinite(array)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ModelError(f"{letter}{list(where)} is {array[where]}; every entry must be finite")
    if letter != "A" and array.ndim not in (2, 3):
        raise ModelError(
            f"{letter} has shape {array.shape}; (r, rows, columns) is needed, or (rows, columns) "
            "for the same in every vertex"
        )
    return array


def _square_stack(A: ArrayLike, states: Sequence[str] | None) -> Floats:
    if isinstance(A, (list, tuple)):
        _check_squares(A, states)
    array = finite_array("A", A)
    if array.ndim != 3 or 0 in array.shape:
        raise ModelError(
            f"A has shape {array.shape}; (r, n, n) is needed: r vertices of n states "
            "(for one vertex write [A])"
        )
    _check_squares(list(array), states)
    return array


def _check_squares(A: Sequence[ArrayLike], states: Sequence[str] | None) -> None:
    try:
        shapes = [np.shape(vertex) for vertex in A]
    except ValueError:
        # Rows of unequal length: the reader says so.
        return
    size = len(states) if states is not None else min((s[0] for s in shapes if s), default=0)
    for index, shape in enumerate(shapes, start=1):
        if len(shape) == 2 and shape != (size, size):
            known = f"named ({', '.join(states)})" if states is not None else "in its first rows"
            raise ModelError(
                f"vertex {index} of {len(shapes)}: A has shape {shape}, but {size} states are "
                f"{known}, so A must be ({size}, {size})."
            )


def _names(axis: str, given: Sequence[str] | None, letter: str, size: int, symbol: str) -> Names:
    if given is None:
        return tuple(f"{symbol}{k} [-]" for k in range(1, size + 1))
    if isinstance(given, str):
        raise ModelError(f"{axis} is the text {given!r}; a list of names is needed")
    names = tuple(given)
    if len(names) != size:
        raise ModelError(
            f"{len(names)} {axis} are named ({', '.join(names)}), but {letter} has {size}; "
            f"name each, or change {letter}"
        )
    check_unique(axis, names)
    return names


def _stack(
    letter: str,
    given: Floats | None,
    count: int,
    rows: Names,
    columns: Names,
    axes: tuple[str, str],
) -> Floats:
    shape = (count, len(rows), len(columns))
    if given is None:
        array = np.zeros(shape)
    elif given.shape in (shape, shape[1:]):
        array = np.array(np.broadcast_to(given, shape))
    else:
        raise ModelError(
            f"{letter} has shape {given.shape}, but there are {count} vertices, {len(rows)} "
            f"{axes[0]} and {len(columns)} {axes[1]}, so {letter} must be {shape} "
            f"or {shape[1:]}."
        )
    array.flags.writeable = False
    return array
