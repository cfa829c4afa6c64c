r"""The appendix as files: LaTeX that compiles alone, its body, and the figures.

The jinja2 environment for LaTeX; it escapes everything that is not marked as LaTeX.

The usual delimiters of jinja2 have a meaning in LaTeX, so that these are used:

\VAR{expression}    \BLOCK{statement}    \#{comment}
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.result import Checked, Verdict
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
    from matplotlib.figure import Figure


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


def assembled(
    body: str, context: Mapping[str, object], drawn: Mapping[str, Figure]
) -> dict[str, bytes | str]:
    """Return relative file name -> content of the appendix.

    Parameters
    ----------
    body : the template of the body.
    context : the names that the templates use; the main template needs subject, title, subtitle,
        and whether there is a table of contents.
    drawn : name -> figure.
    """
    from takagi.reports.figures import figure_to_pdf

    figures = {f"{name}.pdf": figure_to_pdf(figure) for name, figure in drawn.items()}
    known = {**context, "figures": sorted(figures)}
    files: dict[str, bytes | str] = {
        "appendix.tex": render("appendix.tex.jinja", known),
        "appendix-body.tex": render(body, known),
    }
    return files | {f"figures/{name}": data for name, data in figures.items()}


def checked_context(document: Mapping[str, Any], checked: Checked) -> dict[str, Any]:
    """Return the checker's verdict and sentences, and the certificate's hashes and versions."""
    provenance = document.get("provenance", {})
    return {
        "proved": checked.verdict is Verdict.PROVED,
        "verdict": checked.verdict.name,
        "verdict_text": checked.verdict.value,
        "verdicts": [
            {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
            for claim in checked.claims
        ],
        "messages": list(checked.messages),
        "hashes": [
            [escape(name), Tex(rf"\texttt{{{escape(value)}}}")]
            for name, value in provenance.get("sha256", {}).items()
        ],
        "versions": ", ".join(f"{k} {v}" for k, v in provenance.get("versions", {}).items()),
        "loop": None,
    }
