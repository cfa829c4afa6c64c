"""Figures of the reports: each takes plain arrays and returns a matplotlib ``Figure``.

    plant/                   the figures of a plant's design
    operation, memberships   steady operation; the blending weights
    cells, overlaps          what is certified over wind, and for which overlaps
    equilibria               how often each loop rests
    poles, bode              linear loops over wind
    running_margins          margins of the loop that runs
    response, scenario       steps and gusts; the paper's scenario
    style, writing           the one style; SVG, PDF and PNG
    captioned_figure         a drawn figure with its caption

One style for all, fit for colour-blind readers, a phone and a printed page; ``figure_to_svg`` and
``figure_to_pdf`` give the same bytes for the same numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.figures.bode import BodeLine, bode_figure, bode_line
    from takagi.reports.figures.cells import cells_figure
    from takagi.reports.figures.equilibria import equilibria_figure, rests_figure
    from takagi.reports.figures.memberships import membership_figure
    from takagi.reports.figures.operation import power_surface_figure, trim_figure
    from takagi.reports.figures.overlaps import OverlapRow, overlaps_figure
    from takagi.reports.figures.poles import poles_figure
    from takagi.reports.figures.response import ResponseLine, response_figure
    from takagi.reports.figures.running_margins import MarginLine, running_margins_figure
    from takagi.reports.figures.scenario import ScenarioRun, scenario_figure
    from takagi.reports.figures.style import decimate
    from takagi.reports.figures.writing import figure_to_pdf, figure_to_png, figure_to_svg

__all__ = [
    "BodeLine",
    "MarginLine",
    "OverlapRow",
    "ResponseLine",
    "ScenarioRun",
    "bode_figure",
    "bode_line",
    "cells_figure",
    "decimate",
    "equilibria_figure",
    "figure_to_pdf",
    "figure_to_png",
    "figure_to_svg",
    "membership_figure",
    "overlaps_figure",
    "poles_figure",
    "power_surface_figure",
    "response_figure",
    "rests_figure",
    "running_margins_figure",
    "scenario_figure",
    "trim_figure",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
