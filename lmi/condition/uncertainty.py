r"""Norm-bounded uncertainty of a Takagi-Sugeno model, as a value.

    x' = A(h) x + B(h) u + sum_k D_k(h) p_k,     |p_k| <= |E_k(h) x + F_k(h) u|,

with A(h) = sum_i h_i A_i and so on: p_k = Delta_k (E_k x + F_k u) for any matrix Delta_k of norm at
most 1, which may depend on time and state in any way.  Discrete time: x+ in the place of x'.

Where D_k and E_k both differ from rule to rule this is not sum_i h_i D_i Delta E_i, a sum of
products, but the product of the sums; ``NormBounded.by_rule`` gives that other uncertainty. If one
of them is the same in all rules, the two are equal, and the conditions have a multiplier for each
rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.term import Array
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False)
class NormBounded:
    """One block D Delta [E, F] with |Delta| <= 1 (spectral norm).

    Attributes
    ----------
    D : (r, n, p), or (n, p) for the same in every rule: where it enters.
    E : (r, q, n) or (q, n): the part of the state that drives it.
    F : (r, q, m) or (q, m): the part of the input that drives it; None if no input does.
    """

    D: ArrayLike
    E: ArrayLike
    F: ArrayLike | None = None

    @classmethod
    def by_rule(
        cls, D: ArrayLike, E: ArrayLike, F: ArrayLike | None = None
    ) -> tuple[NormBounded, ...]:
        """Return r blocks for sum_i h_i D_i Delta_i (E_i x + F_i u), one Delta_i a rule.

        Block k has the same D_k in every rule, and E_k, F_k in rule k alone, so that its blend
        is D_k Delta_k h_k (E_k x + F_k u).
        """
        enters, state = np.asarray(D, dtype=np.float64), np.asarray(E, dtype=np.float64)
        driven = None if F is None else np.asarray(F, dtype=np.float64)
        stacks = [stack for stack in (enters, state, driven) if stack is not None]
        if any(stack.ndim != 3 or len(stack) != len(enters) for stack in stacks):
            shapes = ", ".join(str(stack.shape) for stack in stacks)
            raise ModelError(f"by_rule needs one D, E and F for each of r rules; given: {shapes}")
        selector = np.eye(len(enters))[:, :, None, None]
        return tuple(
            cls(enters[k], selector[k] * state, None if driven is None else selector[k] * driven)
            for k in range(len(enters))
        )


# One block, or several with a Delta each.
Uncertainty: TypeAlias = NormBounded | Sequence[NormBounded]


@dataclass(frozen=True, slots=True, eq=False)
class UncertaintyBlock:
    """A checked block: D (r, n, p), E (r, q, n), F (r, q, m)."""

    D: Array
    E: Array
    F: Array

    @property
    def enters_alike(self) -> bool:
        """Return whether D is the same in every rule."""
        return bool(np.all(self.D == self.D[:1]))

    @property
    def driven_alike(self) -> bool:
        """Return whether E and F are the same in every rule."""
        return bool(np.all(self.E == self.E[:1]) and np.all(self.F == self.F[:1]))

    def scaled(self, s: Array, tau: Array) -> UncertaintyBlock:
        """Return the block in x = s xhat, u = tau uhat, with D and E of similar size.

        D Delta E is the same for D d and E / d.  Every factor is a power of two.
        """
        D, E, F = self.D / s[:, None], self.E * s, self.F * tau
        enters = np.abs(D).max()
        driven = max(np.abs(E).max(initial=0.0), np.abs(F).max(initial=0.0))
        d = np.exp2(np.round(np.log2(driven / enters) / 2))
        return UncertaintyBlock(D * d, E / d, F / d)


def blocks_of(uncertainty: Uncertainty, r: int, n: int, m: int) -> tuple[UncertaintyBlock, ...]:
    """Return the blocks with every array as (r, ., .).

    Raises
    ------
    ModelError : no block, a shape that does not fit, an entry that is not finite, a block that
        does nothing.
    """
    blocks: tuple[NormBounded, ...] = ()
    if isinstance(uncertainty, NormBounded):
        blocks = (uncertainty,)
    elif isinstance(uncertainty, Sequence):
        blocks = tuple(uncertainty)
    if not blocks or not all(isinstance(block, NormBounded) for block in blocks):
        raise ModelError(
            f"uncertainty is {uncertainty!r}; a NormBounded is needed, or a sequence of them"
        )
    return tuple(_channel(block, k + 1, len(blocks), r, n, m) for k, block in enumerate(blocks))


def _channel(block: NormBounded, k: int, count: int, r: int, n: int, m: int) -> UncertaintyBlock:
    owner = f"uncertainty {k} of {count}"
    D, E = _stack(f"{owner}: D", block.D, r), _stack(f"{owner}: E", block.E, r)
    q = E.shape[1]
    F = np.zeros((r, q, m)) if block.F is None else _stack(f"{owner}: F", block.F, r)
    for letter, array, shape in (("D", D, (n, D.shape[2])), ("E", E, (q, n)), ("F", F, (q, m))):
        if array.shape[1:] != shape:
            raise ModelError(
                f"{owner}: {letter} is {array.shape[1]} x {array.shape[2]}; {shape[0]} x "
                f"{shape[1]} is needed, for {n} states, {m} inputs and {q} rows of E"
            )
    if not D.any() or not (E.any() or F.any()):
        idle = "D is" if not D.any() else "E and F are"
        raise ModelError(f"{owner}: {idle} zero in every rule, so it does nothing; leave it out")
    return UncertaintyBlock(D, E, F)


def _stack(owner: str, value: ArrayLike, r: int) -> Array:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"{owner} cannot be read as an array of real numbers ({error})") from error
    array = np.broadcast_to(array, (r, *array.shape)) if array.ndim == 2 else array
    if array.ndim != 3 or len(array) != r or 0 in array.shape[1:2]:
        raise ModelError(f"{owner} has shape {np.shape(value)}; ({r}, ., .) or (., .) is needed")
    if not np.isfinite(array).all():
        raise ModelError(f"{owner} has an entry that is not finite; every entry must be")
    return array
