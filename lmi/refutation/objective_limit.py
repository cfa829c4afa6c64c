"""A condition whose objective must lie below a number; a proof of "no" bounds the objective."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from takagi.lmi.answer import Answer, Design
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.models.errors import ModelError


def objective_below(asked: Condition | Answer | Design, value: float | Fraction) -> Condition:
    """Return the condition with its objective < value as one more LMI, and no objective.

    If ``exact_no`` proves that it has no solution, the least objective of the condition is at least
    the value. This is a rigorous lower bound on the cost or the norm that this condition can show.

    Parameters
    ----------
    asked : an answer or a design that minimised something: the value is its gain or its cost, in
        the units of the model, y over w or that of the weights.  Or a condition: the value is its
        objective as it is posed, without any units.
    value : of an answer converted to the units in which its condition is posed, by a product in
        floating point; what is proved is about the condition that is returned.

    Raises
    ------
    ModelError : a condition without an objective, an answer that minimised nothing, or a value that
        is no finite number, or that no objective has.
    """
    value = number("value", value)
    if isinstance(asked, Design):
        asked = asked.answer
    if isinstance(asked, Answer):
        unit = asked.objective_unit
        if asked.condition is None or unit is None or not asked.condition.objective:
            raise ModelError(
                f"this answer ({asked.status}) minimised no gain and no cost in a condition, so "
                "there is no least value to bound; give one of hinf_norm, h2_norm, hinf_pdc, "
                "h2_pdc, peak_pdc or lqr_pdc, or a condition with an objective"
            )
        posed = _below(asked.condition, unit.objective(float(value)))
        return replace(posed, name=f"{asked.condition.name}, {unit.quantity} below {value:.6g}")
    return _below(asked, value)


def _below(condition: Condition, value: float | Fraction) -> Condition:
    """Return the condition with its objective, as it is posed, below a value."""
    if not condition.objective:
        raise ModelError(
            f"{condition.name} has no objective, and so no least value to bound; give a condition "
            "that minimises something, or ask exact_no about this one as it is"
        )
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
