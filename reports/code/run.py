"""A program run in Python, which gives known answers for the tests of targets."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any

from takagi.reports.code.controller_program import (
    Assignment,
    Call,
    ControllerProgram,
    Formula,
    Name,
    Number,
    Operation,
    Spline,
)

_SIGNS: Mapping[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "^": math.pow,
}


class ProgramRun:
    """Runs a program sample by sample.

    kept : values of the kept names; empty before the first sample.
    names : value of every name in the last sample.
    """

    def __init__(self, program: ControllerProgram) -> None:
        self.program = program
        self.kept: dict[str, float] = {}
        self.names: Mapping[str, Any] = {}
        self._constants = {constant.name: floats(constant.value) for constant in program.constants}

    def sample(self, sample_time: float, inputs: Mapping[str, float]) -> dict[str, float]:
        """Return the outputs of one sample.

        Raises ArithmeticError, ValueError: a formula has no value at these inputs.
        """
        names = {**self._constants, "sample_time": sample_time, **inputs, **self.kept}
        for stage in self.program.stages:
            if not self.kept:
                names |= {state.name: value_of(state.start, names) for state in stage.kept}
            for assignment in stage.assignments:
                names[assignment.name] = value_of(_formula_there(assignment, names), names)
        self.names = names
        self.kept = {state.name: value_of(state.next, names) for state in self.program.kept}
        return {signal.name: names[signal.name] for signal in self.program.outputs}


def _formula_there(assignment: Assignment, names: Mapping[str, Any]) -> Formula:
    for near in assignment.near:
        if abs(value_of(near.of, names)) <= float(near.within):
            return near.formula
    return assignment.formula


def floats(value: Any) -> Any:
    """Return a constant of a file with floats in the place of its decimals."""
    if isinstance(value, Spline):
        return [[floats(row) for row in value.knots], [floats(row) for row in value.coefficients]]
    return float(value) if isinstance(value, Decimal) else [floats(number) for number in value]


def value_of(formula: Formula, names: Mapping[str, Any]) -> Any:
    """Return a formula's value; ``names`` has its constants, signals and kept values."""
    match formula:
        case Number(value):
            return float(value)
        case Name(name):
            return math.pi if name == "pi" else names[name]
        case Operation(_, None, right):
            return -value_of(right, names)
        case Operation(sign, left, right):
            assert left is not None
            return _SIGNS[sign](value_of(left, names), value_of(right, names))
        case Call(function, arguments):
            return _FUNCTIONS[function](*(value_of(argument, names) for argument in arguments))


def _limit(x: float, low: float, high: float) -> float:
    return min(max(x, low), high)


def _interval(x: float, nodes: Sequence[float]) -> int:
    return max(k for k in range(len(nodes) - 1) if k == 0 or nodes[k] <= x)


def _slope(x: float, nodes: Sequence[float], values: Sequence[float]) -> float:
    k = _interval(x, nodes)
    return (values[k + 1] - values[k]) / (nodes[k + 1] - nodes[k])


def _line(x: float, nodes: Sequence[float], values: Sequence[float]) -> float:
    k = _interval(x, nodes)
    return values[k] + _slope(x, nodes, values) * (_limit(x, nodes[0], nodes[-1]) - nodes[k])


def _spline(x: float, *arguments: Any) -> float:
    knots, rows = arguments[-1]
    if len(arguments) == 1:
        return _de_boor(x, knots[0], lambda k: rows[0][k])
    return _de_boor(x, knots[0], lambda k: _de_boor(arguments[0], knots[1], rows[k].__getitem__))


def _de_boor(x: float, t: Sequence[float], coefficient: Callable[[int], float]) -> float:
    x = _limit(x, t[3], t[-4])
    k = max(j for j in range(3, len(t) - 4) if j == 3 or t[j] <= x)
    d = [coefficient(k - 3 + j) for j in range(4)]
    for r in (1, 2, 3):
        for j in range(3, r - 1, -1):
            share = (x - t[j + k - 3]) / (t[j + 1 + k - r] - t[j + k - 3])
            d[j] = (1 - share) * d[j - 1] + share * d[j]
    return d[3]


def _mix(rules: Sequence[Sequence[float]], values: Sequence[float], *w: float) -> float:
    if len(values) == 1:
        return values[0]
    weights = (
        math.prod(v if number else 1 - v for number, v in zip(row, w, strict=True)) for row in rules
    )
    return sum(h * y for h, y in zip(weights, values, strict=True))


_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    **{
        word: getattr(math, word)
        for word in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh",
                     "cosh", "tanh", "asinh", "acosh", "atanh", "erf")
    },
    "abs": abs,
    "min": min,
    "max": max,
    "limit": _limit,
    "choose": lambda d, a, b: a if d < 0 else b,
    "first": lambda row: row[0],
    "last": lambda row: row[-1],
    "line": _line,
    "slope": _slope,
    "hold": lambda x, nodes, values: values[_interval(x, nodes)],
    "spline": _spline,
    "mix": _mix,
}  # fmt: skip
