"""What a finished design for a plant says of itself on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.cli.terminal.turbine_summary import claims_as_data

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.ts.premise import Premise

_WIDTH, _INDENT = 100, " " * 13
_TIE = "\N{NO-BREAK SPACE}"
_LONGEST = 60  # characters of a premise's expression that is shown
SMALL = 0.1  # share of the box below which the proved set is called small


def as_data(design: PlantDesign) -> dict[str, Any]:
    """Return the summary as plain data: plant, rules, gains, verdict, claims, notes."""
    return {
        "model": design.plant.name,
        "proved": design.proved,
        "rules": len(design.model.rules),
        "premises": [premise.name for premise in design.model.premises],
        "gains": None if design.gains is None else design.gains.tolist(),
        "starts_alone": _starts_alone(design),
        **claims_as_data(design.checked),
        "notes": list(design.notes),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: PlantDesign) -> str:
    """Return the summary in a few lines: verdict, model, gains, claims, notes."""
    model = design.model
    lines = [f"{design.verdict_words}  {design.plant.name}", _rules(design)]
    lines += _box(design)
    if design.law is not None and design.gains is not None:
        lines += _gains(design)
    lines += _set(design)
    lines += _motion(design)
    lines += _claims(design)
    lines += [line for note in design.notes for line in _told("note", note)]
    if model.sample_time is not None:
        lines.insert(2, f"  discrete time, T = {model.sample_time:g} s")
    return "\n".join(lines)


def next_commands(model: str, out: Path, files: Mapping[str, bytes | str]) -> list[str]:
    """Return what may be typed after a design, whose ``files`` lie in ``out``."""
    companion = f" --gains {out / 'gains.json'}" if "gains.json" in files else ""
    own = f" --model {model}" if Path(model).suffix == ".toml" else ""
    found = [f"takagi check {out / 'certificate.json'}{companion}{own}"]
    if companion:
        found.append(f"takagi simulate {model}{companion} --out {out / 'simulation'}")
    return found


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
        _kept(
            f"{_premise(p)} in [{float(p.lower):.6g}, {float(p.upper):.6g}]"
            + ("" if p.unit == "-" else f" {p.unit}")
        )
        for p in premises
    )
    return _told("model", f"{count} rules by {told}")[0]


def _premise(premise: Premise) -> str:
    """Return e.g. ``z1 = sin(theta)/theta``, the name alone where that takes long."""
    text = "" if premise.proof is None else str(premise.proof.expression)
    return f"{premise.name} = {text}" if 0 < len(text) <= _LONGEST else premise.name


def _box(design: PlantDesign) -> list[str]:
    sides = [
        _kept(f"{label.split(' [')[0]} in [{float(low):.6g}, {float(high):.6g}]" + _unit(label))
        for label, (low, high) in design.model.box.items()
    ]
    return _told("box", ", ".join(sides)) if sides else []


def _told(word: str, text: str) -> list[str]:
    """Return the text behind its word, broken where the lines end."""
    start = f"  {word}".ljust(len(_INDENT))
    filled = fill(text, _WIDTH, initial_indent=start, subsequent_indent=_INDENT)
    return [filled.replace(_TIE, " ")]


def _kept(part: str) -> str:
    """Return the part with spaces at which no line ends."""
    return part.replace(" ", _TIE)


def _starts_alone(design: PlantDesign) -> dict[str, float]:
    """Return state -> sqrt(c / P_kk), SI: how far it alone may start off rest in {x'Px <= c}.

    {} where no set is proved to be invariant.
    """
    from takagi.reports.loops.plant_loop import plant_loop

    loop = plant_loop(design)
    if not (loop.bounded and loop.level_proved):
        return {}
    P, level = loop.ellipsoid
    reach = (float(np.sqrt(level / size)) for size in np.diag(P))
    return dict(zip(design.model.states, reach, strict=True))


def _set(design: PlantDesign) -> list[str]:
    """Return the starts in the proved set, and a word where they are a small part of the box."""
    from takagi.reports.page.text import at_least

    box = design.model.box
    parts, shares = [], []
    for label, reach in _starts_alone(design).items():
        part = f"{label.split(' [')[0]} {at_least(reach)}{_unit(label)}"
        if label in box:
            shares.append(reach / max(abs(float(end)) for end in box[label]))
            part += f" ({100 * shares[-1]:.2g} %)" if shares[-1] < 0.995 else " (all)"
        parts.append(_kept(part))
    if not parts:
        return []
    text = f"starts with one state alone off rest stay in the box up to {', '.join(parts)}"
    if shares and max(shares) < SMALL:
        text += (
            ". That is little of the box: see whether smaller ranges of the states, a lower decay "
            "rate or larger inputs give more"
        )
    return _told("set", text)


def _motion(design: PlantDesign) -> list[str]:
    """Return how far states get from anywhere in the proved set, and when they are at rest."""
    from takagi.reports.loops.plant_loop import plant_loop
    from takagi.reports.loops.settling import SETTLED, half_widths, settling_time
    from takagi.reports.page.rounded_bounds import at_most

    loop = plant_loop(design)
    reach, time = half_widths(loop), settling_time(loop)
    if reach is None:
        return []
    parts = [
        _kept(f"|{label.split(' [')[0]}| <= {at_most(float(most), 4)}{_unit(label)}")
        for label, most in zip(design.model.states, reach, strict=True)
    ]
    text = f"from anywhere in the set {', '.join(parts)}"
    if time is not None:
        text += f"; within {at_most(time)} s all are below {SETTLED:.0%} of that"
    return _told("motion", text)


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
