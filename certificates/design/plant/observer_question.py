"""Checks before the design of an observer: the signals that it needs, and detectability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.document.observer_data import slopes_data
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Options that are not proved for a loop with an observer.
LEFT_OUT = ("damping", "fastest", "sample_time", "initial", "gain_bound")


@dataclass(frozen=True, slots=True, eq=False)
class ObserverQuestion:
    """The kind of observer that a plant needs.

    Attributes
    ----------
    rows : indices of the measured outputs among the outputs of the model.
    measured : their names.
    at_estimate : whether a premise depends on what is not measured, so that the weights are those
        at the estimate.
    slopes : the plant's slopes between any two states, where the weights are at the estimate.
    note : a sentence that says which weights the observer uses, and why.
    """

    rows: tuple[int, ...]
    measured: tuple[str, ...]
    at_estimate: bool
    slopes: TSModel | None
    note: str


def observer_question(plant: Plant, model: TSModel, asked: PlantSettings) -> ObserverQuestion:
    """Return the kind of observer that the plant needs.

    Raises
    ------
    ModelError : a wish that cannot be proved of such a loop, a premise of what the observer does
        not know, an unstable mode that no measured output shows, slopes that cannot be bounded.
    """
    assert plant.measured is not None  # checked by the caller
    for name in LEFT_OUT:
        if getattr(asked, name):
            raise ModelError(
                f"plant {plant.name!r}: {name} was given, which is not proved for a law with "
                "measured outputs; leave it out, or leave out 'measured' for a law of all states"
            )
    names = [y.name for y in plant.outputs]
    rows = tuple(names.index(name) for name in plant.measured)
    _check_detectable(plant, model, rows)
    # By itself and unchanged: the program computes premises of what it reads.
    alone = {y.expression for y in plant.outputs if y.name in plant.measured}
    seen = {label for v, label in zip(plant.states, model.states, strict=True) if v.symbol in alone}
    scheduled = ClaimedLoop.of(model, model_data=_data(model)).exact.scheduled_by or ()
    outside = [label for label in scheduled if label not in model.states]
    if outside:
        raise ModelError(
            f"plant {plant.name!r}: a premise depends on {', '.join(outside)}, which an observer "
            "does not know; choose premises of states alone in [premises], or leave out 'measured'"
        )
    hidden = [label for label in scheduled if label not in seen]
    shown = ", ".join(plant.measured)
    if not hidden:
        told = "its weights are the plant's own" if scheduled else "the plant is linear"
        return ObserverQuestion(
            rows, plant.measured, False, None, f"an observer of {shown}; {told}"
        )
    unknown = ", ".join(label.split(" [")[0] for label in hidden)
    note = (
        f"an observer of {shown}; premises depend on {unknown}, which is not measured, so that its "
        "weights are those at the estimate"
    )
    return ObserverQuestion(rows, plant.measured, True, _slopes(plant, asked, unknown), note)


def slope_vertices(question: ObserverQuestion) -> tuple[Floats, Floats]:
    """Return the different pairs S (k, n, n) and R (k, p, n) of the slopes."""
    assert question.slopes is not None
    S = question.slopes.A
    R = question.slopes.C[:, list(question.rows)]
    both = np.concatenate([S, R], axis=1)
    _, first = np.unique(both.reshape(len(both), -1), axis=0, return_index=True)
    kept = np.sort(first)
    return S[kept], R[kept]


def _data(model: TSModel) -> dict[str, object] | None:
    from takagi.certificates.document.plant_embedding import plant_and_claim

    data = plant_and_claim(model)[0]
    if data is None:
        raise ModelError(
            f"plant {model.name!r} cannot be written into a certificate, which says what its "
            "premises depend on; an observer needs that"
        )
    return data


def _slopes(plant: Plant, asked: PlantSettings, unknown: str) -> TSModel:
    from takagi.certificates.design.plant.secant_model import secant_model

    try:
        found = secant_model(plant, rest=asked.rest)
        slopes_data(found)
    except ModelError as error:
        # The message begins with the formula of the slope, which may be long.
        _, depends, rest = str(error).partition(" depends on ")
        why = f"a slope depends on {rest}" if depends else str(error)
        raise ModelError(
            f"premises depend on {unknown}, which is not measured; an observer at its estimate "
            f"needs bounded slopes of the plant, and has none: {why}. Measure {unknown} too, give "
            "ranges to what the slopes depend on, or write the equations without tables and kinks"
        ) from error
    return found


def _check_detectable(plant: Plant, model: TSModel, rows: tuple[int, ...]) -> None:
    """Refuse a mode at rest that does not decay and is not observable."""
    from takagi.lmi.stabilisability import fixed_mode

    h = _weights_at_rest(model)
    A = np.tensordot(h, model.A, axes=1)
    C = np.tensordot(h, model.C[:, list(rows)], axes=1)
    # States scaled to order one, so that one tolerance fits all.
    units = np.array([
        1.0 if label not in model.box else max(float(abs(e)) for e in model.box[label])
        for label in model.states
    ])  # fmt: skip
    A, C = A * units / units[:, None], C * units
    found = fixed_mode(A.T[None], C.T[None], 0.0, step=model.sample_time)
    if found is None:
        return
    _, eigenvalue, _ = found
    # The right eigenvector has the states that move in this mode.
    values, vectors = np.linalg.eig(A)
    moving = np.abs(vectors[:, np.argmin(np.abs(values - eigenvalue))])
    shown = ", ".join(
        v.name for v, size in zip(plant.states, moving, strict=True) if size > 0.05 * moving.max()
    )
    value = f"{eigenvalue:.4g}" if eigenvalue.imag else f"{eigenvalue.real:.4g}"
    raise ModelError(
        f"at rest the mode at {value} (it moves {shown}) does not decay and shows in nothing that "
        f"is measured ({', '.join(plant.measured or ())}); no observer can follow it: measure "
        f"one of {shown} too"
    )


def _weights_at_rest(model: TSModel) -> Floats:
    if not model.premises:
        return np.full(len(model.A), 1.0 / len(model.A))
    labels = (*model.states, *model.inputs, *model.disturbances)
    point = {label.split(" [")[0]: 0.0 for label in labels}
    return model.memberships(model.premise_values(**point), clip=True)
