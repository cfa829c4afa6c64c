"""Figures of the reports: each takes plain arrays and returns a matplotlib ``Figure``.

    plant/                   the figures of a plant's design
    operation, memberships   steady operation; the blending weights
    cells, overlaps          what is certified over wind, and for which overlaps
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
    from takagi.reports.figures.cells import OverlapRow as OverlapRow
    from takagi.reports.figures.cells import cells_figure as cells_figure
    from takagi.reports.figures.cells import overlaps_figure as overlaps_figure
    from takagi.reports.figures.loops import BodeLine as BodeLine
    from takagi.reports.figures.loops import MarginLine as MarginLine
    from takagi.reports.figures.loops import bode_figure as bode_figure
    from takagi.reports.figures.loops import bode_line as bode_line
    from takagi.reports.figures.loops import poles_figure as poles_figure
    from takagi.reports.figures.loops import (
        running_margins_figure as running_margins_figure,
    )
    from takagi.reports.figures.operation import membership_figure as membership_figure
    from takagi.reports.figures.operation import power_surface_figure as power_surface_figure
    from takagi.reports.figures.operation import trim_figure as trim_figure
    from takagi.reports.figures.response import ResponseLine as ResponseLine
    from takagi.reports.figures.response import ScenarioRun as ScenarioRun
    from takagi.reports.figures.response import response_figure as response_figure
    from takagi.reports.figures.response import scenario_figure as scenario_figure
    from takagi.reports.figures.style import decimate as decimate
    from takagi.reports.figures.style import figure_to_pdf as figure_to_pdf
    from takagi.reports.figures.style import figure_to_png as figure_to_png
    from takagi.reports.figures.style import figure_to_svg as figure_to_svg

__getattr__, __dir__ = lazy_names(__name__)
