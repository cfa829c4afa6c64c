"""Expressions written in the grammar that plant files have, so that they can be read again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.ranges.table_balls import tables_class

if TYPE_CHECKING:
    import sympy as sp


def expression_text(expression: sp.Expr) -> str:
    """Return the expression as plant files write it, e.g. ``"x*sin(2*y)/(3/2 - cos(x)^2)"``.

    Symbols stand by their names; a dummy symbol must not have another one's.

    Raises
    ------
    ModelError : what the grammar has no word for (Max, a table's slope), or two symbols of one
        name.
    """
    import sympy as sp

    names = [symbol.name for symbol in expression.free_symbols]
    if len(set(names)) < len(names):
        raise ModelError(f"{expression} has two symbols of one name; rename one")
    # Real symbols, as those of a file are: what is compared below is then what will be read.
    plain = expression.xreplace({s: sp.Symbol(s.name, real=True) for s in expression.free_symbols})
    text = str(plain).replace("**", "^").replace("Abs(", "abs(")
    tables = tables_class()
    calls = () if tables is None else plain.atoms(tables)
    known = {type(call).__name__: type(call) for call in calls if not any(call.orders)}
    try:
        found = read_back(text, {s.name: s for s in plain.free_symbols}, known)
    except ModelError as error:
        raise ModelError(
            f"{expression} cannot be written in the grammar of plant files: {error}"
        ) from error
    if found != plain and sp.expand(found - plain) != 0:
        raise ModelError(f"{expression} is not what is read again from {text!r}; write it plainly")
    return text


def read_back(
    text: str, symbols: Mapping[str, sp.Symbol], tables: Mapping[str, object] | None = None
) -> sp.Expr:
    """Return the expression that the text stands for.

    Raises
    ------
    ModelError : as ``parse_expression``.
    """
    from takagi.models.expressions.parser import Scope, parse_expression

    return parse_expression(text, Scope(symbols, {}, dict(tables or {})))  # type: ignore[arg-type]
