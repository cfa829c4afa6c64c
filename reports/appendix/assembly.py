"""The appendix as files: LaTeX that compiles alone, its body, and the figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.reports.appendix.environment import render
from takagi.reports.appendix.tex import Tex, escape

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
