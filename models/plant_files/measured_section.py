"""The field ``measured`` of a plant file -> the outputs that the law uses instead of the states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from takagi.models.errors import did_you_mean
from takagi.models.plant.variables import Output

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.files.toml_document import Document
    from takagi.models.plant.entries import MeasuredEntry, PlantEntry
    from takagi.models.plant.plant import Plant

FIELD = "measured"


def with_measured(
    document: Document,
    entry: PlantEntry,
    plant: Plant,
    read: Callable[[str, str], sp.Expr],
    si_unit: Callable[[str, str], str],
) -> Plant:
    """Return the plant with an output for each measured quantity, and the names of these outputs.

    An entry names an output, or a state; a state gets an output of the same name.

    Parameters
    ----------
    read : place in the file and text -> expression.
    si_unit : place in the file and text -> the unit; it raises if the unit is not SI.

    Raises
    ------
    ModelError : with file, line and field: an empty list; a name that is neither an output nor a
        state, or occurs twice; an expression with other variables than states and inputs; a plant
        with a blend.
    """
    assert entry.measured is not None  # checked by the caller
    if entry.blending is not None:
        raise document.error(
            FIELD, "output feedback is not for a plant with [blending]; leave one of them out"
        )
    if not entry.measured:
        raise document.error(
            FIELD, "nothing is measured; name outputs or states, or leave it out for all states"
        )
    if not plant.inputs:
        raise document.error(FIELD, "the plant has no input, so no law needs what is measured")
    outputs = list(plant.outputs)
    names: list[str] = []
    for one in entry.measured:
        if one.name in names:
            raise document.error(FIELD, f"{one.name} stands in it twice; leave one out")
        names.append(one.name)
        if one.expression is None:
            added = _named(document, plant, outputs, one)
        else:
            _check_new(document, plant, one)
            added = Output(one.name, read(FIELD, one.expression), si_unit(FIELD, one.unit))
        if added is not None:
            outputs.append(added)
    known = {v.symbol for v in (*plant.states, *plant.inputs)}
    known |= {p.symbol for p in plant.parameters}
    for output in outputs:
        strange = sorted(str(s) for s in output.expression.free_symbols - known)
        if output.name in names and strange:
            raise document.error(
                FIELD,
                f"{output.name} depends on {', '.join(strange)}, which comes from outside; "
                "what is measured is of states and inputs",
            )
    return replace(plant, outputs=tuple(outputs), measured=tuple(names))


def _named(
    document: Document, plant: Plant, outputs: Sequence[Output], one: MeasuredEntry
) -> Output | None:
    """Return the output of a measured state; None for an output that the plant already has."""
    states = {v.name: v for v in plant.states}
    given = {y.name: y for y in outputs}
    state, output = states.get(one.name), given.get(one.name)
    if one.unit != "-":
        raise document.error(FIELD, f"{one.name} has a unit of its own; leave the unit out")
    if output is None and state is None:
        known = (*given, *(name for name in states if name not in given))
        raise document.error(
            FIELD,
            f"{one.name} is neither an output nor a state{did_you_mean(one.name, known)}; those "
            f"are {', '.join(known)}; of another quantity give name, expression and unit",
        )
    if output is None and state is not None:
        return Output(state.name, state.symbol, state.unit)
    if state is not None and output is not None and output.expression != state.symbol:
        raise document.error(
            FIELD, f"{one.name} is a state and another output; rename the output in [outputs]"
        )
    return None


def _check_new(document: Document, plant: Plant, one: MeasuredEntry) -> None:
    taken = {v.name for v in plant.variables} | {p.symbol.name for p in plant.parameters}
    taken |= {y.name for y in plant.outputs}
    if one.name in taken:
        raise document.error(
            FIELD, f"{one.name} has a meaning already; give what is measured a name of its own"
        )
