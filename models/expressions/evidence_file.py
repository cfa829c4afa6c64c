"""Evidence of a proved range as JSON data, self-contained: expression, domain, bounds, trees."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.expressions.writer import expression_text, read_back
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.cell import Cell
from takagi.models.ranges.domain import Domain
from takagi.models.ranges.evidence import LONGEST, Evidence

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.splines.table_function import TableFunction

NUMBER = re.compile(r"-?[0-9]{1,400}(/[1-9][0-9]{0,399})?")
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,99}")
PRECISIONS = range(53, 1025)
MOST_CELLS = 1000


def evidence_data(evidence: Evidence) -> dict[str, Any]:
    """Return the evidence as plain data.

    ::

        {"expression": "sin(x)/x", "bounds": ["997/1500", "1"], "precision": 128,
         "cells": [{"box": {"x": ["-1", "3/2"]}, "places": {}, "sides": ["x"], "tree": "0ss"}]}

    Numbers are exact.  A side of the box is a variable, or the coordinate that ``places`` use.

    Raises
    ------
    ModelError : an expression that the grammar of plant files has no words for, or two symbols of
        one name.
    """
    for cell in evidence.domain.cells:
        names = [symbol.name for symbol in (*cell.box, *cell.places)]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ModelError(f"the domain has two symbols called {', '.join(twice)}; rename one")
    return {
        "expression": expression_text(evidence.expression),
        "bounds": _ends(evidence.bounds),
        "precision": evidence.precision,
        "cells": [
            {
                "box": {symbol.name: _ends(side) for symbol, side in cell.box.items()},
                "places": {s.name: expression_text(place) for s, place in cell.places.items()},
                "sides": list(sides),
                "tree": tree,
            }
            for cell, sides, tree in zip(
                evidence.domain.cells, evidence.symbols, evidence.trees, strict=True
            )
        ],
    }


def evidence_of_data(
    data: Mapping[str, Any], tables: Mapping[str, type[TableFunction]] | None = None
) -> Evidence:
    """Return the evidence that ``evidence_data`` wrote.  Nothing is proved before ``replay``.

    Parameters
    ----------
    data : untrusted; its sizes are bounded.
    tables : the functions that the expression names.

    Raises
    ------
    ModelError : a field that is missing, unknown or of another form.
    """
    found = _fields(data, "evidence", "expression", "bounds", "precision", "cells")
    if type(found["precision"]) is not int or found["precision"] not in PRECISIONS:
        raise ModelError(f"evidence: precision {found['precision']!r}; 53 to 1024 bits are read")
    if not isinstance(found["cells"], list) or not 0 < len(found["cells"]) <= MOST_CELLS:
        raise ModelError(f"evidence: a list of 1 to {MOST_CELLS} cells is needed")
    members = [
        _fields(cell, f"evidence, cell {number}", "box", "places", "sides", "tree")
        for number, cell in enumerate(found["cells"], start=1)
    ]
    if sum(len(_text(cell["tree"])) for cell in members) > LONGEST:
        raise ModelError(f"evidence: trees of more than {LONGEST} characters are not read")
    cells = tuple(_cell(member) for member in members)
    symbols = {s.name: s for cell in cells for s in (*cell.box, *cell.places)}
    return Evidence(
        _interval(found["bounds"]),
        read_back(_text(found["expression"]), symbols, tables),
        Domain(cells),
        tuple(tuple(map(_name, _list(member["sides"]))) for member in members),
        tuple(member["tree"] for member in members),
        found["precision"],
    )


def _cell(data: Mapping[str, Any]) -> Cell:
    box = {_symbol(name): _interval(ends) for name, ends in _table(data["box"]).items()}
    symbols = {symbol.name: symbol for symbol in box}
    places = {
        _symbol(name): read_back(_text(text), symbols)
        for name, text in _table(data["places"]).items()
    }
    return Cell(box, places)


def _fields(data: object, place: str, *names: str) -> Mapping[str, Any]:
    found = _table(data)
    if set(found) != set(names):
        raise ModelError(
            f"{place}: fields {', '.join(sorted(map(str, found)))[:200] or 'none'} were given; "
            f"{', '.join(names)} are needed"
        )
    return found


def _table(data: object) -> Mapping[str, Any]:
    if not isinstance(data, Mapping):
        raise ModelError(f"evidence: a table is needed, not {str(data)[:40]!r}")
    return data


def _list(data: object) -> list[Any]:
    if not isinstance(data, list):
        raise ModelError(f"evidence: a list is needed, not {str(data)[:40]!r}")
    return data


def _text(data: object) -> str:
    if not isinstance(data, str):
        raise ModelError(f"evidence: a text is needed, not {str(data)[:40]!r}")
    return data


def _name(data: object) -> str:
    if not NAME.fullmatch(_text(data)):
        raise ModelError(f"evidence: {str(data)[:40]!r} is no name of a variable")
    return _text(data)


def _symbol(name: str) -> sp.Symbol:
    import sympy as sp

    return sp.Symbol(_name(name), real=True)


def _interval(data: object) -> Interval:
    ends = [_text(end) for end in _list(data)]
    if len(ends) != 2 or not all(map(NUMBER.fullmatch, ends)):
        raise ModelError(f"evidence: two rational numbers are needed, not {str(data)[:80]!r}")
    return Interval(*map(Fraction, ends))


def _ends(side: Interval) -> list[str]:
    return [str(side.lower), str(side.upper)]
