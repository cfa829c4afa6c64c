"""Linear checks of a plant's loop: poles, Bode plots and margins at rest and at the vertices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from takagi.reports.figures.plant.captioned import captioned_bode_figures, captioned_poles_figure
from takagi.reports.figures.plant.poles import equilibrium_poles
from takagi.reports.loops.plant_local import LISTED, PlantLocalLoop
from takagi.reports.page.labels import name_of
from takagi.reports.page.text import Section, complex_words
from takagi.reports.sections.margin_table import margin_table

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop

FOLDED = 8


def poles_section(loop: PlantLoop) -> Section:
    """Return the section with the poles of vertices and of the plant at rest."""
    alone, closed = equilibrium_poles(loop)
    return Section(
        "poles",
        "Poles",
        {
            "figure": captioned_poles_figure(loop),
            "alone": ", ".join(complex_words(alone)),
            "closed": ", ".join(complex_words(closed)),
            "discrete": loop.discrete,
        },
    )


def loops_section(loop: PlantLoop, loops: Sequence[PlantLocalLoop]) -> Section:
    """Return the section with Bode plots and margins; only for a plant with a law."""
    return Section(
        "loops",
        "Bode plots and margins",
        {
            "figures": list(captioned_bode_figures(loops)),
            "table": margin_table(
                "Margins of the linear loops",
                (("place", ""), ("loop", "")),
                [((one.place, name_of(one.input)), one.margins) for one in loops],
                down=True,
                folded_from=FOLDED,
            ),
            "unstable": [
                f"{one.place}, {name_of(one.input)}" for one in loops if not one.margins.stable
            ],
            "left_out": 0 if len(loop.model.rules) <= LISTED else len(loop.model.rules),
            "discrete": loop.discrete,
            "inputs": len(loop.model.inputs),
        },
    )
