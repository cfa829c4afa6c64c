"""Limits of a program that are numbers of its file: the lower one must not be above the upper one.

``limit(x, low, high)`` is min(max(x, low), high): with the limits in the wrong order it is ``high``
whatever x is, so that the program would send one value at all times.
"""

from __future__ import annotations

from collections.abc import Iterator

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.formula import Call, Formula, Operation, names_of
from takagi.reports.code.run import floats, value_of

RATES = ("limits.torque_rate", "limits.pitch_rate")


def require_order(program: ControllerProgram) -> None:
    """Refuse limits in the wrong order; those that are known in a sample only are not looked at.

    Raises
    ------
    ModelError : names the entries of the file, and both limits.
    """
    places = {one.name: one.place for one in program.constants}
    numbers = {one.name: floats(one.value) for one in program.constants}
    for one in program.constants:
        if one.place in RATES and numbers[one.name] < 0:
            raise ModelError(f"{one.place} is {numbers[one.name]:g}; 0 or more is needed")
    for low, high in _limits(program):
        names = [*names_of(low), *names_of(high)]
        if not set(names) <= set(numbers):
            continue
        least, most = value_of(low, numbers), value_of(high, numbers)
        if least > most:
            told = " and ".join(dict.fromkeys(places[name] for name in names))
            raise ModelError(
                f"{told}: the lower limit is {least:g} and the upper one {most:g}, so that the "
                "program would send the upper one at all times; exchange them, or give the "
                "gains.json that `takagi design` has written"
            )


def _limits(program: ControllerProgram) -> Iterator[tuple[Formula, Formula]]:
    """Yield the lower and the upper limit of every ``limit`` in a program."""
    for kept in program.kept:
        yield from _of(kept.start)
        yield from _of(kept.next)
    for one in program.assignments:
        for formula in (one.formula, *(place.formula for place in one.near)):
            yield from _of(formula)


def _of(formula: Formula) -> Iterator[tuple[Formula, Formula]]:
    match formula:
        case Operation(_, left, right):
            yield from (() if left is None else _of(left))
            yield from _of(right)
        case Call(function, arguments):
            if function == "limit":
                yield arguments[1], arguments[2]
            for argument in arguments:
                yield from _of(argument)
