"""The vertices of a model as a tensor over its premises' weights, and how its rules differ.

    S(z) = T x_1 w_1(z) x_2 w_2(z) ... x_K w_K(z),

T of shape (N_1, ..., N_K, entries), w_k the weights of mode k.  A mode is a premise, or several
premises whose weights are multiplied out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError
from takagi.models.reduction.error_bound import LETTERS, Place
from takagi.models.ts.model import TSModel

# Below this share of the largest, a singular value is what rounding leaves of zero.
NOTHING = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class RuleTensor:
    """T over the modes, with the entries that are not the same in all rules.

    Attributes
    ----------
    modes : the premises of each mode; one mode without premises where the model has none.
    sizes : N_k.
    corners : (r, K), the place of each rule along each mode.
    values : T, (N_1, ..., N_K, entries).
    places : letter, row and column of each entry.
    """

    modes: tuple[tuple[str, ...], ...]
    sizes: tuple[int, ...]
    corners: Indices
    values: Floats
    places: tuple[Place, ...]

    def directions(self, axis: int) -> tuple[Floats, Floats]:
        """Return U (N, d) and s (d,): how the mode's corners differ from their mean.

        U s V' is the singular value decomposition of mode ``axis`` of T, unfolded, less the mean
        over its N corners; without the s that rounding leaves.  With the vector of ones, U spans
        weights that add up to one.

        Source: De Lathauwer, De Moor, Vandewalle (2000), SIAM J. Matrix Anal. Appl. 21(4),
        recalled.
        """
        flat = np.moveaxis(self.values, axis, 0).reshape(self.sizes[axis], -1)
        if not flat.size:
            return np.zeros((self.sizes[axis], 0)), np.zeros(0)
        left, singular, _ = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)
        count = int(np.sum(singular > NOTHING * np.linalg.norm(flat)))
        count = min(count, self.sizes[axis] - 1)
        return left[:, :count], singular[:count]


def rule_tensor(model: TSModel, together: Sequence[Sequence[str]] = ()) -> RuleTensor:
    """Return the model's vertices over its modes.

    Parameters
    ----------
    together : premises that share a mode; each other one is a mode by itself.

    Raises
    ------
    ModelError : an unknown premise, or one that is named twice.
    """
    names = [premise.name for premise in model.premises]
    groups = [tuple(group) for group in together]
    named = [name for group in groups for name in group]
    wrong = sorted({name for name in named if name not in names or named.count(name) > 1})
    if wrong:
        raise ModelError(
            f"together names {', '.join(wrong)}; each premise may be named once, and the model has "
            f"{', '.join(names) or 'none'}"
        )
    modes: list[tuple[str, ...]] = []
    for name in names:
        mine = next((group for group in groups if name in group), (name,))
        if mine not in modes:
            modes.append(mine)
    places = varying_entries(model)
    if not names:
        count = len(model.rules)
        values = _columns(model, places)
        return RuleTensor(((),), (count,), np.arange(count)[:, None], values, places)
    lengths = {p.name: len(p.corners) for p in model.premises}
    rules = np.array(model.rules)
    corners = np.column_stack([
        np.ravel_multi_index(
            tuple(rules[:, names.index(name)] for name in mode),
            tuple(lengths[name] for name in mode),
        )
        for mode in modes
    ])  # fmt: skip
    sizes = tuple(prod(lengths[name] for name in mode) for mode in modes)
    values = np.empty((*sizes, len(places)))
    values[tuple(corners.T)] = _columns(model, places)
    return RuleTensor(tuple(modes), sizes, corners, values, places)


def mode_spectrum(
    model: TSModel, together: Sequence[Sequence[str]] = ()
) -> dict[tuple[str, ...], tuple[float, ...]]:
    """Return the singular values of each mode: what its directions weigh, before any is given up.

    They are those of ``RuleTensor.directions``, in the units of the entries and largest first;
    giving up directions of several modes costs at most the root of the sum of their squares.

    Parameters
    ----------
    together : as in ``reduce_rules``.

    Returns
    -------
    The premises of a mode -> its singular values; a mode of d of them has at most d + 1 rules.

    Raises
    ------
    ModelError : as ``rule_tensor``.
    """
    tensor = rule_tensor(model, together)
    return {
        mode: tuple(float(s) for s in tensor.directions(axis)[1])
        for axis, mode in enumerate(tensor.modes)
    }


def varying_entries(model: TSModel) -> tuple[Place, ...]:
    """Return the entries of A, B, C, D, E that are not the same at all vertices."""
    return tuple(
        (letter, int(row), int(column))
        for letter in LETTERS
        for row, column in np.argwhere(
            (getattr(model, letter) != getattr(model, letter)[:1]).any(axis=0)
        )
    )


def _columns(model: TSModel, places: Sequence[Place]) -> Floats:
    found = np.empty((len(model.rules), len(places)))
    for column, (letter, row, place) in enumerate(places):
        found[:, column] = getattr(model, letter)[:, row, place]
    return found
