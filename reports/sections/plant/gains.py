"""The equations, the steps to the model, and the law: its gains with units; and blends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.blending.blending import Actuator, Blending, RunTimeBlending
from takagi.models.equations.derivation_step import Step
from takagi.models.plant.plant import Plant, Variable
from takagi.models.ts.model import TSModel
from takagi.reports.figures.plant.captioned import Drawn, hand_over_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.plant_loop import ObservedMotion, PlantLoop
from takagi.reports.loops.plant_motion import PlantMotion, horizon, motions, starts
from takagi.reports.page.assembly import premise_table
from takagi.reports.page.mathml import mathml, readable, shortens
from takagi.reports.page.text import (
    DASH,
    Section,
    Table,
    decimal,
    name_of,
    per_unit,
    significant,
    table,
    unit_of,
)
from takagi.reports.sections.plant.summary import gain_spans

FOLDED = 4
OBSERVED_LAW = (
    r"u = u^{*} - \sum_i h_i K_i s, \quad \dot{s} = \sum_i h_i \left(A_i s + B_i (u - u^{*}) "
    r"+ L_i (y - y^{*} - C_i s - D_i (u - u^{*}))\right)"
)
REFERENCE_LAW = (
    r"u = u^{*} - K (s, \xi), \quad \dot{s} = A s + B (u - u^{*}) + L (y - y^{*} - C s), \quad "
    r"\dot{\xi} = h(y) - r"
)
CONTROLLER_LAW = (
    r"u = u^{*} - C_c x_c - D_c (y - y^{*}), \quad \dot{x}_c = A_c x_c + B_c (y - y^{*})"
)
CORNERS = ("lower", "upper")
LAW = r"u = u^{*} - \sum_{i=1}^{%d} h_i(z) K_i \left(x - x^{*}\right)"
ONE_GAIN = r"u = u^{*} - K \left(x - x^{*}\right)"


def gains_section(design: PlantDesign, loop: PlantLoop) -> Section:
    """Return the section about the law."""
    rules = len(loop.model.rules)
    content: dict[str, Any] = {
        "law": mathml(LAW % rules if rules > 1 else ONE_GAIN),
        "rules": rules,
        "spans": [" ".join(row.parts) for row in gain_spans(loop)],
        "table": Table(
            "Gains as emitted",
            gain_columns(loop),
            gain_rows(loop),
            folded=f"Gains of all {rules} rules" if rules > FOLDED else "",
        ),
        "observer": None,
        "relaxation": "" if design.design is None else design.design.relaxation,
        "notes": list(design.notes),
    }
    if loop.plant.integrators:
        content["law"] = mathml(CONTROLLER_LAW)
    if loop.observed is not None:
        content |= {
            "law": mathml(REFERENCE_LAW if loop.plant.references else OBSERVED_LAW),
            "observer": _observer_table(loop, loop.observed),
            "at_estimate": loop.observed.law.at_estimate,
        }
    return Section("gains", "The law and its gains", content)


def _observer_table(loop: PlantLoop, observed: ObservedMotion) -> Table:
    """Return L as the gain file has it: one row for each rule, one alone where all are equal."""
    outputs = [loop.plant.outputs[k] for k in observed.law.rows]
    step = loop.model.sample_time is not None
    heads = [("rule", "")]
    for state in loop.model.states:
        for y in outputs:
            unit = per_unit(_unit(state), y.unit)
            heads.append((f"{name_of(state)} by {y.name}", unit if step else f"({unit})/s"))
    L = observed.law.L
    same = bool((L == L[0]).all())
    rows = [
        ("all" if same else str(i), *(decimal(float(x)) for x in gain.ravel()))
        for i, gain in enumerate(L[:1] if same else L, 1)
    ]
    return Table("Gains L of the observer, as emitted", tuple(heads), tuple(rows))


def gain_columns(loop: PlantLoop) -> tuple[tuple[str, str], ...]:
    """Return (heading, unit) of the table: rule, its corners, then K row by row."""
    premises = [p for p in loop.model.premises if len(p.corners) > 1]
    heads = [("rule", ""), *((p.name, "") for p in premises)]
    for command in loop.model.inputs:
        for state in loop.model.states:
            u, x = name_of(command), name_of(state)
            heads.append((f"{u} by {x}", per_unit(_unit(command), _unit(state))))
    return tuple(heads)


def gain_rows(loop: PlantLoop) -> tuple[tuple[str, ...], ...]:
    """Return the gains as the gain file has them, one row for each rule."""
    assert loop.gains is not None
    varying = [k for k, p in enumerate(loop.model.premises) if len(p.corners) > 1]
    return tuple(
        (str(i), *(CORNERS[rule[k]] for k in varying), *(decimal(float(x)) for x in K.ravel()))
        for i, (rule, K) in enumerate(zip(loop.model.rules, loop.gains, strict=True), 1)
    )


def _unit(label: str) -> str:
    return unit_of(label) or "-"


# Limit of a motion's duration [s]: a plant with time constants of minutes takes hours to settle.
LONGEST = 1e5


def blend_section(loop: PlantLoop, blend: RunTimeBlending) -> Section:
    """Return the section about the blend of a loop."""
    simulated = hand_overs(loop)
    blending = blend.blending
    share = blending.share
    content: dict[str, Any] = {
        "laws": [mathml(line) for line in _laws(blending)],
        "equations": [mathml(readable(line)) for line in equations_latex(blending.plant)],
        "overlap": significant(float(blending.overlap)),
        "unit": blending.effort.unit,
        "ends": [decimal(float(end)) for end in (blending.efforts.lower, blending.efforts.upper)],
        "rest": decimal(float(blending.effort.rest)),
        "share": [significant(float(share.lower)), significant(float(share.upper))],
        "low": blending.low.name,
        "high": blending.high.name,
        "errors": [a.name for a in blending.actuators if a.error],
        "table": table(
            "actuators", (_row(blending, a, k, simulated) for k, a in enumerate(blending.actuators))
        ),
        "motions": captioned_figure(
            hand_over_figure(blend, simulated, float(loop.state[-1])), "hand-over", "blend"
        ),
    }
    return Section("blend", "Two actuators, one effort", content)


def hand_overs(loop: PlantLoop) -> tuple[PlantMotion, ...]:
    """Return motions that start with the first state, or the effort, at its largest or least."""
    named_starts = starts(loop)
    picked = [named_starts[0], named_starts[-1]]
    begin = [(name, x) for name, x in picked]
    begin += [
        (name.replace("largest", "least").replace("= ", "= \u2212"), -x) for name, x in picked
    ]
    return motions(loop, begin, duration=horizon(loop, longest=LONGEST))


def _laws(blending: Blending) -> list[str]:
    formulas = []
    for actuator in blending.actuators:
        sign = "+" if blending.sign(actuator) * actuator.direction > 0 else "-"
        effort = "U" if actuator is blending.high else "-U"
        name, b = actuator.name.replace("_", r"\_"), _latex(actuator.effectiveness)
        idle = actuator.variable.rest
        start = "" if idle == 0 else f"{decimal(float(idle))} {sign} "
        minus = "" if idle != 0 or sign == "+" else "-"
        formulas.append(rf"\mathrm{{{name}}} = {start}{minus}\frac{{\psi({effort})}}{{{b}}}")
    return formulas


def _latex(expression: Any) -> str:
    import sympy as sp

    return readable(str(sp.latex(expression)))


def _row(
    blending: Blending, actuator: Actuator, k: int, simulated: Sequence[PlantMotion]
) -> tuple[str, ...]:
    variable, e = actuator.variable, significant(float(blending.overlap))
    side = variable.range
    limits = DASH
    if side is not None:
        limits = f"{decimal(float(side.lower))} to {decimal(float(side.upper))}"
    commands = [motion.acting[:, k] for motion in simulated if len(motion.acting)]
    lowest = min((float(series.min()) for series in commands), default=float("nan"))
    highest = max((float(series.max()) for series in commands), default=float("nan"))
    return (
        variable.name,
        f"below {e} {blending.effort.unit}"
        if k == 0
        else f"above \u2212{e} {blending.effort.unit}",
        decimal(float(variable.rest)),
        limits,
        variable.unit,
        str(actuator.effectiveness).replace("**", "^"),
        f"\u00b1{significant(100 * float(actuator.error))} %" if actuator.error else "nothing",
        f"{significant(lowest)} to {significant(highest)}",
    )


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
