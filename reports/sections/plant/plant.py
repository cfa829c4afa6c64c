"""The equations as given, and the steps from them to the vertices of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.equations.derivation_step import Step
from takagi.reports.figures.plant.captioned import Drawn
from takagi.reports.page.mathml import mathml, readable, shortens
from takagi.reports.page.text import Section, decimal, table
from takagi.reports.sections.shared import premise_table

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.plant import Plant, Variable
    from takagi.models.ts.model import TSModel


def plant_section(design: PlantDesign) -> Section:
    """Return the section about the plant as its file gives it."""
    plant = design.plant
    import sympy as sp

    return Section(
        "plant",
        "The plant",
        {
            "description": plant.description,
            "source": plant.source,
            "sample_time": plant.sample_time,
            "equations": [mathml(readable(line)) for line in equations_latex(plant)],
            "outputs": [
                (y.name, y.unit, mathml(readable(str(sp.latex(y.expression))), block=False))
                for y in plant.outputs
            ],
            "variables": table("variables", variable_rows(plant)),
            "parameters": table("parameters", parameter_rows(plant)) if plant.parameters else None,
            "units": plant.units,
        },
    )


def equations_latex(plant: Plant) -> list[str]:
    r"""Return one formula per state, ``\dot{x} = ...``, parameters as symbols.

    With a mass matrix one formula M x' = f in matrices.
    """
    import sympy as sp

    mark = r"\dot{{{}}}" if plant.sample_time is None else "{{{}}}^{{+}}"
    left_sides = [mark.format(sp.latex(v.symbol)) for v in plant.states]
    if plant.mass is None:
        return [
            f"{a} = {sp.latex(row)}" for a, row in zip(left_sides, plant.equations, strict=True)
        ]
    matrix = sp.latex(plant.mass, mat_delim="", mat_str="pmatrix")
    f = sp.latex(sp.Matrix(plant.equations), mat_delim="", mat_str="pmatrix")
    rates = r"\\".join(left_sides)
    return [rf"{matrix}\begin{{pmatrix}}{rates}\end{{pmatrix}} = {f}"]


def variable_rows(plant: Plant) -> tuple[tuple[str, ...], ...]:
    """Return name, kind, unit, lower and upper end, rest, and meaning of each variable."""
    return tuple(_variable(kind, v) for kind, v in kinds(plant))


def kinds(plant: Plant) -> list[tuple[str, Variable]]:
    """Return (kind, variable): state, input, disturbance, scheduling or uncertain parameter."""
    outside = [
        ("uncertain parameter" if v.unknown else "scheduling" if v.schedules else "disturbance", v)
        for v in plant.disturbances
    ]
    return [
        *(("state", v) for v in plant.states), *(("input", v) for v in plant.inputs), *outside
    ]  # fmt: skip


def parameter_rows(plant: Plant) -> tuple[tuple[str, ...], ...]:
    """Return name, value, unit, source."""
    return tuple(
        (str(p.symbol), decimal(float(p.value)), p.unit, p.source) for p in plant.parameters
    )


def _variable(kind: str, variable: Variable) -> tuple[str, ...]:
    ends = ("any", "any")
    if variable.range is not None:
        ends = (decimal(float(variable.range.lower)), decimal(float(variable.range.upper)))
    rest = decimal(float(variable.rest))
    return (variable.name, kind, variable.unit, *ends, rest, variable.description)


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
