"""What a finished design for a plant says of itself on the terminal."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

from takagi.cli.design_summary import claims_as_data
from takagi.cli.plant_run import verdict_words

if TYPE_CHECKING:
    from takagi.certificates.plant_design import PlantDesign

__all__ = ["as_data", "as_text"]

_WIDTH, _INDENT = 100, " " * 13


def as_data(design: PlantDesign) -> dict[str, Any]:
    """Return the summary as plain data: plant, rules, gains, verdict, claims, notes."""
    return {
        "model": design.plant.name,
        "proved": design.proved,
        "rules": len(design.model.rules),
        "premises": [premise.name for premise in design.model.premises],
        "gains": None if design.gains is None else design.gains.tolist(),
        **claims_as_data(design.checked),
        "notes": list(design.notes),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: PlantDesign) -> str:
    """Return the summary in a few lines: verdict, model, gains, claims, notes."""
    model = design.model
    lines = [f"{verdict_words(design)}  {design.plant.name}", _rules(design)]
    lines += _box(design)
    if design.law is not None and design.gains is not None:
        lines += _gains(design)
    lines += _claims(design)
    lines += [fill(note, _WIDTH, initial_indent="  note       ", subsequent_indent=_INDENT)
              for note in design.notes]  # fmt: skip
    if model.sample_time is not None:
        lines.insert(2, f"  discrete time, T = {model.sample_time:g} s")
    return "\n".join(lines)


def _claims(design: PlantDesign) -> list[str]:
    lines = []
    for claim in design.checked.claims:
        lines.append(f"  {claim.verdict.name:<9}".ljust(len(_INDENT)) + claim.name)
        lines.append(fill(claim.text, _WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT))
    return lines


def _rules(design: PlantDesign) -> str:
    model = design.model
    count = len(model.rules)
    premises = [p for p in model.premises if len(p.corners) > 1]
    if not premises:
        return f"  model      {count} linear system" + ("s" if count > 1 else "")
    told = ", ".join(
        f"{p.name} in [{float(p.lower):.6g}, {float(p.upper):.6g}]"
        + ("" if p.unit == "-" else f" {p.unit}")
        for p in premises
    )
    return f"  model      {count} rules by {told}"


def _box(design: PlantDesign) -> list[str]:
    sides = [
        f"{label.split(' [')[0]} in [{float(low):.6g}, {float(high):.6g}]" + _unit(label)
        for label, (low, high) in design.model.box.items()
    ]
    return [f"  box        {', '.join(sides)}"] if sides else []


def _unit(label: str) -> str:
    unit = label.partition("[")[2].rstrip("]")
    return "" if unit in ("", "-") else f" {unit}"


def _gains(design: PlantDesign) -> list[str]:
    """Return the least and largest of each gain over the rules."""
    assert design.gains is not None
    lines = []
    low, high = design.gains.min(axis=0), design.gains.max(axis=0)
    for k, variable in enumerate(design.plant.inputs):
        parts = [
            f"{low[k, j]:.4g}"
            if low[k, j] == high[k, j]
            else f"{low[k, j]:.4g} to {high[k, j]:.4g}"
            for j in range(low.shape[1])
        ]
        names = ", ".join(v.name for v in design.plant.states)
        lines.append(f"  gains      {variable.label} from ({names}): {'; '.join(parts)}")
    return lines
