"""The LaTeX appendix of a design, a turbine's or another plant's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.laws.protocol import law_words
from takagi.reports.appendix.plant_context import latex_context
from takagi.reports.appendix.tex import assembled, certificate_context
from takagi.reports.appendix.turbine import (
    conditions,
    drawn_figures,
    law_context,
    margins_context,
    plant_context,
    region_context,
    shown_runs,
)
from takagi.reports.figures.loops import responses_figure
from takagi.reports.figures.plant.captioned import (
    AROUND,
    bode_drawings,
    premise_curves,
    weights_figure,
)
from takagi.reports.figures.plant.proved_set import phase_figure, planes
from takagi.reports.loops.plant_local import PlantLocalLoop, local_loops
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop
from takagi.reports.loops.plant_motion import around, motions, starts
from takagi.reports.sections.turbine.running import response_words
from takagi.reports.simulation.plant import jump_motions

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Tell = Callable[[str], None]


def appendix_files(design: TurbineDesign, *, tell: Tell | None = None) -> dict[str, bytes | str]:
    """Return relative file name -> content of the LaTeX appendix of a design.

    ``appendix.tex`` compiles alone with pdflatex; ``appendix-body.tex`` is for ``\\input`` into a
    paper with the packages that its first lines name; ``figures/*.pdf`` are the figures.  The same
    design gives the same bytes: there is no date in them.

    Parameters
    ----------
    tell : called with a word before each step.
    """
    say = tell or (lambda _: None)
    say("margins")
    margins = margins_context(design)
    say("figures")
    figures = drawn_figures(design)
    say("LaTeX")
    context: dict[str, object] = {
        **plant_context(design),
        **law_context(design),
        "conditions": list(conditions(design)),
        **certificate_context(design),
        **margins,
        "responses": [(name, response_words(run)) for name, run in shown_runs(design).items()],
        "partial": region_context(design.partial_load, design.regional.partial, "b"),
        "full": region_context(design.full_load, design.regional.full, "c"),
        "subject": design.turbine.name,
        "title": f"{design.turbine.name}: multi-region controller design",
        "subtitle": f"Takagi-Sugeno models, {law_words(design.law.name)}, theorems and margins",
        "contents": True,
    }
    return assembled("turbine_body.tex.jinja", context, figures)


def plant_appendix(design: PlantDesign, *, tell: Tell | None = None) -> dict[str, bytes | str]:
    """Return relative file name -> content of the LaTeX appendix of a plant's design.

    ``appendix.tex`` compiles alone with pdflatex; ``appendix-body.tex`` is for ``\\input`` into a
    paper with the packages that its first lines name; ``figures/*.pdf`` are the figures.  The same
    design gives the same bytes: there is no date in them.

    Parameters
    ----------
    tell : called with a word before each step.

    Raises
    ------
    ModelError : gains that do not fit the model.
    """
    say = tell or (lambda _: None)
    loop = plant_loop(design)
    say("margins")
    loops = local_loops(loop)
    say("figures")
    figures = _figures(design, loop, loops)
    say("LaTeX")
    return assembled("plant_body.tex.jinja", latex_context(design, loop, loops), figures)


def _figures(
    design: PlantDesign, loop: PlantLoop, loops: Sequence[PlantLocalLoop]
) -> dict[str, Figure]:
    responses = motions(loop, starts(loop))
    figures = {"responses": responses_figure(loop, responses)}
    # V is a function of deviations from the rest before the jump.
    jumps = [replace(run, value=np.zeros(0)) for run in jump_motions(design, loop)]
    if jumps:
        figures["jumps"] = responses_figure(loop, jumps)
    curves = premise_curves(loop.model)
    if curves:
        figures["memberships"] = weights_figure(curves)
    if planes(loop):
        two = len(loop.names) == 2
        figures["phase"] = phase_figure(
            loop, motions(loop, around(loop, AROUND)) if two else responses
        )
    for k, (_, figure) in enumerate(bode_drawings(loops), 1):
        figures[f"bode-{k}" if k > 1 else "bode"] = figure
    return figures
