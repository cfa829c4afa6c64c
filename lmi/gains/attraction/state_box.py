"""Where an ellipsoid may lie, and what it is measured by: checked on entry."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import positive_vector
from takagi.lmi.condition.term import Array
from takagi.lmi.gains.requirements.limits import limits_of
from takagi.models.errors import ModelError, did_you_mean

MEASURES = ("volume", "trace")


def state_box_of(
    model: object, given: ArrayLike | None, n: int, input_limit: Array | None
) -> Array | None:
    """Return (n,) half-widths, inf for none: those given, within the model's own box.

    Raises
    ------
    ModelError : shapes, numbers, a model whose domain is not a box, a box of the model without 0
        inside, or with the range of an input that no limit keeps.
    """
    if getattr(model, "domain", None) is not None:
        raise ModelError(
            "the model equals its plant on a band or a union of cells only, and no box inside it "
            "is known; derive the model on a box (sector_model without domain)"
        )
    limits = limits_of(n, 1, input_limit=None, initial_box=None, state_box=given, gain_bound=None)
    own = np.full(n, np.inf)
    inputs = tuple(getattr(model, "inputs", ()))
    for variable, (lower, upper) in getattr(model, "box", {}).items():
        half = min(-float(lower), float(upper))
        if variable in getattr(model, "states", ()):
            if half <= 0:
                raise ModelError(
                    f"the model's box of {variable} is {float(lower):g} ... {float(upper):g}; an "
                    "ellipsoid about 0 needs 0 inside it"
                )
            own[model.states.index(variable)] = half  # type: ignore[attr-defined]
        elif variable in inputs and (
            input_limit is None or input_limit[inputs.index(variable)] > half
        ):
            raise ModelError(
                f"the model equals its plant only for |{variable}| <= {half:g}; give an "
                "input_limit within that"
            )
    box = own if limits.states is None else np.minimum(own, limits.states)
    return box if np.isfinite(box).any() else None


def measure_of(measure: str | ArrayLike, n: int) -> str | Array:
    """Return "volume", "trace" or points, (k, n); half-widths (n,) become corners of the box.

    Raises
    ------
    ModelError : an unknown name, a shape, entries that are not finite, points that are all 0.
    """
    if isinstance(measure, str):
        if measure not in MEASURES:
            raise ModelError(
                f"measure {measure!r} is not known; there are volume, trace, or points (k, {n})"
                + did_you_mean(measure, list(MEASURES))
            )
        return measure
    try:
        points = np.asarray(measure, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"measure cannot be read as points ({error}); give (k, {n})") from error
    if points.ndim == 1:
        box = positive_vector("measure", points, n)
        limits = limits_of(n, 1, input_limit=None, initial_box=box, state_box=None, gain_bound=None)
        assert limits.initial is not None
        return limits.initial
    if points.ndim != 2 or points.shape[1] != n or not np.isfinite(points).all():
        raise ModelError(
            f"measure has shape {points.shape}; points (k, {n}), half-widths ({n},), or a name "
            "are needed, all finite"
        )
    if not points.any():
        raise ModelError("the points of the measure are all 0, so any multiple of them is in")
    return points
