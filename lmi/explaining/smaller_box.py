"""The same model on a smaller box: every premise, one alone, or all vertices about their mean."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.models import Premise, TSModel
from takagi.models.errors import ModelError

STACKS = ("A", "B", "C", "D", "E")


def on_smaller_box(model: Any, share: Fraction) -> Any:
    """Return the model with every premise on that share of its range, about the middle.

    The vertices of a model with premises are multilinear in them, so this is the same plant on
    the smaller box.  Without premises the vertices move to their mean; of an array, the array.
    """
    if isinstance(model, TSModel) and model.premises:
        for number in reversed(range(len(model.premises))):
            model = with_narrower_premise(model, number, share)
        return model
    move = _towards_mean(float(share))
    if not hasattr(model, "A"):
        return move(np.asarray(model, dtype=np.float64))
    if isinstance(model, TSModel):
        return _rebuilt(model, move, ())
    kept = {
        name: getattr(model, name) for name in ("states", "sample_time") if hasattr(model, name)
    }
    stacks = {
        name: move(np.asarray(getattr(model, name), dtype=np.float64))
        for name in STACKS
        if getattr(model, name, None) is not None
    }
    return SimpleNamespace(**kept, **stacks)


def with_narrower_premise(model: TSModel, number: int, share: Fraction) -> TSModel:
    """Return the model with one premise on that share of its range, about the middle.

    With share 0 the premise is a constant, which costs no rule.

    Raises
    ------
    ModelError : no such premise, or a share outside 0 ... 1.
    """
    if not 0 <= number < len(model.premises):
        raise ModelError(f"premise {number} of {len(model.premises)}; count from 0")
    if not 0 <= share <= 1:
        raise ModelError(f"share is {float(share):g}; it must lie in 0 ... 1")
    premise = model.premises[number]
    if len(premise.corners) == 1:
        return model
    middle, half = (premise.lower + premise.upper) / 2, (premise.upper - premise.lower) / 2
    narrow = Premise(
        premise.name,
        middle - share * half,
        middle + share * half,
        unit=premise.unit,
        latex=premise.latex,
        evidence=f"{float(share):.4g} of {premise.evidence}",
        evaluate=premise.evaluate,
        sampled=premise.sampled,
        domain=premise.domain,
    )
    premises = (*model.premises[:number], narrow, *model.premises[number + 1 :])
    t = float(share)
    corners = np.array([[1 + t, 1 - t], [1 - t, 1 + t]])[: 1 if share == 0 else 2] / 2
    shape = tuple(len(one.corners) for one in model.premises)
    order = np.ravel_multi_index(np.array(model.rules).T, shape)

    def move(stack: Array) -> Array:
        tensor = np.empty_like(stack)
        tensor[order] = stack
        tensor = tensor.reshape(*shape, *stack.shape[1:])
        moved = np.moveaxis(np.tensordot(corners, tensor, axes=(1, number)), 0, number)
        return moved.reshape(-1, *stack.shape[1:])

    return _rebuilt(model, move, premises)


def _towards_mean(share: float) -> Callable[[Array], Array]:
    def move(stack: Array) -> Array:
        if stack.ndim != 3:
            return stack
        mean = stack.mean(axis=0)
        return np.asarray(mean + share * (stack - mean))

    return move


def _rebuilt(
    model: TSModel, move: Callable[[Array], Array], premises: tuple[Premise, ...]
) -> TSModel:
    stacks = {name: getattr(model, name) for name in STACKS}
    moved = {
        name: move(stack) if stack.shape[1] and stack.shape[2] else None
        for name, stack in stacks.items()
    }
    return TSModel(
        move(model.A),
        moved["B"],
        C=moved["C"],
        D=moved["D"],
        E=moved["E"],
        states=model.states,
        inputs=model.inputs or None,
        outputs=model.outputs or None,
        disturbances=model.disturbances or None,
        premises=premises,
        sample_time=model.sample_time,
        name=model.name,
        source=model.source,
    )
