"""Calls of tables in a formula: from the form of plant files to that of programs.

A plant file calls a table by its name, friction(omega); in a program it is spline(omega, friction).
"""

from __future__ import annotations

import re
from collections.abc import Collection


def with_splines(formula: str, tables: Collection[str]) -> str:
    """Return the formula with ``name(x, ...)`` as ``spline(x, ..., name)`` for each table."""
    for name in tables:
        found = re.search(rf"(?<![\w.]){re.escape(name)}\s*\(", formula, re.ASCII)
        while found:
            start, end = found.end(), _closing(formula, found.end())
            inner = formula[start:end]
            # The name now follows a comma, so it is not found again.
            formula = f"{formula[: found.start()]}spline({inner}, {name}{formula[end:]}"
            found = re.search(rf"(?<![\w.]){re.escape(name)}\s*\(", formula, re.ASCII)
    return formula


def _closing(formula: str, start: int) -> int:
    """Return the place of the bracket that closes the one before ``start``."""
    depth = 1
    for place in range(start, len(formula)):
        depth += {"(": 1, ")": -1}.get(formula[place], 0)
        if depth == 0:
            return place
    raise ValueError(f"{formula[:60]!a} has a bracket that is not closed")
