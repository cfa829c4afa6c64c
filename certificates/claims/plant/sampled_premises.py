"""Refuses to prove anything about a plant whose bounds are based on samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel


def refuse_sampled(model: TSModel) -> None:
    """Raise ModelError for a model with a premise whose bounds come from samples.

    Its vertices need not contain the plant: between the samples a premise may leave its bounds.
    """
    if model.sampled:
        names = ", ".join(model.sampled)
        raise ModelError(
            f"model {model.name!r}: the bounds of {names} are sampled, which is no proof, so "
            "nothing can be proved of the plant; let sector_model enclose them, or give bounds "
            "that it can confirm"
        )
