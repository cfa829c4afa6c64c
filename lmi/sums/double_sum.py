r"""The sum of h_i h_j Theta_ij that a law with memberships leads to, as terms of an LMI.

Theta_ij is a symmetric block matrix that is affine in the unknowns; i is the rule of the vertex, j
that of the gain.  A relaxation (``relaxations``) only needs weighted sums of the Theta_ij, not
their contents. Therefore every relaxation applies to every condition that is posed as a
``DoubleSum``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.condition.term import LMI, Array, Labels, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.sums.corner_rules import Corners, product_rules
from takagi.lmi.sums.summands import KnownBlock, Summand, SumPart, changes_with_gain
from takagi.lmi.sums.weighted_sum import constant_of, same_term, term_of
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError

# The result of a relaxation: its own (slack) unknowns, and the LMIs.
RelaxedSum: TypeAlias = tuple[tuple[Unknown, ...], tuple[LMI, ...]]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DoubleSum:
    """sum_ij h_i h_j Theta_ij < 0 for all memberships h.

    Attributes
    ----------
    rules : r, the number of rules.
    blocks : sizes of Theta's diagonal blocks.
    parts, fixed : Theta_ij is the sum of these parts with unknowns and of these known blocks.
    weight : the margin that Theta must have when the other LMIs have margin 1.
    name : prefix of the LMIs' names, where a condition has more than one double sum.
    corners : (r, premises) which corner of each premise rule i takes, or ``ProductRules``; None
        where the memberships are not known to be products.
    active : (r, r), False where h_i h_j = 0 at every state; None where nothing is known.
    active_rules : at most this many h_i differ from zero at one state; None where nothing is known.
    """

    rules: int
    blocks: tuple[int, ...]
    parts: tuple[SumPart, ...]
    fixed: tuple[KnownBlock, ...] = ()
    weight: float = 1.0
    name: str = ""
    corners: Corners | None = None
    active: NDArray[np.bool_] | None = None
    active_rules: int | None = None

    def __post_init__(self) -> None:
        for part in self.parts:
            for side, array in (("left", part.left), ("right", part.right)):
                if array is not None:
                    self._check_length(f"part {part.unknown.name}, {side}", array)
            self._check_member(part)
        for known in self.fixed:
            self._check_length("a fixed block", known.value)
        if self.corners is not None and product_rules(self.corners).rules != self.rules:
            raise ModelError(
                f"corners: {product_rules(self.corners).rules} rules, but there are {self.rules}; "
                "give one row for each rule"
            )
        self._check_active()

    @property
    def size(self) -> int:
        """Return the size of Theta."""
        return sum(self.blocks)

    @property
    def by_gain(self) -> bool:
        """Return whether Theta_ij may change with j."""
        return any(part.by_gain for part in self.parts) or any(
            changes_with_gain(known.value) for known in self.fixed
        )

    @property
    def most_active(self) -> int:
        """Return the largest number of rules that act at one state."""
        active_rules = self.rules if self.active_rules is None else self.active_rules
        if self.active is None:
            return active_rules
        return min(active_rules, int(self.active.sum(axis=1).max()))

    def pairs(self) -> tuple[Indices, Indices]:
        """Return (i, j), i < j, of the pairs of rules that can act together."""
        i, j = np.triu_indices(self.rules, 1)
        if self.most_active == 1:
            return i[:0], j[:0]
        if self.active is None:
            return i, j
        keep = self.active[i, j]
        return i[keep], j[keep]

    def lmi(
        self,
        name: str,
        summands: Sequence[Summand],
        slack: Sequence[Term] = (),
        *,
        count: int,
        label: Callable[[int], str],
        index: str,
        scale: float = 1.0,
        printed: float = 1.0,
    ) -> LMI:
        """Return the LMI scale (sum of the summands) + slack < 0, for each of ``count`` items.

        Parameters
        ----------
        label : a function from k to the name of item k.
        scale : a positive factor, not printed.
        printed : the ratio of the solved sum to the formula that is printed.
        """
        # A part that is the same for all (i, j) enters once, times the sum of the weights.
        total = sum((summand.totals(count) for summand in summands), np.zeros(count))
        varying = [part for part in self.parts if not part.same]
        terms = [term_of(part, summand, scale) for summand in summands for part in varying]
        terms += [same_term(part, total, scale, printed) for part in self.parts if part.same]
        constants = [
            constant
            for known in self.fixed
            for constant in constant_of(known, summands, total, scale, printed)
        ]
        prefix = f"{self.name}, " if self.name else ""
        return LMI(
            name=f"{prefix}{name}",
            blocks=self.blocks,
            terms=(*terms, *slack),
            constants=tuple(constants),
            sign=-1,
            count=count,
            weight=self.weight,
            labels=Labels(count, lambda item: f"{prefix}{label(item)}"),
            index=index,
        )

    def _check_length(self, owner: str, array: Array) -> None:
        r = self.rules
        if array.shape[:-2] not in ((1,), (r,), (r, r)):
            raise ModelError(
                f"{owner} has shape {array.shape}; (1, ., .), ({r}, ., .) or ({r}, {r}, ., .) is "
                "needed"
            )

    def _check_member(self, part: SumPart) -> None:
        r, count = self.rules, part.unknown.count
        if not isinstance(part.member, str):
            fits = part.member.shape == (r, r) and 0 <= part.member.min()
            fits = fits and int(part.member.max()) < count
        else:
            fits = part.member == "first" or count == r
        if not fits:
            raise ModelError(
                f"part {part.unknown.name} has {count} members for {r} rules; one for each rule, "
                f"or a table ({r}, {r}) of members is needed"
            )

    def _check_active(self) -> None:
        active, active_rules = self.active, self.active_rules
        if active is None and active_rules is None:
            return
        if active_rules is not None and not 1 <= active_rules <= self.rules:
            raise ModelError(
                f"active_rules is {active_rules}; 1 ... {self.rules} rules can act at a time"
            )
        r = self.rules
        if active is not None and (
            active.shape != (r, r) or not (active == active.T).all() or not active.diagonal().all()
        ):
            raise ModelError(
                f"active has shape {active.shape}; ({r}, {r}), symmetric, with every rule active "
                "by itself is needed; leave out a rule that never acts"
            )


def selections(rules: int, states: int) -> Array:
    """Return E, (rules, rules states, states): E_i' X E_j is block (i, j) of X."""
    E = np.zeros((rules, rules * states, states))
    block = np.arange(rules)[:, None] * states + np.arange(states)
    E[np.arange(rules)[:, None], block, np.arange(states)] = 1.0
    return E
