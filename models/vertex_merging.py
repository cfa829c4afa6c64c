"""Fewer vertices: nearly equal ones are merged, and what that costs is bounded exactly."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import ceil, isqrt

import numpy as np
from numpy.typing import NDArray

from takagi.models.enclosure.interval import Number, exact
from takagi.models.errors import ModelError
from takagi.models.ts_model import TSModel

__all__ = ["MergedModel", "merge_vertices"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class MergedModel:
    """A model of fewer vertices, with |S(h) - S_merged(shares h)| <= error for every h.

    S = [A B E; C D 0], h >= 0 and sum h = 1; the norm is Frobenius', so the spectral one too.

    Attributes
    ----------
    model : the merged vertices, without premises: its memberships are ``shares @ h``.
    shares : (merged, original) of 0 and 1, a single 1 in each column.
    error : proved in rationals, entries read as the decimals they print as.
    """

    model: TSModel
    shares: Floats
    error: Fraction

    def norm_bounded(self) -> tuple[Floats, Floats, Floats]:
        """Return (D, E, F) with [A B](h) in [A B]_merged + D Delta [E F], |Delta| <= 1.

        D is ``error`` times the identity, rounded up; E and F pick x and u from (x, u).
        """
        n, m = self.model.B.shape[1:]
        size = float(self.error)
        if Fraction(size) < self.error:
            size = float(np.nextafter(size, np.inf))
        whole = np.eye(n + m)
        return size * np.eye(n), whole[:, :n], whole[:, n:]


def merge_vertices(model: TSModel, tolerance: Number) -> MergedModel:
    """Return the model with vertices of Frobenius distance <= tolerance replaced by one of them.

    h weighs the differences S_i - S_leader(i) convexly, so the largest of them bounds the error.
    A vertex joins the first leader that is near enough; the fewest vertices are not promised.

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
    stacks = np.concatenate(
        [part.reshape(len(model.A), -1) for part in (model.A, model.B, model.E, model.C, model.D)],
        axis=1,
    )
    leaders: list[int] = []
    place: list[int] = []
    error = Fraction(0)
    for index, stack in enumerate(stacks):
        for number, leader in enumerate(leaders):
            # The floats only skip what is far away; near vertices are measured exactly.
            if np.linalg.norm(stack - stacks[leader]) > 1.001 * float(limit):
                continue
            squared = _squared_distance(stack, stacks[leader])
            if squared <= limit**2:
                error = max(error, min(limit, _root_above(squared)))
                place.append(number)
                break
        else:
            place.append(len(leaders))
            leaders.append(index)
    shares = np.zeros((len(leaders), len(stacks)))
    shares[place, np.arange(len(stacks))] = 1.0
    shares.flags.writeable = False
    return MergedModel(_restricted(model, leaders), shares, error)


def _squared_distance(first: Floats, second: Floats) -> Fraction:
    different = np.flatnonzero(first != second)
    return sum(((exact(first[k]) - exact(second[k])) ** 2 for k in different), Fraction(0))


def _root_above(squared: Fraction) -> Fraction:
    """Return a decimal at least the square root, at most 1e-15 above it."""
    whole = ceil(squared * 10**30)
    root = isqrt(whole)
    return Fraction(root if root * root == whole else root + 1, 10**15)


def _restricted(model: TSModel, leaders: list[int]) -> TSModel:
    return TSModel(
        model.A[leaders],
        model.B[leaders],
        C=model.C[leaders],
        D=model.D[leaders],
        E=model.E[leaders],
        states=model.states,
        inputs=model.inputs,
        outputs=model.outputs,
        disturbances=model.disturbances,
        box=model.box,
        sample_time=model.sample_time,
        name=model.name,
        source=model.source,
    )
