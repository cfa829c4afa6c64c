"""A model of fewer rules with its weights and its proved error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError
from takagi.models.reduction.error_bound import LETTERS, ErrorBound, error_bound
from takagi.models.reduction.exact_residual import residual, row_sums_are_one
from takagi.models.reduction.rule_tensor import RuleTensor
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise


@dataclass(frozen=True, slots=True, eq=False)
class ReducedModel:
    """sum_j g_j R_j in the place of sum_i h_i S_i, with g = shares h and a proved error.

    shares >= 0 with columns of sum one, so g is convex whenever h is.  What is shown of A and B
    for the reduced model with ``error.blocks()`` as uncertainty holds for the original: with the
    same x and u its x' is one of those that are allowed.  Errors of C, D and E are in
    ``error.parts``.  It means something wherever the original does, and nowhere else.

    Attributes
    ----------
    original : S, r rules.
    model : R, fewer rules.  Where every mode has at most two rules left it has premises of its
        own, and knows its memberships; otherwise they are ``memberships`` here.
    error : how far both are apart, at most.
    modes : the premises of each mode, see ``rule_tensor``; one without premises for all vertices.
    corners : (r, modes), the place of each original rule along each mode.
    factors : G_k of each mode, decimals, rows of sum one: the mode's weights are G_k' w_k.
    """

    original: TSModel
    model: TSModel
    error: ErrorBound
    modes: tuple[tuple[str, ...], ...]
    corners: Indices
    factors: tuple[Floats, ...]

    @property
    def shares(self) -> Floats:
        """Return (reduced, original) weights: S_i is near sum_j shares_ji R_j."""
        found = np.ones((len(self.corners), 1))
        for column, factor in zip(self.corners.T, self.factors, strict=True):
            found = (found[:, :, None] * factor[column][:, None, :]).reshape(len(found), -1)
        return found.T

    def memberships(
        self, values: ArrayLike | None = None, /, *, clip: bool = False, **premise_values: ArrayLike
    ) -> Floats:
        """Return g(z), z the original's premises; arguments as for ``TSModel.memberships``."""
        h = self.original.memberships(values, clip=clip, **premise_values)
        return np.tensordot(self.shares, h, axes=1)

    def expanded(self, gains: ArrayLike) -> Floats:
        """Return gains K_i for the original's rules with sum_i h_i K_i = sum_j g_j K_j.

        Parameters
        ----------
        gains : (reduced rules, m, n).

        Raises
        ------
        ModelError : another number of gains.
        """
        K = np.asarray(gains, dtype=np.float64)
        if K.ndim != 3 or len(K) != len(self.model.rules):
            raise ModelError(
                f"gains have shape {K.shape}; ({len(self.model.rules)}, m, n) is needed, one for "
                "each rule of the reduced model"
            )
        return np.tensordot(self.shares.T, K, axes=1)


MergedModel: TypeAlias = ReducedModel
"""What ``merge_vertices`` returns."""


def bounded_reduction(
    model: TSModel, tensor: RuleTensor, factors: Sequence[Floats], core: Floats
) -> ReducedModel:
    """Return the model with weights G_k' w_k and vertices R, and its error, proved.

    Parameters
    ----------
    tensor : of the model.
    factors : G_k, (N_k, rho_k); an identity leaves the mode as it is.
    core : R, (rho_1, ..., rho_K, entries) for the entries of the tensor.

    Raises
    ------
    ModelError : a factor that is not nonnegative with rows of sum one, in decimals; a premise with
        sampled bounds, for the reduced model could not say that nothing is proved with it.
    """
    for premise in model.premises:
        if premise.sampled:
            raise ModelError(
                f"premise {premise.name} has sampled bounds, so nothing is proved with the model; "
                "bound it rigorously before the rules are reduced"
            )
    for mode, factor in zip(tensor.modes, factors, strict=True):
        if not row_sums_are_one(factor):
            raise ModelError(
                f"the weights of {', '.join(mode) or 'the vertices'} are not convex sums: every "
                "row must be >= 0 with sum exactly 1, as decimals"
            )
    lost = residual(tensor.values, factors, core)
    rows = lost.integers[tuple(tensor.corners.T)]
    error = error_bound(
        type(lost)(rows, lost.places), tensor.places, len(model.states), len(model.inputs)
    )
    kept = tuple(np.array(factor) for factor in factors)
    for factor in kept:
        factor.flags.writeable = False
    return ReducedModel(
        original=model,
        model=_vertices(model, tensor, kept, core, error.size),
        error=error,
        modes=tensor.modes,
        corners=tensor.corners,
        factors=kept,
    )


def _vertices(
    model: TSModel, tensor: RuleTensor, factors: Sequence[Floats], core: Floats, lost: Fraction
) -> TSModel:
    premises = _premises(model, tensor, factors)
    # Where no premise is left that says on which part of the box it holds, the box would lie.
    partial = any(p.domain for p in model.premises) and not any(p.domain for p in premises)
    count, few = len(model.rules), int(np.prod(core.shape[:-1]))
    told = f"{few} rules in the place of {count}, Frobenius error {float(lost):.3g}"
    flat = core.reshape(-1, len(tensor.places))
    stacks = {
        letter: np.repeat(getattr(model, letter)[:1], len(flat), axis=0) for letter in LETTERS
    }
    for column, (letter, row, place) in enumerate(tensor.places):
        stacks[letter][:, row, place] = flat[:, column]
    return TSModel(
        stacks["A"],
        stacks["B"],
        C=stacks["C"],
        D=stacks["D"],
        E=stacks["E"],
        states=model.states,
        inputs=model.inputs,
        outputs=model.outputs,
        disturbances=model.disturbances,
        premises=premises,
        box={} if partial else model.box,
        sample_time=model.sample_time,
        name=model.name,
        source=model.source if few == count else "; ".join(filter(None, (model.source, told))),
    )


def _premises(model: TSModel, tensor: RuleTensor, factors: Sequence[Floats]) -> list[Premise]:
    """Return premises whose products of weights are the reduced ones; none if there are no such."""
    named = {premise.name: premise for premise in model.premises}
    found: list[Premise] = []
    for k, (mode, factor) in enumerate(zip(tensor.modes, factors, strict=True), start=1):
        members = [named[name] for name in mode]
        size, rules = factor.shape
        if members and size == rules and np.array_equal(factor, np.eye(size)):
            found += members
        elif rules == 2 and members:
            found.append(_share(_free_name(f"share{k}", named), members, factor[:, 1]))
        elif rules > 1:
            return []
    return found


def _free_name(name: str, taken: object) -> str:
    while name in taken:  # type: ignore[operator]
        name += "_"
    return name


def _share(name: str, members: Sequence[Premise], weights: Floats) -> Premise:
    """Return the premise sum_c weights_c w_c, w_c the products of the members' weights."""

    def value(**point: float) -> float:
        products = np.ones(1)
        for premise in members:
            assert premise.evaluate is not None  # without it, ``value`` is not used
            products = np.outer(products, premise.weights(premise.evaluate(**point))).ravel()
        return float(np.clip(products @ weights, 0.0, 1.0))

    evaluate: Callable[..., float] | None = value
    if any(premise.evaluate is None for premise in members):
        evaluate = None
    listed = ", ".join(premise.name for premise in members)
    return Premise(
        name,
        0,
        1,
        evidence=f"a convex sum of the weights of {listed}, in decimals",
        evaluate=evaluate,
        domain=next((premise.domain for premise in members if premise.domain is not None), None),
    )
