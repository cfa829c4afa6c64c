"""Why there was no answer and what would help: a value that explains it in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

from takagi.lmi.answer import Answer
from takagi.lmi.condition.term import Array
from takagi.lmi.decision.outcome import Share, shares_in_words
from takagi.models import Premise, TSModel
from takagi.models.arrays import Floats, ShortRepr

# Multipliers of about one direction, and a mode that is out of reach to solver accuracy.
ONE_DIRECTION, REACH = 1e-3, 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class UncontrollableBlend:
    """At sum_i h_i A_i, sum_i h_i B_i the mode of this eigenvalue is moved by no input.

    Attributes
    ----------
    weights : (r,) h.
    eigenvalue : lambda, with v' A(h) = lambda v' and v' B(h) = 0 to solver accuracy.
    direction : (n,) v, its largest entry 1.
    """

    weights: Floats
    eigenvalue: float
    direction: Floats

    def __str__(self) -> str:
        order = [k for k in np.argsort(-self.weights) if self.weights[k] > 1e-3]
        blend = " + ".join(f"{self.weights[k]:.3g} rule {k + 1}" for k in order)
        return f"at {blend} no input moves the mode at {self.eigenvalue:.4g}, by any gains"


def uncontrollable_blend(answer: Answer, model: Any) -> UncontrollableBlend | None:
    """Return the blend that explains a no to gains, where its multipliers are of one direction v.

    Given v, h and lambda solve the linear equations sum_i h_i A_i' v = lambda v and
    sum_i h_i B_i' v = 0 with h >= 0, sum h = 1: nonnegative least squares.  Memberships are taken
    to be free; where they are products a blend may never occur.  Floating point, no proof.
    """
    from scipy.optimize import nnls

    Z = answer.multipliers.get("Q positive definite")
    if Z is None or answer.coordinates is None or len(answer.coordinates) != Z.shape[1]:
        return None
    values, vectors = np.linalg.eigh(Z[0])
    if values[-1] <= 0 or (len(values) > 1 and values[-2] > ONE_DIRECTION * values[-1]):
        return None
    s, v = answer.coordinates, vectors[:, -1]
    A, B = np.asarray(model.A, dtype=np.float64), np.asarray(model.B, dtype=np.float64)
    scaled_A, scaled_B = A * s / s[:, None], B / s[:, None]
    size = float(np.abs(scaled_A).max()) or 1.0
    reach = np.einsum("rnm,n->mr", scaled_B, v) / np.abs(scaled_B).max(axis=(0, 1))[:, None]
    drift = np.einsum("rnk,n->kr", scaled_A, v) / size
    # Unknowns h, and lambda / size as the difference of two nonnegative numbers.
    equations = np.zeros((len(v) + len(reach) + 1, len(A) + 2))
    equations[: len(v), : len(A)], equations[len(v) : -1, : len(A)] = drift, reach
    equations[: len(v), -2], equations[: len(v), -1] = -v, v
    equations[-1, : len(A)] = 1.0
    multipliers, residual = nnls(equations, np.eye(len(equations))[-1])
    eigenvalue = float(multipliers[-2] - multipliers[-1]) * size
    if residual > REACH or not _slow(eigenvalue, answer):
        return None
    weights, direction = multipliers[: len(A)], v / s
    return UncontrollableBlend(
        weights / weights.sum(), eigenvalue, direction / direction[np.argmax(np.abs(direction))]
    )


def _slow(eigenvalue: float, answer: Answer) -> bool:
    """Return whether the mode is slower than the condition asks for: then there is no solution."""
    parameters = {} if answer.condition is None else answer.condition.parameters
    if "contraction" in parameters:
        return eigenvalue**2 >= parameters["contraction"] - REACH
    return eigenvalue >= -parameters.get("alpha", 0.0) - REACH * max(1.0, abs(eigenvalue))


# Items that are named in words.
NAMED = 4


@dataclass(frozen=True, slots=True)
class PremiseRelief:
    """What one premise costs, the others on their whole ranges.

    Attributes
    ----------
    name, unit : of the premise.
    share : the largest share of its range, about the middle, with an answer, of those that were
        tried; 0 where it must be a constant; None where even that does not help.
    lower, upper : that range.
    """

    name: str
    unit: str
    share: float | None
    lower: float
    upper: float

    def __str__(self) -> str:
        if self.share is None:
            return f"premise {self.name}: a constant at its middle does not help"
        if self.share == 0:
            return f"premise {self.name}: a constant at {self.lower:.4g} {self.unit} is enough"
        return (
            f"premise {self.name}: {self.share:.0%} of its range is enough, "
            f"{self.lower:.4g} to {self.upper:.4g} {self.unit}"
        )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Explanation(ShortRepr):
    """Why a design fails, and each single change that helps; ``str()`` says it in words.

    Every change that is named was solved, and its answer passed the check; the best ones were
    bracketed by
    bisection, so a larger share or rate may have an answer too.  Nothing here is a proof.

    Attributes
    ----------
    asked : what was asked, in words.
    found : whether there is an answer as it was asked; then nothing else was tried.
    binding : the items that carry the no, largest share first.
    rules : where the rules of those items lie, e.g. ``"rule 2: speed = 7 m/s"``; empty for a
        model without premises.
    stuck : a blend that no gains stabilise, where one makes the condition infeasible; None
    otherwise.
    box : the largest share of the box, about its middle, with an answer, of those that were
        tried; None where there was none.
    premises : what each premise costs, most first; empty for a model without.
    decay_rate : the largest rate in 1/s with an answer, of those that were tried; negative where
        V may grow; None where there was none.
    lowest_rate : the lowest rate in 1/s that was tried; None when none was.
    relaxations : richer ones that were tried, with whether there were gains, or None where one
        is too large for this model or does not apply.
    asked_again : how many times it was asked.
    """

    asked: str
    found: bool
    binding: tuple[Share, ...] = ()
    rules: tuple[str, ...] = ()
    stuck: UncontrollableBlend | None = None
    box: float | None = None
    premises: tuple[PremiseRelief, ...] = ()
    decay_rate: float | None = None
    lowest_rate: float | None = None
    relaxations: tuple[tuple[str, bool | None], ...] = ()
    asked_again: int = 0

    def __str__(self) -> str:
        if self.found:
            return f"{self.asked}: found, there is nothing to explain"
        lines = [f"{self.asked}: none"]
        if self.binding:
            lines.append(f"  the no rests on {shares_in_words(self.binding[:NAMED])}")
        lines += [f"    {rule}" for rule in self.rules]
        lines += [f"  {self.stuck}"] if self.stuck is not None else []
        lines += [f"  {line}" for line in _advice(self)]
        return "\n".join(lines)


def _advice(explanation: Explanation) -> list[str]:
    lines = []
    if explanation.relaxations:
        words = {True: "has gains", False: "has none", None: "does not apply or is too large"}
        tried = ", ".join(f"{name} {words[status]}" for name, status in explanation.relaxations)
        lines.append(f"a richer relaxation: {tried}")
    if explanation.decay_rate is not None:
        grows = ": V may grow, no faster" if explanation.decay_rate < 0 else ""
        lines.append(f"a lower decay rate: {explanation.decay_rate:.4g} 1/s is enough{grows}")
    elif explanation.lowest_rate is not None:
        lines.append(
            f"a lower decay rate does not help: not even {explanation.lowest_rate:.4g} 1/s"
        )
    if explanation.box is None:
        lines.append("a smaller box does not help: not even its middle has an answer")
    else:
        lines.append(f"a smaller box: {explanation.box:.0%} of it about its middle is enough")
    return lines + [str(relief) for relief in explanation.premises]


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
    stacks_kept = {
        name: getattr(model, name) for name in ("states", "sample_time") if hasattr(model, name)
    }
    stacks = {
        name: move(np.asarray(getattr(model, name), dtype=np.float64))
        for name in STACKS
        if getattr(model, name, None) is not None
    }
    return SimpleNamespace(**stacks_kept, **stacks)


def with_narrower_premise(model: TSModel, number: int, share: Fraction) -> TSModel:
    """Return the model with one premise on that share of its range, about the middle.

    With share 0 the premise is a constant, which costs no rule.
    """
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
    shape = tuple(len(axis.corners) for axis in model.premises)
    order = np.ravel_multi_index(np.array(model.rules).T, shape)

    def move(stack: Array) -> Array:
        tensor = np.empty_like(stack)
        tensor[order] = stack
        tensor = tensor.reshape(*shape, *stack.shape[1:])
        blended = np.moveaxis(np.tensordot(corners, tensor, axes=(1, number)), 0, number)
        return blended.reshape(-1, *stack.shape[1:])

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
    new_stacks = {
        name: move(stack) if stack.shape[1] and stack.shape[2] else None
        for name, stack in stacks.items()
    }
    return TSModel(
        move(model.A),
        new_stacks["B"],
        C=new_stacks["C"],
        D=new_stacks["D"],
        E=new_stacks["E"],
        states=model.states,
        inputs=model.inputs or None,
        outputs=model.outputs or None,
        disturbances=model.disturbances or None,
        premises=premises,
        sample_time=model.sample_time,
        name=model.name,
        source=model.source,
    )
