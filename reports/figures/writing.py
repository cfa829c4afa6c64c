"""Writes a figure: SVG for HTML, PDF for LaTeX, PNG for viewing.

The same numbers give the same bytes, so that reports can be compared.
"""

from __future__ import annotations

import re
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.reports.figures.style import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Paths of more characters than this are data lines, not markers: a tenth of a point is enough.
LONG_PATH = 400
LINES = re.compile(r"([ML] \S+ \S+)((?: L \S+ \S+)+)")


def figure_to_svg(figure: Figure, *, name: str, description: str = "") -> str:
    """Return the figure as one ``<svg>`` element, ready to stand inside HTML.

    Parameters
    ----------
    name : prefix of every id in the element, so that several figures fit in one page; letters,
        digits, hyphens.
    description : text for readers who do not see the figure.

    The same figure gives the same text: ids are salted with a constant, no date is written.
    Letters are outlines, so that labels have the same position on every computer.

    Raises
    ------
    ModelError : a name that cannot be an id.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9-]*", name):
        raise ModelError(
            f"figure name {name!r} was given; it must begin with a letter and hold only letters, "
            "digits and hyphens"
        )
    buffer = BytesIO()
    with house_style():
        _settle(figure)
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue().decode("utf-8")
    body = text[text.index("<svg ") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, count=1, flags=re.DOTALL)
    body = re.sub(r"\n\s*", "\n", body)
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = body.replace('href="#', f'href="#{name}-').replace("url(#", f"url(#{name}-")
    body = _shorter(body)
    label = escape(description or name, quote=True)
    # Keeps the figure narrower than its page, also on a phone.
    fit = 'style="max-width:100%;height:auto"'
    return body.replace("<svg ", f'<svg role="img" aria-label="{label}" {fit} ', 1)


def figure_to_pdf(figure: Figure) -> bytes:
    """Return the figure as a PDF page for LaTeX, without dates."""
    buffer = BytesIO()
    metadata = {"CreationDate": None, "Creator": None, "Producer": None}
    with house_style():
        _settle(figure)
        figure.savefig(buffer, format="pdf", metadata=metadata)
    return buffer.getvalue()


def figure_to_png(figure: Figure, *, dpi: int = 100) -> bytes:
    """Return the figure as a PNG image, for looking at it; reports use SVG and PDF."""
    buffer = BytesIO()
    with house_style():
        _settle(figure)
        figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def _settle(figure: Figure) -> None:
    """Lay the figure out once for all; laying out again at each writing would move it a little."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        # The second pass sees the tick labels that the first pass made room for.
        engine.execute(figure)
        engine.execute(figure)
        # No engine, rather than one that does nothing: for any engine savefig draws twice.
        figure.set_layout_engine(None)


def _shorter(svg: str) -> str:
    """Round coordinates, to a tenth of a point in long lines, and leave out what SVG implies."""
    named = set(re.findall(r'(?:href="#|url\(#)([^")]+)', svg))
    svg = re.sub(r"<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    svg = re.sub(r' id="([^"]*)"', lambda m: m.group() if m.group(1) in named else "", svg)
    svg = re.sub(r"<g>\s*(<(?:use|path) [^>]*/>)\s*</g>", r"\1", svg)
    svg = re.sub(r'style="[^"]*"', lambda m: re.sub(r"([:;]) ", r"\1", m.group()), svg)

    def coordinates(match: re.Match[str]) -> str:
        digits = 1 if len(match.group(2)) > LONG_PATH else 2
        text = re.sub(
            r"-?\d+\.\d+", lambda number: _rounded(number.group(), digits), match.group(2)
        )
        text = re.sub(r"\s+", " ", text).strip()
        # After a move or a line, further pairs are lines: their letter is implied.  After a curve
        # they would be curves.
        return match.group(1) + LINES.sub(lambda m: m[1] + m[2].replace("L ", ""), text) + '"'

    return re.sub(r'( d="|\bx="|\by=")([^"]*)"', coordinates, svg)


def _rounded(number: str, digits: int) -> str:
    return f"{float(number):.{digits}f}".rstrip("0").rstrip(".")
