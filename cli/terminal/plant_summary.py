"""The summary of a plant's design on the terminal."""

from __future__ import annotations

from typing import Any

from takagi.certificates.design.plant.candidates import BESIDE
from takagi.certificates.design.plant.result import PlantDesign
from takagi.cli.terminal.rows import (
    claims_as_data,
    headline,
    row_as_data,
    row_lines,
    summary_lines,
    unbroken,
    wrapped_claims,
)
from takagi.models.plant.plant import file_unit
from takagi.models.ts.premise import Premise
from takagi.reports.page.text import behind, name_of, unit_of
from takagi.reports.sections.plant.summary import starts_alone, summary_rows

_LONGEST = 60  # characters of a premise's expression that is shown
# Lines of the answer without --all, the headline among them.
MOST_LINES = 14


def as_data(design: PlantDesign) -> dict[str, Any]:
    """Return the summary as plain data: plant, rules, gains, verdict, figures, claims, notes."""
    return {
        "model": design.plant.name,
        "proved": design.proved,
        "rules": len(design.model.rules),
        "premises": [premise.name for premise in design.model.premises],
        "gains": None if design.gains is None else design.gains.tolist(),
        "starts_alone": starts_alone(design),
        "summary": [row_as_data(row) for row in summary_rows(design)],
        **claims_as_data(design.checked),
        "notes": list(design.notes),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: PlantDesign, *, every_claim: bool = False) -> str:
    """Return the answer in few lines; with ``every_claim`` also model, claims and notes."""
    checked = design.checked
    proved = [claim for claim in checked.claims if claim.verdict.name == "PROVED"]
    count = f"{len(proved)} of {len(checked.claims)} claims proved"
    if len(proved) == len(checked.claims):
        count = f"{len(proved)} claims" if len(proved) > 1 else "1 claim"
    rows = summary_rows(design)
    part = any(row.partial for row in rows)
    name = design.plant.name
    lines = [headline(design.verdict_words, name, count, proved=design.proved, part=part)]
    shown = [(row.name, summary_lines(row)) for row in rows]
    if not every_claim and sum(len(of_row) for _, of_row in shown) > MOST_LINES - 2:
        # Gains of several inputs by many states would hide what is proved.
        elsewhere = row_lines("gains", "with their units in the report and with --all")
        others = [(name, of_row) for name, of_row in shown if name != "gains"]
        index = next((k for k, (name, _) in enumerate(shown) if name == "gains"), len(others))
        shown = [*others[:index], ("gains", elsewhere), *others[index:]]
    lines += [line for _, of_row in shown for line in of_row]
    notes = [line for note in design.notes for line in row_lines("note", note)]
    if every_claim:
        lines += [*_model(design), *wrapped_claims(checked), *notes]
        return "\n".join(lines)
    lines += wrapped_claims(checked, but="PROVED")
    size = sum(line.count("\n") + 1 for line in lines)
    if size + len(notes) <= MOST_LINES:
        return "\n".join([*lines, *notes])
    worse = [note for note in design.notes if note.startswith(BESIDE)]
    lines += [line for note in worse for line in row_lines("note", note)]
    left_out = f"{len(design.notes) - len(worse)} notes and " if design.notes else ""
    return "\n".join([*lines, *row_lines("more", f"{left_out}all claims: --all, or the report")])


def _model(design: PlantDesign) -> list[str]:
    """Return the rules with their premises, the ranges, and the sample time."""
    model, plant = design.model, design.plant
    premises = [p for p in model.premises if len(p.corners) > 1]
    named = ", ".join(
        unbroken(f"{_premise(p)} in [{float(p.lower):.6g}, {float(p.upper):.6g}]{behind(p.unit)}")
        for p in premises
    )
    rules = len(model.rules)
    text = f"{rules} rules by {named}" if premises else "1 linear system"
    if model.sample_time is not None:
        text += f"; discrete time, T = {model.sample_time:g} s"
    labels = (*model.states, *model.inputs, *model.disturbances)
    variables = (*plant.states, *plant.inputs, *plant.disturbances)
    units = {label: file_unit(v) for label, v in zip(labels, variables, strict=False)}
    sides = []
    for label, (low, high) in model.box.items():
        size, unit = units.get(label, (1.0, unit_of(label)))
        ends = f"[{float(low) / size:.6g}, {float(high) / size:.6g}]"
        sides.append(unbroken(f"{name_of(label)} in {ends}{behind(unit)}"))
    lines = row_lines("model", text)
    return lines + (row_lines("ranges", ", ".join(sides)) if sides else [])


def _premise(premise: Premise) -> str:
    """Return e.g. ``z1 = sin(theta)/theta``; the name alone where the expression is long."""
    text = "" if premise.proof is None else str(premise.proof.expression)
    return f"{premise.name} = {text}" if 0 < len(text) <= _LONGEST else premise.name
