"""The channel from a disturbance to an output that a request is about, and its floats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kinds.disturbance_channel import disturbance_channels
from takagi.certificates.document.model_data import as_read, floats
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

Path: TypeAlias = tuple[Floats, Floats, Floats, Floats]
Output: TypeAlias = Sequence[ArrayLike | None]
"""(C, D, F) of y = C x + D u + F w, each (r, ., .) or (., .); D and F may be None or left out."""
ENTRANCES = ("disturbances", "inputs")


def channel_evidence(
    loop: ClaimedLoop,
    disturbance: str | None,
    output: Output | None,
    entering: Sequence[int] | None = None,
) -> dict[str, Any]:
    """Return what the claim states about the channel.

    Parameters
    ----------
    disturbance : "disturbances" (E), "inputs" (w is added to u); None takes the first
        that the model has.
    output : see ``Output``; None takes the model's.
    entering : numbers of the model's disturbances, the others at rest; None takes all.

    Raises
    ------
    ModelError : no such disturbance, no output, shapes; a matrix for each rule of a secant
        embedding.
    """
    model = loop.model
    evidence: dict[str, Any] = {"disturbance": entrance_of(loop, disturbance)}
    if entering is not None and len(entering) < len(loop.exact.disturbances):
        evidence["entering"] = [loop.exact.disturbances[k] for k in entering]
    if output is None:
        if not loop.exact.C:
            raise ModelError(
                f"model {model.name!r} has no output; give output=(C, D, F) for y = C x + D u + F w"
            )
        return evidence
    if not 1 <= len(output) <= 3:
        raise ModelError("output is (C, D, F), or its first one or two")
    matrices = dict(zip("CDF", output, strict=False))
    evidence["output"] = {
        letter: _stack(letter, value, len(model.A))
        for letter, value in matrices.items()
        if value is not None
    }
    if any(len(stack) > 1 for stack in evidence["output"].values()):
        loop.refuse_averages("output")
    return evidence


def entrance_of(loop: ClaimedLoop, disturbance: str | None) -> str:
    """Return where a disturbance enters, one of ``ENTRANCES``; None takes the model's first.

    Raises
    ------
    ModelError : the model has no such disturbance.
    """
    matrices = {"disturbances": loop.exact.E, "inputs": loop.exact.B}
    entrance = disturbance or next((name for name in ENTRANCES if matrices[name]), "disturbances")
    if not matrices.get(entrance):
        raise ModelError(
            f"disturbance {entrance!r}: the model {loop.model.name!r} has none such; it needs a "
            "matrix E ('disturbances') or B ('inputs') that is not zero"
        )
    return entrance


def disturbance_channel(loop: ClaimedLoop, evidence: dict[str, Any]) -> Path:
    """Return A, B, C, D of the blends, (N, ., .) each, in the checker's order."""
    channels = list(disturbance_channels(as_read(evidence), loop.searched, "claim"))
    return (
        np.array([floats(channel.A) for channel in channels]),
        np.array([floats(channel.B) for channel in channels]),
        np.array([floats(channel.C) for channel in channels]),
        np.array([floats(channel.through) for channel in channels]),
    )


def _stack(letter: str, value: ArrayLike, rules: int) -> list[list[list[float]]]:
    array = np.asarray(value, dtype=np.float64)
    array = array[None] if array.ndim == 2 else array
    if array.ndim != 3 or len(array) not in (1, rules) or not np.isfinite(array).all():
        raise ModelError(
            f"output: {letter} has shape {np.shape(value)}; a matrix, or one for each of {rules} "
            "rules, is needed, all finite"
        )
    return array.tolist()  # type: ignore[no-any-return]
