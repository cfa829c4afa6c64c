"""From the equations to the vertices: the steps of the derivation, and the proved bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.equations.equations import Step
from takagi.reports.figures.plant.captioned import Drawn
from takagi.reports.page.mathml import mathml
from takagi.reports.page.readable_latex import readable, shortens
from takagi.reports.page.text import Section
from takagi.reports.sections.premise_table import premise_table

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.ts.model import TSModel

VERTEX = "Vertex "


def derivation_section(design: PlantDesign, drawn: Drawn) -> Section:
    """Return the section with the steps of the derivation, premises and their weights."""
    model = design.model
    steps, vertices = derivation_steps(model)
    return Section(
        "derivation",
        "From equations to a Takagi–Sugeno model",
        {
            "exactness": "" if model.derivation is None else model.derivation.exactness,
            "steps": [(step.title, mathml(readable(step.latex))) for step in steps],
            "vertices": [(step.title, mathml(readable(step.latex))) for step in vertices],
            "rounded": any(shortens(step.latex) for step in steps),
            "premises": premise_table(model, "Premises with proved bounds", "bounds by"),
            "constant": [p.name for p in model.premises if len(p.corners) == 1],
            "rules": len(model.rules),
            "figures": list(drawn.captioned_figures),
        },
    )


def derivation_steps(model: TSModel) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Return the steps up to the list of rules, and the steps of the vertices, one by one."""
    steps = () if model.derivation is None else model.derivation.steps
    return (
        tuple(step for step in steps if not step.title.startswith(VERTEX)),
        tuple(step for step in steps if step.title.startswith(VERTEX)),
    )
