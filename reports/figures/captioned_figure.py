"""A drawn figure with its caption, for a page and as a file of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.reports.figures.writing import figure_to_svg
from takagi.reports.page.text import CaptionedFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def captioned_figure(
    figure: Figure, name: str, *, caption: str, alternative: str
) -> CaptionedFigure:
    """Return a drawn figure with its caption; its SVG is in the page and in a file of its own."""
    svg = figure_to_svg(figure, name=name, description=alternative)
    return CaptionedFigure(name, svg, caption, alternative)
