"""The regional models with their gains, and the wind observer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.reports.page.text import Section, Table, significant
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
    regions = (design.regional.partial, design.regional.full)
    return Section(
        "regions",
        "Regional Takagi–Sugeno models",
        {"regions": [_region(region) for region in regions]},
    )


def _region(region: RegionGains) -> dict[str, Any]:
    return {
        "result": region,
        "premises": premise_table(region.model, f"Premises, {region.region}", EVIDENCE),
        "vertices": _vertices(region.model),
        "gains": _gains(region),
    }


def _vertices(model: TSModel) -> list[dict[str, Any]]:
    """Return one entry for each rule: its corners, and its matrices as rows of text."""
    entries = []
    for number, (rule, vertex) in enumerate(zip(model.rules, model.vertices, strict=True), 1):
        corners = [f"{p.name} {CORNERS[c]}" for p, c in zip(model.premises, rule, strict=True)]
        matrices = [
            (name, [[significant(float(x), 5) for x in row] for row in getattr(vertex, name)])
            for name in ("A", "B", "E")
            if getattr(vertex, name).size
        ]
        entries.append({"number": number, "corners": ", ".join(corners), "matrices": matrices})
    return entries


def _gains(region: RegionGains) -> Table | None:
    if region.k_x is None or region.k_I is None:
        return None
    names = [p.name for p in region.model.premises]
    heads = [*SYMBOLS[region.region], "k<sub>I</sub>"]
    return Table(
        f"Gains, {region.region}: u = −k<sub>x</sub> Δx + k<sub>I</sub> x<sub>I</sub>",
        (
            ("rule", ""),
            *((name, "") for name in names),
            *zip(heads, UNITS[region.region], strict=True),
        ),
        tuple(
            (
                str(k + 1),
                *(CORNERS[c] for c in rule),
                *(significant(float(x), 6) for x in region.k_x[k]),
                significant(float(region.k_I[k]), 6),
            )
            for k, rule in enumerate(region.model.rules)
        ),
    )


def observer_section(design: TurbineDesign) -> Section:
    """Return the section about the wind observer."""
    premises = premise_table(design.observer.model, "Premises, estimation error", EVIDENCE)
    return Section("observer", "Wind observer", {"observer": design.observer, "premises": premises})
