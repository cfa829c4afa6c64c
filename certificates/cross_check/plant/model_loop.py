"""The loop of a model with gains, for both kinds of model."""

from __future__ import annotations

from typing import Any

from takagi.certificates.cross_check.kernel.reading import Refusal, entry
from takagi.certificates.cross_check.loop.loop import VertexLoop, close, vertices
from takagi.certificates.cross_check.plant.plant import plant_loop


def read_loop(model: Any, gains: Any) -> VertexLoop:
    """Return the loop of a certificate's model and gains.

    Raises
    ------
    Refusal : another kind of model, shapes or names that do not fit.
    """
    kind = entry(model, "kind")
    if kind == "takagi-sugeno":
        loop = vertices(model)
    elif kind == "plant":
        loop = plant_loop(model)
    else:
        raise Refusal(f"a model of kind {kind!a} has no vertices")
    if gains is None:
        return loop
    closed = close(loop, gains)
    if "observer" not in gains:
        return closed
    from takagi.certificates.cross_check.loop.observed import with_observer

    # The slopes are written as the embedding is, with premises of their own.
    slopes = plant_loop(with_slopes(model)) if kind == "plant" and "slopes" in model else None
    return with_observer(closed, model, gains, slopes)


def with_slopes(model: Any) -> Any:
    """Return the model with its slopes in the place of its embedding.

    Raises
    ------
    Refusal : they are no object.
    """
    slopes = entry(model, "slopes")
    if not isinstance(slopes, dict):
        raise Refusal("slopes: an object is needed")
    return {**model, "embedding": {**slopes, "form": "secant"}}
