"""Fewer rules by truncated higher-order SVD of the vertices, with a proved error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Number, exact
from takagi.models.reduction.reduced_model import ReducedModel, bounded_reduction
from takagi.models.reduction.rule_tensor import RuleTensor, rule_tensor
from takagi.models.reduction.simplex_hull import simplex_weights
from takagi.models.ts.model import TSModel

DIGITS = 14  # of the reduced vertices, so that what is exact in decimals stays so
ROUNDING = 1e-9  # share of the tolerance by which floats may seem to miss it


def reduce_rules(
    model: TSModel, tolerance: Number, *, together: Sequence[Sequence[str]] = ()
) -> ReducedModel:
    r"""Return sum_j g_j R_j with |sum_i h_i S_i - sum_j g_j R_j| <= tolerance, in fewer rules.

    The vertices are a tensor over the premises' weights, S = T x_1 w_1 ... x_K w_K.  Mode k keeps
    the mean over its corners and the leading singular directions of T unfolded along k, and new
    weights G_k' w_k are those of a simplex around the corners in these directions: G_k >= 0 with
    rows of sum one, exactly, as decimals.  The core R is fitted by least squares, one direction
    after another given up while the error allows it.  Then

        sum_i h_i S_i - sum_j g_j R_j = (T - R x_1 G_1 ... x_K G_K) x_1 w_1 ... x_K w_K

    is a convex sum over the original's vertices, so that its largest value at a vertex bounds it on
    the whole box: this is computed in rationals, and covers truncation, hull and rounding.  With
    discarded singular values s the error is at most the root of the sum of all s^2, about.

    A premise that is a mode by itself is kept or replaced by its middle.  Premises ``together``
    may share fewer rules than their product: k premises that enter jointly affine need k + 1, and
    less where they act along one direction.  From three rules a mode on, the simplex reaches beyond
    the original's vertices, so that a design for it asks for more.

    Parameters
    ----------
    tolerance : of S = [A B E; C D 0] in Frobenius norm, in the units of the entries;
        ``mode_spectrum`` gives the error of each possible truncation.
    together : premises that share a mode; each other one is a mode by itself.  A model without
        premises is one mode of all its vertices.

    Returns
    -------
    The fewest rules that were found; the model itself, with error 0, where nothing can go.  That
    there is no smaller one is not promised.

    Raises
    ------
    ModelError : a negative tolerance, a premise in ``together`` that is not one or is named twice.

    Source: De Lathauwer, De Moor, Vandewalle (2000), SIAM J. Matrix Anal. Appl. 21(4), the
    decomposition and the bound by discarded singular values; Baranyi (2004), IEEE Trans. Industrial
    Electronics 51(2), its use on models, convex weights; both recalled.
    """
    limit = exact(tolerance)
    if limit < 0:
        raise ModelError(f"tolerance {float(limit):.9g} was given; at least 0 is needed")
    tensor = rule_tensor(model, together)
    search = _Search(tensor)
    ranks = [tensor.sizes]
    while (lower := search.lower(ranks[-1], float(limit))) is not None:
        ranks.append(lower)
    for some in reversed(ranks[1:]):
        found = bounded_reduction(model, tensor, *search.fitted(some))
        if found.error.size <= limit:
            return found
    return bounded_reduction(model, tensor, *search.fitted(ranks[0]))


@dataclass(slots=True, eq=False)
class _Search:
    """Weights by mode and number of rules, computed once."""

    tensor: RuleTensor
    known: dict[tuple[int, int], tuple[Floats, Floats]] = field(default_factory=dict)
    spans: dict[int, Floats] = field(default_factory=dict)

    def lower(self, ranks: tuple[int, ...], limit: float) -> tuple[int, ...] | None:
        """Return the ranks with one direction less, the cheapest; None if none is allowed."""
        best, least = None, limit * (1 + ROUNDING)
        for axis, rank in enumerate(ranks):
            directions = self._directions(axis).shape[1]
            if rank == 1:
                continue
            fewer = min(rank - 1, directions + 1)
            some = (*ranks[:axis], fewer, *ranks[axis + 1 :])
            error = self._error(some)
            # Of equal errors the first: an exact reduction leaves rounding alone.
            if error <= least:
                best, least = some, error
        return best

    def fitted(self, ranks: tuple[int, ...]) -> tuple[list[Floats], Floats]:
        """Return the factors, and the core that fits them best in the least-squares sense."""
        factors, core = [], self.tensor.values
        for axis, rank in enumerate(ranks):
            factor, inverse = self._weights(axis, rank)
            factors.append(factor)
            if rank < self.tensor.sizes[axis]:
                core = np.moveaxis(np.tensordot(inverse, core, axes=(1, axis)), 0, axis)
        if ranks != self.tensor.sizes:
            core = _rounded(core)
        return factors, core

    def _error(self, ranks: tuple[int, ...]) -> float:
        factors, whole = self.fitted(ranks)
        for axis, factor in enumerate(factors):
            if ranks[axis] < self.tensor.sizes[axis]:
                whole = np.moveaxis(np.tensordot(factor, whole, axes=(1, axis)), 0, axis)
        return float(np.linalg.norm(self.tensor.values - whole, axis=-1).max())

    def _directions(self, axis: int) -> Floats:
        if axis not in self.spans:
            self.spans[axis] = self.tensor.directions(axis)[0]
        return self.spans[axis]

    def _weights(self, axis: int, rank: int) -> tuple[Floats, Floats]:
        if (axis, rank) not in self.known:
            size = self.tensor.sizes[axis]
            factor = (
                np.eye(size)
                if rank == size
                else simplex_weights(self._directions(axis)[:, : rank - 1])
            )
            self.known[axis, rank] = factor, np.asarray(np.linalg.pinv(factor), dtype=np.float64)
        return self.known[axis, rank]


def _rounded(core: Floats) -> Floats:
    """Return the entries at 14 digits of the largest of their column."""
    if not core.size:
        return core
    flat = core.reshape(-1, core.shape[-1])
    found = np.empty_like(flat)
    for column, values in enumerate(flat.T):
        size = np.abs(values).max()
        places = DIGITS - 1 - int(np.floor(np.log10(size))) if size > 0 else 0
        found[:, column] = [round(float(value), places) for value in values]
    return found.reshape(core.shape) + 0.0
