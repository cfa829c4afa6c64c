"""Vertex matrices stored by entry: each entry at the corners of the few premises it depends on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

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
