"""Texts of exports as templates of jinja2."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Environment


def filled(room: str, name: str, context: Mapping[str, Any]) -> str:
    """Return ``name.jinja`` of a folder below ``reports/code``, filled; nothing is escaped.

    Raises
    ------
    jinja2.UndefinedError : the template has a name that the context does not have.
    """
    return _environment(room).get_template(f"{name}.jinja").render(context)


@cache
def _environment(room: str) -> Environment:
    # Imported here: most verbs write no code.
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = files(f"takagi.reports.code.{room}")
    return Environment(
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
    )
