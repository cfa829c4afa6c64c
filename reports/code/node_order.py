"""Nodes of a program's tables: they must increase, in the floats that the code computes with.

``line`` and ``slope`` divide by the distance of two nodes.  Two decimals may differ and be one
float: then nothing finite is computed there.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import frexp, ldexp

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.formula import Call, Formula, Name, Operation
from takagi.reports.code.run import floats

# Functions whose second argument is a row of nodes, and the digits of a float of each precision.
BETWEEN_NODES = ("line", "slope", "hold")
BITS = {"double": 53, "float": 24}


def require_nodes(program: ControllerProgram, precision: str) -> None:
    """Refuse nodes that do not increase as floats of this precision, "double" or "float".

    Raises
    ------
    ModelError : names the row of the file.
    """
    rows = {one.name: one for one in program.constants}
    for name in dict.fromkeys(_nodes(program)):
        values = [_rounded(value, BITS[precision]) for value in floats(rows[name].value)]
        for k, (low, high) in enumerate(pairwise(values)):
            if high <= low:
                cure = "; give --precision double for this law" if precision == "float" else ""
                raise ModelError(
                    f"{rows[name].place}: nodes {k} and {k + 1} do not increase as numbers of type "
                    f"{precision}, so that the program would divide by zero between them{cure}"
                )


def _rounded(value: float, bits: int) -> float:
    """Return the nearest number with so many binary digits."""
    share, power = frexp(value)
    return ldexp(round(ldexp(share, bits)), power - bits)


def _nodes(program: ControllerProgram) -> Iterator[str]:
    """Yield the names of constants that are nodes."""
    known = {one.name for one in program.constants}
    formulas = [formula for kept in program.kept for formula in (kept.start, kept.next)]
    for one in program.assignments:
        formulas += [one.formula, *(place.formula for place in one.near)]
    for formula in formulas:
        for call in _calls(formula):
            if call.function in BETWEEN_NODES and len(call.arguments) > 1:
                row = call.arguments[1]
                if isinstance(row, Name) and row.name in known:
                    yield row.name


def _calls(formula: Formula) -> Iterator[Call]:
    match formula:
        case Operation(_, left, right):
            yield from (() if left is None else _calls(left))
            yield from _calls(right)
        case Call(_, arguments):
            yield formula
            for argument in arguments:
                yield from _calls(argument)
