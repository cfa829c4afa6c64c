r"""An exact proof that a condition has no solution: multipliers, checked with integers only.

Let Z_k >= 0 be symmetric multipliers, one for each item, such that sum_k <sign F_k(x), Z_k> has the
same value c for all unknowns x.  If some x satisfied the condition, then

    0 <= sum_k <sign F_k(x), Z_k> = c,     and 0 < c if a strict item has Z_k other than 0.

Therefore c < 0 excludes every x, and c = 0 excludes every x if a strict item has Z_k other than 0.
LMIs with a weight are strict; those without a weight, the normalisations, hold with equality
allowed.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2.3 (theorems of alternatives).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType

import numpy as np

from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.refutation.adjoint import Adjoint, adjoint, over_one_denominator
from takagi.lmi.refutation.indefinite import fault_of_function, is_semidefinite
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Alternative:
    """A proof that no unknowns satisfy a condition: exact multipliers, or a function that decays.

    The proof is about the numbers that the condition stores.  A float counts as the exact dyadic
    number that it represents; rounding by the builder of the condition is part of the condition.

    Attributes
    ----------
    condition : the condition without a solution.
    multipliers : LMI -> (items, size, size) of Fractions; the multipliers of other LMIs are zero.
    function : the unknown -> (1, n, n) of Fractions: a value that satisfies one item but is not
        positive definite (``indefinite``).  It is used if there are no multipliers.
    """

    condition: Condition
    multipliers: Mapping[str, Array] = field(default_factory=dict)
    function: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("multipliers", "function"):
            exact = {key: fractions(value) for key, value in getattr(self, name).items()}
            object.__setattr__(self, name, MappingProxyType(exact))

    @property
    def holds(self) -> bool:
        """Return whether it is a proof; each call checks everything again in exact arithmetic."""
        return not self.fault()

    def fault(self) -> str:
        """Return the reason why it is not a proof; an empty text if it is one.

        Raises
        ------
        ModelError : a multiplier of an LMI that is not there, or of another shape.
        """
        if self.function and not self.multipliers:
            return fault_of_function(self.condition, self.function)
        read = adjoint(self.condition)
        z = multiplier_entries(read, self.multipliers)
        for block in read.blocks:
            name = self.condition.lmis[block.lmi].name
            if name in self.multipliers:
                Z = self.multipliers[name][block.item]
                if np.any(Z != Z.T):
                    return f"the multiplier of {read.name(block)} is not symmetric"
                if not is_semidefinite(Z):
                    return f"the multiplier of {read.name(block)} is not positive semidefinite"
        # One denominator for all: sums of integers are quicker than sums of fractions.
        z, denominator = over_one_denominator(z)
        nonzero = np.flatnonzero(read.products(z))
        if len(nonzero):
            return f"the sum depends on {_number_name(self.condition, int(nonzero[0]))}"
        constant = Fraction(int(read.constant @ z), denominator * read.denominator)
        if constant > 0:
            return f"the sum is {float(constant):.3g}; it must not be positive"
        strict = any(z[block.index].any() for block in read.blocks if read.strict(block))
        return "" if constant < 0 or strict else "the multipliers of the strict LMIs are all zero"

    def __str__(self) -> str:
        fault = self.fault()
        if fault:
            return (
                f"{self.condition.name}: nothing is shown by these multipliers, because {fault}; "
                "take them from exact_no, whose are exact"
            )
        if not self.multipliers:
            return (
                f"{self.condition.name}: no unknowns satisfy it; an exact function that decays at "
                "one vertex without being positive definite rules it out by that vertex alone"
            )
        count = sum(int(np.any(Z != 0)) for Zs in self.multipliers.values() for Z in Zs)
        return (
            f"{self.condition.name}: no unknowns satisfy it; {count} exact multipliers show that "
            "its inequalities contradict one another"
        )


def multiplier_entries(read: Adjoint, multipliers: Mapping[str, Array]) -> Array:
    """Return z, (columns,): the entries of the multipliers on and above the diagonal.

    Raises
    ------
    ModelError : a multiplier of an LMI that is not there, or of another shape.
    """
    names = [lmi.name for lmi in read.condition.lmis]
    for name, value in multipliers.items():
        if name not in names:
            raise ModelError(
                f"there is no LMI {name!r} in {read.condition.name}; it has {', '.join(names)}"
            )
        lmi = read.condition.lmis[names.index(name)]
        if np.shape(value) != (lmi.count, lmi.size, lmi.size):
            raise ModelError(
                f"the multipliers of {name!r} have shape {np.shape(value)}; "
                f"{(lmi.count, lmi.size, lmi.size)} is needed"
            )
    z = np.zeros(read.columns, dtype=object)
    for block in read.blocks:
        name = names[block.lmi]
        if name in multipliers:
            z[block.index] = _upper(multipliers[name][block.item])
    return z


def _upper(Z: Array) -> Array:
    """Return the matrix whose entries below the diagonal are those above it."""
    return np.asarray(np.where(np.tri(len(Z), k=-1, dtype=bool), Z.T, Z))


def _number_name(condition: Condition, number: int) -> str:
    for unknown in condition.unknowns:
        if number < unknown.length:
            member, entry = divmod(number, unknown.entries)
            row, column = np.argwhere(unknown.entry_index() == entry)[0]
            member_text = f"{member + 1}" if unknown.count > 1 else ""
            return f"{unknown.name}{member_text}[{row}, {column}]"
        number -= unknown.length
    raise AssertionError("no unknown has that number")
