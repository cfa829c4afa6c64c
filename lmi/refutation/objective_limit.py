"""A condition whose objective must lie below a number; a proof of "no" bounds the objective."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.models.errors import ModelError


def objective_below(condition: Condition, value: float | Fraction) -> Condition:
    """Return the condition with its objective < value as one more LMI, and no objective.

    If ``exact_no`` proves that it has no solution, the least objective of the condition is at least
    the value. This is a rigorous lower bound on the cost or the norm that this condition can show.

    Raises
    ------
    ModelError : a condition without an objective, or a value that is not a finite number.
    """
    if not condition.objective:
        raise ModelError(
            f"{condition.name} has no objective, and so no least value to bound; give a condition "
            "that minimises something, or ask exact_no about this one as it is"
        )
    value = number("value", value)
    by_name = {unknown.name: unknown for unknown in condition.unknowns}
    limit = LMI(
        name="objective",
        blocks=(1,),
        terms=tuple(_term(by_name[name], cost) for name, cost in condition.objective.items()),
        constants=(Constant(value=np.full((1, 1, 1), -value), latex=f"-{float(value):.6g}"),),
        sign=-1,
        weight=abs(float(value)) or 1.0,
    )
    return Condition(
        name=f"{condition.name}, objective below {float(value):.6g}",
        unknowns=condition.unknowns,
        lmis=(*condition.lmis, limit),
        parameters=condition.parameters,
        source=condition.source,
        equalities=condition.equalities,
    )


def _term(unknown: Unknown, cost: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> Term:
    """Return the sum of entrywise products, column by column: c_j' X e_j."""
    members = np.repeat(np.arange(unknown.count), unknown.cols)
    columns = np.tile(np.eye(unknown.cols)[:, :, None], (unknown.count, 1, 1))
    left = cost.transpose(0, 2, 1).reshape(-1, 1, unknown.rows)
    return Term(
        unknown=unknown,
        left=left,
        right=columns,
        items=np.zeros(len(members), dtype=np.intp),
        members=members,
        latex=(r"\langle c, ", r"\rangle"),
    )
