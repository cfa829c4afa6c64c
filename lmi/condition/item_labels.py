"""Names of an LMI's items, made on demand: an LMI may have thousands, and few names are read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import overload


@dataclass(frozen=True, slots=True, eq=False)
class Labels(Sequence[str]):
    """of(0), ..., of(size - 1) as a sequence.

    Attributes
    ----------
    size : how many.
    of : the name of item k, k = 0 ... size - 1.
    """

    size: int
    of: Callable[[int], str]

    def __len__(self) -> int:
        return self.size

    @overload
    def __getitem__(self, item: int) -> str: ...
    @overload
    def __getitem__(self, item: slice) -> tuple[str, ...]: ...
    def __getitem__(self, item: int | slice) -> str | tuple[str, ...]:
        if isinstance(item, slice):
            return tuple(self.of(k) for k in range(*item.indices(self.size)))
        # A range handles negative indices, and raises IndexError for those out of range.
        return self.of(range(self.size)[item])
