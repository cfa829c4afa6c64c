"""Solve one condition at many values of a parameter, assembled once and with one solver."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.assemble import assemble
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.solver.solve import Session
from takagi.models.errors import ModelError


def sweep(
    condition: Condition,
    name: str,
    values: Iterable[float],
    *,
    stage: Callable[..., Outcome] = decide,
    **options: Any,
) -> Iterator[tuple[float, Outcome]]:
    """Yield (value, outcome) for each value of the parameter; each is solved when it is requested.

    Verdicts, margins and objectives agree with separate calls, to solver accuracy.  The unknowns
    may differ in their last digits, because the solver keeps the scaling of the first problem.

    Parameters
    ----------
    name : the parameter that is varied.
    values : values in any order and number; a value may depend on the outcomes before it.
    stage : ``decide`` or ``optimise``.
    options : keyword arguments of the stage.

    Raises
    ------
    ModelError : the condition has no such parameter, or a value is not finite.
    """
    if name not in condition.parameters:
        names = ", ".join(condition.parameters) or "none"
        raise ModelError(
            f"condition {condition.name}: there is no parameter {name!r} to vary; there are {names}"
        )
    return _swept(condition, name, values, stage, options)


def _swept(
    condition: Condition,
    name: str,
    values: Iterable[float],
    stage: Callable[..., Outcome],
    options: dict[str, Any],
) -> Iterator[tuple[float, Outcome]]:
    data, session = assemble(condition), Session()
    for raw_value in values:
        value = float(number(name, raw_value))
        outcome = stage(
            condition, parameters={name: value}, assembled=data, session=session, **options
        )
        yield value, outcome
