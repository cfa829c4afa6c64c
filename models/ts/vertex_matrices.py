"""The matrices of a vertex model in either way of storing them: stacks, or entry by entry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, cast

from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.premise import Premise
from takagi.models.ts.vertex_arrays import vertex_arrays
from takagi.models.ts.vertex_product import VertexProduct


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
