r"""The jinja2 environment for LaTeX; it escapes everything that is not marked as LaTeX.

The usual delimiters of jinja2 have a meaning in LaTeX, so that these are used:

\VAR{expression}    \BLOCK{statement}    \#{comment}
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

from takagi.reports.appendix.tex import (
    Tex,
    decimal,
    escape,
    interval,
    scientific,
    unit,
    with_decimals,
)

if TYPE_CHECKING:
    from jinja2 import Environment

_TEMPLATES = "takagi.reports.appendix.templates"


def render(template: str, context: Mapping[str, object]) -> str:
    """Return a template filled; a name that the context does not have is an error."""
    return _environment().get_template(template).render(context)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        block_start_string=r"\BLOCK{",
        block_end_string="}",
        variable_start_string=r"\VAR{",
        variable_end_string="}",
        comment_start_string=r"\#{",
        comment_end_string="}",
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
        undefined=StrictUndefined,
        finalize=escape,
        loader=FunctionLoader(_source),
    )
    environment.filters.update(
        decimal=decimal,
        fixed=with_decimals,
        interval=interval,
        row=_row,
        scientific=scientific,
        unit=unit,
    )
    return environment


def _row(cells: Iterable[object]) -> Tex:
    """Return one row of a table."""
    return Tex(" & ".join(escape(cell) for cell in cells) + r" \\")


def _source(name: str) -> str:
    return files(_TEMPLATES).joinpath(name).read_text(encoding="utf-8")
