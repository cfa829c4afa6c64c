"""A rounded answer that satisfies the equalities; every LMI is decided over the rationals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from takagi.lmi.condition.exact import exact_difference, exact_matrices
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.equalities.parametrised import parametrised
from takagi.lmi.refutation.definiteness import is_definite, is_semidefinite
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ExactSolution:
    """Unknowns in rational numbers, with the test that they satisfy a condition.

    The test is about the numbers that the condition stores: a float counts as its binary value.

    Attributes
    ----------
    condition : the condition.
    values : unknown name -> (count, rows, cols) of Fractions.
    """

    condition: Condition
    values: Mapping[str, Array]

    @property
    def holds(self) -> bool:
        """Return whether all equalities and LMIs hold, exactly; each call tests them again."""
        return not self.fault()

    def fault(self) -> str:
        """Return the first equality or LMI that does not hold, in words; empty if all do."""
        for unknown in self.condition.unknowns:
            value = self.values[unknown.name]
            if unknown.symmetric and np.any(value != value.transpose(0, 2, 1)):
                return f"{unknown.name} is not symmetric"
        for equality in self.condition.equalities:
            gap = exact_difference(equality, self.values)
            for item, one in enumerate(gap):
                if (one != 0).any():
                    return f"{equality.frame().label(item)}: the two sides differ"
        for lmi in self.condition.lmis:
            test = is_definite if lmi.strict else is_semidefinite
            for item, F in enumerate(exact_matrices(self.condition, lmi, self.values)):
                if np.any(F != F.T):
                    return f"{lmi.label(item)}: the matrix is not symmetric"
                if not test(F):
                    need = "definite" if lmi.strict else "semidefinite"
                    return f"{lmi.label(item)}: the matrix is not {need}"
        return ""

    def __str__(self) -> str:
        fault = self.fault()
        if fault:
            return f"{self.condition.name}: not shown by these unknowns ({fault})"
        return (
            f"{self.condition.name}: holds in exact arithmetic, {len(self.condition.equalities)} "
            f"equalities and {sum(lmi.count for lmi in self.condition.lmis)} inequalities"
        )


def exact_solution(condition: Condition, values: Mapping[str, Any]) -> ExactSolution | None:
    """Return rational unknowns next to the given ones that satisfy every equality exactly.

    Parameters
    ----------
    values : unknown name -> (count, rows, cols), as in ``Outcome.values``.  Entries that the
        equalities leave free are kept as they are, the others are computed from them.

    Returns
    -------
    The unknowns with their test, ``holds``, which decides the LMIs too; None where the equalities
    contradict one another.

    Raises
    ------
    ModelError : an unknown without a value, or of another shape.
    """
    for unknown in condition.unknowns:
        shape = (unknown.count, unknown.rows, unknown.cols)
        if unknown.name not in values or np.shape(values[unknown.name]) != shape:
            given = "nothing" if unknown.name not in values else f"{np.shape(values[unknown.name])}"
            raise ModelError(f"unknown {unknown.name}: {given} is given; {shape} is needed")
    found = parametrised(condition)
    if found is None:
        return None
    return ExactSolution(condition=condition, values=MappingProxyType(found.exact(values)))
