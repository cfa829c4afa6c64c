"""The language of the programs in a gain file, and the elements of a program.

A program computes one sample of a controller. Its formulas use the grammar of plant files and a few
more functions. A program contains no numbers: names refer to their places in the file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

Item = dict[str, Any]
WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w*\s*\()", re.ASCII)

LANGUAGE = {
    "order": "at every sample the programs run in their order, in each the steps, then what is "
    "sent, in theirs; a later program reads what an earlier one sends. At the end every kept value "
    "becomes its 'next', in which the names of its program and all that was sent may stand; "
    "before the first sample it is its 'start'",
    "names": "value is a path in this file: members and rows from 0, with a dot between them, * "
    "for all rows; where a text stands there it is a formula without names",
    "sample_time": "T [s], from one sample to the next",
    "formula": "+ - * / ^ with parentheses, numbers and names; -x^2 is -(x^2) and 2^3^2 is "
    "2^(3^2); pi, abs, sqrt, exp, log, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, asinh, "
    "acosh, atanh, erf",
    "near": "where |of| <= within, this formula stands in the place of the step's: there the "
    "step's own is 0/0, or loses digits",
    "min(a, b), max(a, b)": "the smaller, the larger",
    "limit(x, a, b)": "x held within a and b: min(max(x, a), b)",
    "choose(d, a, b)": "a where d < 0, else b",
    "first(X), last(X)": "the first, the last number of a row",
    "line(x, X, Y)": "linear between the nodes X, Y; x is held within the first and last node",
    "slope(x, X, Y)": "(Y[k+1] - Y[k])/(X[k+1] - X[k]) where X[k] <= x < X[k+1]; beyond the nodes "
    "that of the first or last interval",
    "hold(x, X, Y)": "Y[k] where X[k] <= x < X[k+1]; beyond the nodes the first or last of Y",
    "mix(R, Y, w1, w2, ...)": "sum over rules i of Y[i] times, for each premise k, wk where "
    "R[i][k] = 1 and 1 - wk where R[i][k] = 0; of a Y with one entry that entry",
    "spline(x, S), spline(x, y, S)": "sum of S.coefficients times the cubic B-splines over "
    "S.knots, a row of knots for each argument; an argument is held within the knots",
}


def read(name: str, unit: str, meaning: str) -> Item:
    return {"name": name, "unit": unit, "meaning": meaning}


def keep(name: str, unit: str, start: str, following: str, meaning: str) -> Item:
    return {"name": name, "unit": unit, "start": start, "next": following, "meaning": meaning}


def step(name: str, unit: str, formula: str, meaning: str = "", removable: Any = ()) -> Item:
    entry = {"set": name, "unit": unit, "formula": formula, "meaning": meaning}
    return entry | ({"near": list(removable)} if removable else {})


def send(name: str, unit: str, formula: str, meaning: str) -> Item:
    return {"name": name, "unit": unit, "formula": formula, "meaning": meaning}


def program(
    name: str,
    names: dict[str, tuple[str, str]],
    *,
    reads: list[Item],
    keeps: list[Item],
    steps: list[Item],
    sends: list[Item],
) -> Item:
    """Return a program; ``names`` has (path, unit)."""
    return {
        "name": name,
        "names": {key: {"value": path, "unit": unit} for key, (path, unit) in names.items()},
        "read": reads,
        "keep": keeps,
        "steps": steps,
        "send": sends,
    }


def names_in(formulas: Iterable[str]) -> set[str]:
    """Return the names in formulas, without function names."""
    return {name for formula in formulas for name in WORD.findall(formula)}
