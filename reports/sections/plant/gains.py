"""The law: its gains with units, rule by rule, as the gain file has them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.reports.loops.largest_commands import largest_commands
from takagi.reports.loops.proved_kinds import proved_kinds
from takagi.reports.page.labels import name_of, unit_of
from takagi.reports.page.mathml import mathml
from takagi.reports.page.text import Section, Table, decimal, significant

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop

FOLDED = 16
CORNERS = ("lower", "upper")
LAW = r"u = u^{*} - \sum_{i=1}^{%d} h_i(z) K_i \left(x - x^{*}\right)"


def gains_section(design: PlantDesign, loop: PlantLoop) -> Section:
    """Return the section about the law."""
    # Where a claim proves bounds of the inputs, no bound in floating point is shown.
    known = "input-limits" in proved_kinds(design)
    content: dict[str, Any] = {"table": None, "law": "", "trim": None, "commands": []}
    if loop.gains is not None:
        rules = len(loop.model.rules)
        content |= {
            "law": mathml(LAW % rules),
            "table": Table(
                "Gains as emitted",
                gain_columns(loop),
                gain_rows(loop),
                folded=f"Gains of all {rules} rules" if rules > FOLDED else "",
            ),
            "trim": _trim(loop),
            "level_proved": loop.level_proved,
            "commands": [
                _words(name, size) for name, size in ([] if known else largest_commands(loop))
            ],
        }
    content["relaxation"] = "" if design.design is None else design.design.relaxation
    content["notes"] = list(design.notes)
    return Section("gains", "The law and its gains", content)


def gain_columns(loop: PlantLoop) -> tuple[tuple[str, str], ...]:
    """Return (heading, unit) of the table: rule, its corners, then K row by row."""
    premises = [p for p in loop.model.premises if len(p.corners) > 1]
    heads = [("rule", ""), *((p.name, "") for p in premises)]
    for given in loop.model.inputs:
        for state in loop.model.states:
            u, x = name_of(given), name_of(state)
            heads.append((f"{u} by {x}", _per(_unit(given), _unit(state))))
    return tuple(heads)


def gain_rows(loop: PlantLoop) -> tuple[tuple[str, ...], ...]:
    """Return the gains as the gain file has them, one row for each rule."""
    assert loop.gains is not None
    varying = [k for k, p in enumerate(loop.model.premises) if len(p.corners) > 1]
    return tuple(
        (str(i), *(CORNERS[rule[k]] for k in varying), *(decimal(float(x)) for x in K.ravel()))
        for i, (rule, K) in enumerate(zip(loop.model.rules, loop.gains, strict=True), 1)
    )


def _trim(loop: PlantLoop) -> Table:
    rows = [
        (v.name, decimal(float(value)), v.unit)
        for v, value in (
            *zip(loop.plant.states, loop.state, strict=True),
            *zip(loop.plant.inputs, loop.input, strict=True),
        )
    ]
    return Table(
        "Where the plant rests, x* and u*",
        (("variable", ""), ("value", ""), ("unit", "")),
        tuple(rows),
        folded="The operating point",
    )


def _words(label: str, size: float) -> str:
    """Return e.g. "3393 N of force"."""
    unit = _unit(label)
    return f"{significant(size)}{'' if unit == '-' else f' {unit}'} of {name_of(label)}"


def _unit(label: str) -> str:
    return unit_of(label) or "-"


def _per(above: str, below: str) -> str:
    if below == "-":
        return above
    bottom = f"({below})" if set(below) & set("/ ") else below
    return f"{'1' if above == '-' else above}/{bottom}"
