"""The regional models with their gains, and the wind observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.reports.page.text import (
    Section,
    Table,
    decimal,
    significant,
    with_decimals,
)
from takagi.reports.sections.shared import premise_table

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.lmi.turbine.regional import RegionGains
    from takagi.models.ts.model import TSModel

CORNERS = ("lower", "upper")
EVIDENCE = "why it cannot leave"
SYMBOLS = {"partial load": ("k<sub>ω</sub>",), "full load": ("k<sub>ω</sub>", "k<sub>β</sub>")}
UNITS = {"partial load": ("N m s/rad", "N m/rad"), "full load": ("s", "-", "1/rad")}


def regions_section(design: TurbineDesign) -> Section:
    """Return the section about the regional models and their gains."""
    parts = (design.regional.partial, design.regional.full)
    return Section(
        "regions",
        "Regional Takagi–Sugeno models",
        {"regions": [_region(part) for part in parts]},
    )


def _region(part: RegionGains) -> dict[str, Any]:
    model = part.model
    box = [(name, float(low), float(high)) for name, (low, high) in model.box.items()]
    return {
        "name": part.region,
        "anchor": part.region.replace(" ", "-"),
        "states": model.states,
        "input": model.inputs[0],
        "source": model.source,
        "box": [(name, decimal(low), decimal(high)) for name, low, high in box],
        "premises": premise_table(model, f"Premises, {part.region}", EVIDENCE),
        "vertices": _vertices(model),
        "gains": _gains(part),
        "decay": "" if part.decay_rate is None else significant(part.decay_rate),
        "bounds": [(n, significant(a), significant(b)) for n, (a, b) in part.bounds.items()],
        "diagnosis": part.diagnosis,
        "asked": part.requirement,
    }


def _vertices(model: TSModel) -> list[dict[str, Any]]:
    """Return one entry for each rule: its corners, and its matrices as rows of text."""
    found = []
    for number, (rule, vertex) in enumerate(zip(model.rules, model.vertices, strict=True), 1):
        corners = [f"{p.name} {CORNERS[c]}" for p, c in zip(model.premises, rule, strict=True)]
        matrices = [
            (name, [[significant(float(x), 5) for x in row] for row in getattr(vertex, name)])
            for name in ("A", "B", "E")
            if getattr(vertex, name).size
        ]
        found.append({"number": number, "corners": ", ".join(corners), "matrices": matrices})
    return found


def _gains(part: RegionGains) -> Table | None:
    if part.k_x is None or part.k_I is None:
        return None
    names = [p.name for p in part.model.premises]
    heads = [*SYMBOLS[part.region], "k<sub>I</sub>"]
    return Table(
        f"Gains, {part.region}: u = −k<sub>x</sub> Δx + k<sub>I</sub> x<sub>I</sub>",
        (
            ("rule", ""),
            *((name, "") for name in names),
            *zip(heads, UNITS[part.region], strict=True),
        ),
        tuple(
            (
                str(k + 1),
                *(CORNERS[c] for c in rule),
                *(significant(float(x), 6) for x in part.k_x[k]),
                significant(float(part.k_I[k]), 6),
            )
            for k, rule in enumerate(part.model.rules)
        ),
    )


def observer_section(design: TurbineDesign) -> Section:
    """Return the section about the wind observer."""
    found = design.observer
    low, high = found.observer.limits
    return Section(
        "observer",
        "Wind observer",
        {
            "l1": f"{found.gains[0]:g}",
            "l2": f"{found.gains[1]:g}",
            "decay": significant(found.decay_rate),
            "limits": f"{with_decimals(low, 1)} to {with_decimals(high, 1)}",
            "premises": premise_table(found.model, "Premises, estimation error", EVIDENCE),
            "box": [
                (name, decimal(float(a)), decimal(float(b)))
                for name, (a, b) in found.model.box.items()
            ],
        },
    )
