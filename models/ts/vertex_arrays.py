"""The matrices of a vertex model, stored whole or entry by entry, checked once with their names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.premise import Premise

Entry: TypeAlias = tuple[tuple[int, ...], Floats]


@dataclass(frozen=True, slots=True, eq=False)
class VertexProduct:
    """The stack M[i] of (rows, columns) matrices over all combinations i of premise corners.

    A model of k premises has up to 2^k vertices, but an entry of its matrices depends on few of
    them.  The stack is made when it is asked for.

    Attributes
    ----------
    corners : number of corners (1 or 2) of each premise; the last changes first, as in a
        ``TSModel``.
    rows, columns : of one matrix.
    entries : (row, column) -> (premises, values): the entry's values have one axis for each of
        these premises, in rising order.  Entries that are left out are zero.

    Raises
    ------
    ModelError : values whose shape does not fit the corners, or that are not finite.
    """

    corners: tuple[int, ...]
    rows: int
    columns: int
    entries: Mapping[tuple[int, int], Entry]

    def __post_init__(self) -> None:
        for (row, column), (axes, values) in self.entries.items():
            shape = tuple(self.corners[axis] for axis in axes)
            if values.shape != shape or sorted(set(axes)) != list(axes):
                raise ModelError(
                    f"entry [{row}, {column}] has values of shape {values.shape} for premises "
                    f"{axes}; {shape} is needed, each premise once and in order"
                )
            if not np.all(np.isfinite(values)):
                raise ModelError(
                    f"entry [{row}, {column}] is not finite at every corner; every entry must be"
                )
        object.__setattr__(self, "entries", MappingProxyType(dict(self.entries)))

    @property
    def count(self) -> int:
        """Return the number of vertices."""
        return math.prod(self.corners)

    def stack(self) -> Floats:
        """Return the read-only (vertices, rows, columns) array."""
        varying = [axis for axis, size in enumerate(self.corners) if size > 1]
        all_corners = np.zeros((*(self.corners[axis] for axis in varying), self.rows, self.columns))
        for (row, column), (axes, values) in self.entries.items():
            shape = [self.corners[axis] if axis in axes else 1 for axis in varying]
            all_corners[..., row, column] = values.reshape(shape)
        stacked = all_corners.reshape(self.count, self.rows, self.columns)
        stacked.flags.writeable = False
        return stacked

    def first(self) -> Floats:
        """Return the (1, rows, columns) stack of the first vertex alone."""
        stacked = np.zeros((1, self.rows, self.columns))
        for (row, column), (_, values) in self.entries.items():
            stacked[0, row, column] = values.flat[0]
        return stacked


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
    A: ArrayLike,
    further: Mapping[str, ArrayLike | None],
    labels: Mapping[str, Sequence[str] | None],
) -> tuple[dict[str, Floats], dict[str, Names]]:
    """Return the matrices as read-only (r, ., .) float64 copies, and the names of their axes.

    Parameters
    ----------
    A : (r, n, n).
    further : B, C, D, E, each (r, ., .), (., .) for the same in every vertex, or None for zero.
    labels : states, inputs, outputs, disturbances; None takes "x1 [-]", ...

    Raises
    ------
    ModelError : a shape that does not fit, an entry that is not finite, names that do not fit.
    """
    arrays_given = {"A": _square_stack(A, labels["states"])}
    for letter, value in further.items():
        if value is not None:
            arrays_given[letter] = finite_array(letter, value)
    names = {}
    for axis, (letter, along, symbol) in COUNTED_IN.items():
        size = arrays_given[letter].shape[along] if letter in arrays_given else 0
        names[axis] = _names(axis, labels[axis], letter, size, symbol)
    count = len(arrays_given["A"])
    arrays = {
        letter: _stack(
            letter, arrays_given.get(letter), count, names[rows], names[columns], (rows, columns)
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
            name_text = (
                f"named ({', '.join(states)})" if states is not None else "in its first rows"
            )
            raise ModelError(
                f"vertex {index} of {len(shapes)}: A has shape {shape}, but {size} states are "
                f"{name_text}, so A must be ({size}, {size})."
            )


def _names(axis: str, labels: Sequence[str] | None, letter: str, size: int, symbol: str) -> Names:
    if labels is None:
        return tuple(f"{symbol}{k} [-]" for k in range(1, size + 1))
    if isinstance(labels, str):
        raise ModelError(f"{axis} is the text {labels!r}; a list of names is needed")
    names = tuple(labels)
    if len(names) != size:
        raise ModelError(
            f"{len(names)} {axis} are named ({', '.join(names)}), but {letter} has {size}; "
            f"name each, or change {letter}"
        )
    check_unique(axis, names)
    return names


def _stack(
    letter: str,
    matrix: Floats | None,
    count: int,
    rows: Names,
    columns: Names,
    axes: tuple[str, str],
) -> Floats:
    shape = (count, len(rows), len(columns))
    if matrix is None:
        array = np.zeros(shape)
    elif matrix.shape in (shape, shape[1:]):
        array = np.array(np.broadcast_to(matrix, shape))
    else:
        raise ModelError(
            f"{letter} has shape {matrix.shape}, but there are {count} vertices, {len(rows)} "
            f"{axes[0]} and {len(columns)} {axes[1]}, so {letter} must be {shape} "
            f"or {shape[1:]}."
        )
    array.flags.writeable = False
    return array


def matrices_of_systems(
    matrices: Mapping[str, Any], sample_time: float | None
) -> tuple[Mapping[str, Any], float | None]:
    """Return the matrices, and the sample time, of systems that were given as A; else as given.

    Raises
    ------
    ModelError : transfer functions, matrices beside systems, sample times that differ or are not
        known.
    """
    A = matrices["A"]
    systems = list(A) if isinstance(A, (list, tuple)) else [A]
    dynamic = [hasattr(system, "A") and hasattr(system, "D") for system in systems]
    if not any(dynamic):
        if any(hasattr(system, "num") for system in systems):
            raise ModelError(
                "A holds transfer functions, which have no states of their own; give state spaces "
                "in the same states, or their matrices A (r, n, n), B, C, D"
            )
        return matrices, sample_time
    beside = [letter for letter in "BCD" if matrices[letter] is not None]
    if beside or not all(dynamic):
        raise ModelError(
            f"A holds state spaces{' beside something else' if not all(dynamic) else ''}"
            f"{' and ' + ', '.join(beside) + ' given' if beside else ''}; give systems alone, "
            "which have their own B, C, D, or matrices alone"
        )
    times = {getattr(system, "dt", None) or None for system in systems}
    times |= set() if sample_time is None else {float(sample_time)}
    if len(times) != 1 or True in {time is True for time in times}:
        raise ModelError(
            f"sample times {', '.join(map(str, times))} are given; one for all systems is needed, "
            "a number of seconds (True means an unknown one)"
        )
    stacks = {
        letter: [np.asarray(getattr(system, letter)) for system in systems] for letter in "ABCD"
    }
    for letter, stack in stacks.items():
        shapes = [matrix.shape for matrix in stack]
        if len(set(shapes)) > 1:
            raise ModelError(
                f"the systems' {letter} have shapes {', '.join(map(str, shapes))}; the same "
                "states, inputs and outputs are needed in every one"
            )
    return {**matrices, **stacks}, times.pop()


def stored_matrices(
    matrices: Mapping[str, ArrayLike | VertexProduct | None],
    labels: Mapping[str, Sequence[str] | None],
) -> tuple[Mapping[str, Floats], Mapping[str, tuple[str, ...]], Mapping[str, VertexProduct], int]:
    """Return arrays, names, products and the number of vertices; arrays or products are empty.

    Raises
    ------
    ModelError : as ``vertex_arrays``, or matrices that are stored in two ways.
    """
    products = {k: value for k, value in matrices.items() if isinstance(value, VertexProduct)}
    if not products:
        plain: dict[str, Any] = {k: value for k, value in matrices.items() if k != "A"}
        arrays, names = vertex_arrays(cast("ArrayLike", matrices["A"]), plain, labels)
        return arrays, names, MappingProxyType({}), len(arrays["A"])
    mixed = [k for k, value in matrices.items() if value is not None and k not in products]
    if mixed or "A" not in products:
        raise ModelError(
            f"{', '.join(products)} given as VertexProduct, {', '.join(mixed) or 'no A'} not; "
            "give all matrices in one way"
        )
    # One vertex tells whether shapes and names fit; the others are made when they are needed.
    first, names = vertex_arrays(
        products["A"].first(),
        {k: products[k].first() if k in products else None for k in matrices if k != "A"},
        labels,
    )
    corners = products["A"].corners
    full_products = {
        k: products.get(k) or VertexProduct(corners, first[k].shape[1], first[k].shape[2], {})
        for k in matrices
    }
    return {}, names, MappingProxyType(full_products), products["A"].count


def check_corners(
    products: Mapping[str, VertexProduct],
    premises: tuple[Premise, ...],
    rules: Sequence[Sequence[int]] | None,
) -> None:
    """Raise ModelError unless the products are stored over the corners of the premises."""
    corners = tuple(len(premise.corners) for premise in premises)
    for letter, matrices in products.items():
        if matrices.corners != corners:
            raise ModelError(
                f"{letter} is stored over {matrices.corners} corners, but the premises have "
                f"{corners}; give the same premises"
            )
    if products and rules is not None:
        raise ModelError("a VertexProduct has its rules in order; leave rules out")
