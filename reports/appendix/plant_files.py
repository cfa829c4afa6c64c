"""The LaTeX appendix of a plant's design."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from takagi.reports.loops.plant_local import PlantLocalLoop, local_loops
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.certificates.design.plant.result import PlantDesign

Tell = Callable[[str], None]


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
    ModelError : gains that do not fit the model; a law with measured outputs, whose formulas the
        appendix does not have.
    """
    from takagi.models.errors import ModelError

    if design.output_law is not None:
        raise ModelError(
            f"plant {design.plant.name!r} has measured outputs, and the appendix has the formulas "
            "of a law of all states alone; the report (takagi report) has this law's"
        )
    from takagi.reports.appendix.assembly import assembled
    from takagi.reports.appendix.plant_context import latex_context

    say = tell or (lambda _: None)
    loop = plant_loop(design)
    say("margins")
    loops = local_loops(loop)
    say("figures")
    figures = _figures(loop, loops)
    say("LaTeX")
    return assembled("plant_body.tex.jinja", latex_context(design, loop, loops), figures)


def _figures(loop: PlantLoop, loops: Sequence[PlantLocalLoop]) -> dict[str, Figure]:
    from takagi.reports.figures.plant.captioned import AROUND, bode_drawings
    from takagi.reports.figures.plant.phase_plane import phase_figure, planes
    from takagi.reports.figures.plant.poles import vertex_poles_figure
    from takagi.reports.figures.plant.responses import responses_figure
    from takagi.reports.figures.plant.weights import premise_curves, weights_figure
    from takagi.reports.loops.plant_motion import around, motions, starts

    shown = motions(loop, starts(loop))
    found = {"responses": responses_figure(loop, shown), "poles": vertex_poles_figure(loop)}
    curves = premise_curves(loop.model)
    if curves:
        found["memberships"] = weights_figure(curves)
    if planes(loop):
        two = len(loop.names) == 2
        found["phase"] = phase_figure(loop, motions(loop, around(loop, AROUND)) if two else shown)
    for k, (_, figure) in enumerate(bode_drawings(loops), 1):
        found[f"bode-{k}" if k > 1 else "bode"] = figure
    return found
