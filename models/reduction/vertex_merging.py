"""Fewer vertices: nearly equal ones are merged, and what that costs is bounded exactly."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Number, exact
from takagi.models.reduction.reduced_model import ReducedModel, bounded_reduction
from takagi.models.reduction.rule_tensor import RuleTensor, varying_entries
from takagi.models.ts.model import TSModel


def merge_vertices(model: TSModel, tolerance: Number) -> ReducedModel:
    """Return the model with vertices of Frobenius distance <= tolerance replaced by one of them.

    h weighs the differences S_i - S_leader(i) convexly, so the largest of them bounds the error.
    A vertex joins the first leader that is near enough; the fewest vertices are not promised.
    ``shares`` of the result is of 0 and 1, a single 1 in each column, and its model has no
    premises.

    Parameters
    ----------
    tolerance : in the units of the matrices' entries, at least 0.

    Raises
    ------
    ModelError : a negative tolerance.
    """
    limit = exact(tolerance)
    if limit < 0:
        raise ModelError(f"tolerance {float(limit):.9g} was given; at least 0 is needed")
    count = len(model.rules)
    places = varying_entries(model)
    stacks = np.empty((count, len(places)))
    for column, (letter, row, place) in enumerate(places):
        stacks[:, column] = getattr(model, letter)[:, row, place]
    leaders: list[int] = []
    followed: list[int] = []
    for index, stack in enumerate(stacks):
        for number, leader in enumerate(leaders):
            # The floats only skip what is far away; near vertices are measured exactly.
            if np.linalg.norm(stack - stacks[leader]) > 1.001 * float(limit):
                continue
            if _squared_distance(stack, stacks[leader]) <= limit**2:
                followed.append(number)
                break
        else:
            followed.append(len(leaders))
            leaders.append(index)
    tensor = RuleTensor(((),), (count,), np.arange(count)[:, None], stacks, places)
    return bounded_reduction(model, tensor, [np.eye(len(leaders))[followed]], stacks[leaders])


def _squared_distance(first: Floats, second: Floats) -> Fraction:
    different = np.flatnonzero(first != second)
    return sum(((exact(first[k]) - exact(second[k])) ** 2 for k in different), Fraction(0))
