"""The law: its gains with units, rule by rule, as the gain file has them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.reports.page.mathml import mathml
from takagi.reports.page.text import Section, Table, decimal, name_of, per_unit, unit_of
from takagi.reports.sections.plant.summary import gain_spans

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import ObservedMotion, PlantLoop

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
