"""Rules of a sector model: every combination of the corners of its premises, once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Indices, ShortRepr
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ProductRules(ShortRepr):
    """h_i = prod_c w_(p_c, corner_ic): rule i's corner of each premise; p_c is that of column c.

    The weights of a premise are nonnegative and sum to 1; so the memberships of the rules do too.

    Attributes
    ----------
    corners : (rules, columns), from 0; every combination of the columns' corners once.
    premises : name of each column's premise; one that is named twice is a factor twice.  Empty
        names them "z1", "z2", ...
    """

    corners: Indices
    premises: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        corners = np.asarray(self.corners)
        if corners.ndim != 2 or not len(corners) or corners.dtype.kind not in "iu":
            raise ModelError(
                f"corners have shape {corners.shape} and type {corners.dtype}; integers "
                "(rules, columns) are needed, one column a premise"
            )
        names = tuple(self.premises) or tuple(f"z{c + 1}" for c in range(corners.shape[1]))
        if len(names) != corners.shape[1]:
            raise ModelError(
                f"{len(names)} premises ({', '.join(names)}) for {corners.shape[1]} columns of "
                "corners; name one for each"
            )
        object.__setattr__(self, "corners", corners.astype(np.intp))
        object.__setattr__(self, "premises", names)
        self._check_complete()

    def _check_complete(self) -> None:
        low = int(self.corners.min()) if self.corners.size else 0
        different = len(np.unique(self.corners, axis=0)) if self.corners.shape[1] else 1
        combinations = prod(int(side) for side in self.corners.max(axis=0) + 1)
        if low < 0 or not different == combinations == len(self.corners):
            raise ModelError(
                f"corners: {len(self.corners)} rules, {different} of them different, least index "
                f"{low}, for {combinations} combinations; every combination is needed once, from "
                "0, or the memberships do not sum to 1"
            )

    @property
    def rules(self) -> int:
        """Return the number of rules."""
        return len(self.corners)

    @property
    def sizes(self) -> Mapping[str, int]:
        """Return premise -> its number of corners."""
        corner_counts = self.corners.max(axis=0, initial=0) + 1
        return {name: int(count) for name, count in zip(self.premises, corner_counts, strict=True)}


# A plain array of corners has no names: its premises are named after its columns.
Corners: TypeAlias = ProductRules | Indices


class HasPremises(Protocol):
    """The part of a model that is read here: its premises by name, and the corners of each rule."""

    @property
    def premises(self) -> tuple[_Named, ...]: ...

    @property
    def rules(self) -> tuple[tuple[int, ...], ...]: ...


class _Named(Protocol):
    @property
    def name(self) -> str: ...


def product_rules(source: HasPremises | Corners | ArrayLike) -> ProductRules:
    """Return the rules of a model with premises, or of an array of corners (rules, premises).

    Raises
    ------
    ModelError : a model without premises; combinations of corners missing or twice.
    """
    if isinstance(source, ProductRules):
        return source
    premises = getattr(source, "premises", None)
    if premises is None:
        return ProductRules(np.asarray(source))
    if not premises:
        raise ModelError(
            "the model has no premises, so its memberships are not known to be products; give "
            "premises, or the corners as an array (rules, premises)"
        )
    rules = np.array(getattr(source, "rules"), dtype=np.intp)  # noqa: B009
    return ProductRules(rules, tuple(premise.name for premise in premises))
