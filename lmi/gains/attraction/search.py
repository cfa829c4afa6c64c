"""Solve for a largest ellipsoid: in units of its own size, and at the slope that serves it best."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from takagi.lmi.analysis.common_quadratic import vertex_weight
from takagi.lmi.analysis.loop_pairs import pairs_of
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.balance import balanced_states, nearest_power
from takagi.lmi.decision.decide import optimise
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.gains.attraction.condition import attraction_condition
from takagi.lmi.gains.attraction.request import AttractionRequest
from takagi.models.arrays import Floats

# Slopes that the secant is tried with, from 1 / overdrive to 1, and nearer and nearer the best.
SLOPES, ZOOMS = 5, 3
ROUNDS = 4
# The measure is within this share of its largest value, so that the LMIs keep a margin.
SLACK = 1e-4


def largest_ellipsoid(task: AttractionRequest) -> tuple[Condition, Outcome, Floats, Floats]:
    """Return the condition, its outcome, and the units of states and inputs it is posed in.

    The best of the slopes that are tried, one where there is nothing to try.
    """
    if task.saturation != "secant" or task.overdrive == 1.0:
        return _rounds(task)
    tried = list(np.geomspace(1.0, task.overdrive, SLOPES))
    found = [_rounds(replace(task, overdrive=float(overdrive))) for overdrive in tried]
    for _ in range(ZOOMS):
        best = max(range(len(tried)), key=lambda k: _size(found[k], task))
        order = np.sort(tried)
        place = int(np.searchsorted(order, tried[best]))
        low, high = order[max(place - 1, 0)], order[min(place + 1, len(order) - 1)]
        finer = np.geomspace(low, high, SLOPES)[1:-1]
        found += [_rounds(replace(task, overdrive=float(overdrive))) for overdrive in finer]
        tried += list(finer)
    return max(found, key=lambda one: _size(one, task))


def _rounds(task: AttractionRequest) -> tuple[Condition, Outcome, Floats, Floats]:
    """Solve in coordinates of the ellipsoid's own size, found in a few rounds."""
    tau = np.ones(task.B.shape[2])
    if task.input_limit is not None:
        tau = nearest_power(task.input_limit)
    s = _first_units(task)
    condition = attraction_condition(task.scaled(s, tau))
    outcome = optimise(condition, slack=SLACK)
    for _ in range(ROUNDS):
        if outcome.status != "candidate" and not outcome.feasible:
            break
        axes = np.sqrt(np.diag(outcome.values["Q"][0]))
        if axes.max() <= 4 and axes.min() >= 0.25:
            break
        nearer = s * nearest_power(axes)
        again = attraction_condition(task.scaled(nearer, tau))
        found = optimise(again, slack=SLACK)
        if found.status != "candidate" and (outcome.status == "candidate" or not found.feasible):
            break
        condition, outcome, s = again, found, nearer
    return condition, outcome, s, tau


def _first_units(task: AttractionRequest) -> Floats:
    """Return units of the states, powers of two, in which the limits are of order one."""
    closed = task.A if task.gains is None else _closed(task)
    s = balanced_states(closed)
    sizes = []
    if task.state_box is not None:
        sizes.append(np.min(task.state_box / s))
    if task.input_limit is not None and task.gains is not None:
        reach = np.abs(task.gains * s).max(axis=(0, 2))
        sizes.append(np.min(task.input_limit / np.maximum(reach, 1e-300)))
    elif task.input_limit is not None:
        pushed = np.abs(task.B * task.input_limit / s[:, None]).max()
        sizes.append(2 * pushed / vertex_weight(task.A * s / s[:, None]))
    if task.rate_rows is not None and task.rate_limit is not None:
        sizes.append(
            np.min(task.rate_limit / np.maximum(np.abs(task.rate_rows * s).max(1), 1e-300))
        )
    usable = [size for size in sizes if np.isfinite(size) and 0 < size < 1e200]
    return s * float(nearest_power(np.array(min(usable, default=1.0))))


def _closed(task: AttractionRequest) -> Floats:
    assert task.gains is not None
    K = np.broadcast_to(task.gains, (len(task.A), *task.gains.shape[1:]))
    return pairs_of(task.A, task.B, K)


def _size(found: tuple[Condition, Outcome, Floats, Floats], task: AttractionRequest) -> float:
    """Return the measure in the model's states; -inf where there is no ellipsoid."""
    _, outcome, s, _ = found
    if outcome.status != "candidate":
        return -np.inf
    Q = outcome.values["Q"][0] * s * s[:, None]
    if isinstance(task.measure, str):
        axes = float((np.diag(Q) / task.units**2).sum())
        return axes if task.measure == "trace" else float(np.linalg.slogdet(Q)[1])
    reach = np.einsum("ki,ij,kj->k", task.measure, np.linalg.inv(Q), task.measure)
    return -float(reach.max())
