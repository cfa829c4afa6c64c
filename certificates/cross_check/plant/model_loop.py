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
    return loop if gains is None else close(loop, gains)
