"""Vertex matrices stored by entry: each entry at the corners of the few premises it depends on.

The matrices of a vertex model in either way of storing them: stacks, or entry by entry.
"""

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
from takagi.models.ts.vertex_arrays import vertex_arrays

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
            wanted = tuple(self.corners[axis] for axis in axes)
            if values.shape != wanted or sorted(set(axes)) != list(axes):
                raise ModelError(
                    f"entry [{row}, {column}] has values of shape {values.shape} for premises "
                    f"{axes}; {wanted} is needed, each premise once and in order"
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
        whole = np.zeros((*(self.corners[axis] for axis in varying), self.rows, self.columns))
        for (row, column), (axes, values) in self.entries.items():
            shape = [self.corners[axis] if axis in axes else 1 for axis in varying]
            whole[..., row, column] = values.reshape(shape)
        found = whole.reshape(self.count, self.rows, self.columns)
        found.flags.writeable = False
        return found

    def first(self) -> Floats:
        """Return the (1, rows, columns) stack of the first vertex alone."""
        found = np.zeros((1, self.rows, self.columns))
        for (row, column), (_, values) in self.entries.items():
            found[0, row, column] = values.flat[0]
        return found


def stored_matrices(
    given: Mapping[str, ArrayLike | VertexProduct | None],
    labels: Mapping[str, Sequence[str] | None],
) -> tuple[Mapping[str, Floats], Mapping[str, tuple[str, ...]], Mapping[str, VertexProduct], int]:
    """Return arrays, names, products and the number of vertices; arrays or products are empty.

    Raises
    ------
    ModelError : as ``vertex_arrays``, or matrices that are stored in two ways.
    """
    products = {k: value for k, value in given.items() if isinstance(value, VertexProduct)}
    if not products:
        plain: dict[str, Any] = {k: value for k, value in given.items() if k != "A"}
        arrays, names = vertex_arrays(cast("ArrayLike", given["A"]), plain, labels)
        return arrays, names, MappingProxyType({}), len(arrays["A"])
    mixed = [k for k, value in given.items() if value is not None and k not in products]
    if mixed or "A" not in products:
        raise ModelError(
            f"{', '.join(products)} given as VertexProduct, {', '.join(mixed) or 'no A'} not; "
            "give all matrices in one way"
        )
    # One vertex tells whether shapes and names fit; the others are made when they are needed.
    first, names = vertex_arrays(
        products["A"].first(),
        {k: products[k].first() if k in products else None for k in given if k != "A"},
        labels,
    )
    corners = products["A"].corners
    whole = {
        k: products.get(k) or VertexProduct(corners, first[k].shape[1], first[k].shape[2], {})
        for k in given
    }
    return {}, names, MappingProxyType(whole), products["A"].count


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
