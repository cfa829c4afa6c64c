"""Gains with integral action where part of the states is measured: a constant observer beside them.

The observer is the plant in the middle of its slopes,

    s' = A s + B (u - u*) + L (y - y* - C s),

and L minimises, for all slopes at once, the guaranteed cost of the dual problem: states pushed over
half their ranges in the time of the integral, outputs off by a share of theirs.  The share is
reduced from slow to fast; the slowest observer is taken whose proved jumps are nearly the largest.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.plant.gains import rounded_gains
from takagi.models.arrays import Floats
from takagi.models.equilibrium_line import ConstantObserver, own_states
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Errors of the outputs over half their ranges, slowest observer first.
SHARES = (1.0, 0.3, 0.1, 0.03)
DIGITS = 6  # of A, B, C and L


def measures_all(plant: Plant) -> bool:
    """Return whether every state of the plant is measured by itself, so that no observer is due."""
    alone = {y.expression for y in plant.outputs if y.name in (plant.measured or ())}
    return {plant.states[k].symbol for k in own_states(plant)} <= alone


def measured_rows(plant: Plant) -> tuple[int, ...]:
    """Return the places of the measured outputs among the outputs of the plant."""
    names = [y.name for y in plant.outputs]
    return tuple(names.index(name) for name in plant.measured or ())


def require_measured(plant: Plant, model: TSModel) -> None:
    """Refuse a plant with references whose law cannot know what it needs.

    Raises
    ------
    ModelError : what follows is not measured, an output with an input in it, a mode that no
        measured output shows.
    """
    from takagi.certificates.design.plant.observed_design import check_detectable

    rows = measured_rows(plant)
    measured = [plant.outputs[row].expression for row in rows]
    alone = {v.symbol for v in plant.states if v.symbol in measured}
    parameters = {p.symbol for p in plant.parameters}
    signals = {v.name: v.symbol for v in plant.disturbances}
    equations = {v.name: row for v, row in zip(plant.states, plant.equations, strict=True)}
    for reference in plant.references:
        followed = equations[reference.integral] + signals[reference.name]
        if followed not in measured and not followed.free_symbols - parameters <= alone:
            raise ModelError(
                f"plant {plant.name!r}: {reference.follows} follows {reference.name}, but it is "
                f"not measured ({', '.join(plant.measured or ())}): its integral is a part of the "
                f"law, which needs it; measure {reference.follows} too, or let follow what is "
                "measured"
            )
    if np.any(model.D[:, list(rows)]):
        raise ModelError(
            f"plant {plant.name!r}: a measured output depends on an input; with a reference, "
            "measure outputs that depend on states alone"
        )
    check_detectable(plant, model, rows, own_states(plant))


def constant_observers(
    plant: Plant, model: TSModel, time: float
) -> Iterator[tuple[ConstantObserver, float]]:
    """Yield observers from slow to fast, and the share of the outputs' ranges that made them.

    Parameters
    ----------
    time : in s, within which the states are pushed over half their ranges.
    """
    from takagi.lmi import lqr_pdc
    from takagi.models import TSModel as Model

    states, rows = own_states(plant), list(measured_rows(plant))
    A, B = model.A[:, states][:, :, states], model.B[:, states]
    C = model.C[:, rows][:, :, states]
    half = np.array([float(v.range.width) / 2 for k in states if (v := plant.states[k]).range])
    output_sizes = np.abs(C).max(axis=0) @ half
    dual = Model(A.transpose(0, 2, 1), C.transpose(0, 2, 1))
    means = [_short((stack.min(axis=0) + stack.max(axis=0)) / 2) for stack in (A, B, C)]
    for share in SHARES:
        Q, R = np.diag(half**2) / time, np.diag((share * output_sizes) ** 2) * time
        design = lqr_pdc(dual, Q, R, relaxation="common-gain")
        if not design.found:
            continue
        L = np.asarray(design.require()[0])[:1].transpose(0, 2, 1)
        A_mean, B_mean, C_mean = means
        gain = rounded_gains(L, DIGITS)[0]
        yield ConstantObserver(A_mean, B_mean, C_mean, gain, plant.measured or ()), share


def _short(matrix: Floats) -> Floats:
    return np.array([[float(f"{value:.{DIGITS}g}") for value in row] for row in matrix])
