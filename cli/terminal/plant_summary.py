"""The summary of a plant's design on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.cli.terminal.plant_set import (
    INDENT,
    WIDTH,
    box_line,
    kept,
    regulator_line,
    set_lines,
    starts_alone,
    told,
)
from takagi.cli.terminal.turbine_summary import claims_as_data
from takagi.reports.page.text import behind

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.ts.premise import Premise

_LONGEST = 60  # characters of a premise's expression that is shown


def as_data(design: PlantDesign) -> dict[str, Any]:
    """Return the summary as plain data: plant, rules, gains, verdict, claims, notes."""
    return {
        "model": design.plant.name,
        "proved": design.proved,
        "rules": len(design.model.rules),
        "premises": [premise.name for premise in design.model.premises],
        "gains": None if design.gains is None else design.gains.tolist(),
        "starts_alone": starts_alone(design),
        **claims_as_data(design.checked),
        "notes": list(design.notes),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: PlantDesign) -> str:
    """Return the summary in a few lines: verdict, model, gains, claims, notes."""
    model = design.model
    lines = [f"{design.verdict_words}  {design.plant.name}", _rules(design)]
    lines += box_line(design)
    if design.gains is not None and (design.law or design.output_law) is not None:
        lines += _gains(design)
    lines += set_lines(design)
    lines += regulator_line(design)
    lines += _claims(design)
    lines += [line for note in design.notes for line in told("note", note)]
    if model.sample_time is not None:
        lines.insert(2, f"  discrete time, T = {model.sample_time:g} s")
    return "\n".join(lines)


def next_commands(model: str, out: Path, files: Mapping[str, bytes | str]) -> list[str]:
    """Return commands that a user may type next; ``files`` of the design lie in ``out``."""
    companion = f" --gains {out / 'gains.json'}" if "gains.json" in files else ""
    own = f" --model {model}" if Path(model).suffix == ".toml" else ""
    found = [f"takagi check {out / 'certificate.json'}{companion}{own}"]
    if companion:
        found.append(f"takagi simulate {model}{companion} --out {out / 'simulation'}")
    return found


def _claims(design: PlantDesign) -> list[str]:
    lines = []
    for claim in design.checked.claims:
        lines.append(f"  {claim.verdict.name:<9}".ljust(len(INDENT)) + claim.name)
        lines.append(fill(claim.text, WIDTH, initial_indent=INDENT, subsequent_indent=INDENT))
    return lines


def _rules(design: PlantDesign) -> str:
    model = design.model
    count = len(model.rules)
    premises = [p for p in model.premises if len(p.corners) > 1]
    if not premises:
        return f"  model      {count} linear system" + ("s" if count > 1 else "")
    named = ", ".join(
        kept(f"{_premise(p)} in [{float(p.lower):.6g}, {float(p.upper):.6g}]" + behind(p.unit))
        for p in premises
    )
    return told("model", f"{count} rules by {named}")[0]


def _premise(premise: Premise) -> str:
    """Return e.g. ``z1 = sin(theta)/theta``; the name alone where the expression is long."""
    text = "" if premise.proof is None else str(premise.proof.expression)
    return f"{premise.name} = {text}" if 0 < len(text) <= _LONGEST else premise.name


def _gains(design: PlantDesign) -> list[str]:
    """Return the least and the largest value of each gain over the rules."""
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
    if design.output_law is not None:
        outputs = [design.plant.outputs[k].name for k in design.output_law.rows]
        lines += told(
            "observer",
            f"of {', '.join(outputs)}, "
            + (
                "constant matrices"
                if design.plant.references
                else "weights at the estimate"
                if design.output_law.at_estimate
                else "weights as the plant's"
            )
            + f"; largest gain {np.abs(design.output_law.L).max():.4g}, all in gains.json",
        )
    return lines
