"""A regional Takagi-Sugeno model and its gains, typeset from the value that was derived."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from takagi.lmi.turbine.regional import RegionGains
from takagi.models.ts.model import TSModel
from takagi.reports.appendix.tex import (
    Tex,
    decimal,
    escape,
    matrix,
    scientific,
    unit,
    with_decimals,
)

# Names of derivatives in the evidence of a premise (escaped for LaTeX) -> their formulas.
_DERIVATIVES = {
    r"dT\_r/domega / J": r"$\partial_\omega T_r / J$",
    r"dT\_r/dbeta / J": r"$\partial_\beta T_r / J$",
    r"dT\_r/dv / J": r"$\partial_v T_r / J$",
}
_NAMED = re.compile(r"^(.*) \[(.*)\]$")
# sympy puts the dot over symbol and index together; it belongs over the symbol.
_DOTTED = re.compile(r"\\dot\{([^{}]+)_\{([^{}]+)\}\}")


def region_context(model: TSModel, gains: RegionGains, letter: str) -> dict[str, object]:
    """Return derivation, premises, vertices, rules and gains of one region.

    Parameters
    ----------
    letter : superscript of its memberships, "b" or "c".
    """
    return {
        "letter": letter,
        "model": model.name,
        "source": model.source,
        "steps": _steps(model),
        "states": [_with_unit(name) for name in model.states],
        "box": [_box_row(name, ends) for name, ends in model.box.items()],
        "premises": [_premise_row(model, k) for k in range(len(model.premises))],
        "rules": rule_rows(model),
        "rule_count": len(model.rules),
        "common_B": _common_input(model),
        "vertices": list(vertex_lines(model)),
        "gains": _gains(model, gains),
        "found": gains.found,
        "diagnosis": gains.diagnosis,
        "decay_asked": with_decimals(gains.requirement.decay_rate, 3),
        "decay_found": with_decimals(gains.decay_rate or 0.0, 5),
        "speed_error": scientific(gains.requirement.speed_error),
        "pitch_error": scientific(gains.requirement.pitch_error),
        "with_pitch": len(model.states) == 3,
        "bounds": [
            [escape(name), scientific(limit, 5), scientific(largest, 5)]
            for name, (limit, largest) in gains.bounds.items()
        ],
        "P": Tex("") if gains.P is None else matrix(gains.P, digits=6),
    }


def rule_rows(model: TSModel) -> list[list[Tex]]:
    """Return one row per rule: its number and the corner of each premise."""
    return [
        [escape(i), *(decimal(p.corners[c]) for p, c in zip(model.premises, rule, strict=True))]
        for i, rule in enumerate(model.rules, start=1)
    ]


def vertex_lines(model: TSModel) -> Iterator[Tex]:
    """Yield A_i and E_i as display lines; a line has as many rules as fit on the page."""
    per_line = 2 if len(model.states) <= 3 else 1
    for first in range(0, len(model.rules), per_line):
        parts = [
            rf"A_{{{i + 1}}} &= {matrix(model.A[i])}, & E_{{{i + 1}}} &= {matrix(model.E[i])}"
            for i in range(first, min(first + per_line, len(model.rules)))
        ]
        yield Tex(" & ".join(parts))


def _steps(model: TSModel) -> list[dict[str, Tex]]:
    """Return title and displayed formula of each step of the derivation."""
    if model.derivation is None:
        return []
    return [
        {"title": _title(step.title), "latex": _display(step.latex)}
        for step in model.derivation.steps
    ]


def _display(formula: str) -> Tex:
    """Return a formula with fractions at full size, also inside vectors, and dots on symbols."""
    dotted = _DOTTED.sub(r"\\dot{\1}_{\2}", formula)
    return Tex(dotted.replace(r"\frac", r"\dfrac").replace(r"\\", r"\\[8pt] "))


def _title(words: str) -> Tex:
    text = str(escape(words))
    for plain, symbols in _DERIVATIVES.items():
        text = text.replace(plain, symbols)
    return Tex(re.sub(r"^Premise (\w+);", r"Premise $\1$;", text))


def _with_unit(name: str) -> Tex:
    found = _NAMED.match(name)
    return escape(name) if found is None else Tex(f"{escape(found[1])} [{unit(found[2])}]")


def _box_row(name: str, ends: tuple[object, object]) -> list[Tex]:
    low, high = (float(end) for end in ends)  # type: ignore[arg-type]
    return [_with_unit(name), scientific(low, 6), scientific(high, 6)]


def _premise_row(model: TSModel, k: int) -> list[Tex]:
    premise = model.premises[k]
    evidence = _title(premise.evidence)
    return [
        Tex(f"${premise.latex}$"),
        decimal(premise.lower),
        decimal(premise.upper),
        unit(premise.unit),
        evidence,
    ]


def _common_input(model: TSModel) -> Tex | None:
    return None if np.ptp(model.B, axis=0).any() else matrix(model.B[0])


def _gains(model: TSModel, gains: RegionGains) -> list[list[Tex]]:
    if gains.k_x is None or gains.k_I is None:
        return []
    corners = rule_rows(model)
    return [
        [*corners[i], *(scientific(float(k), 6) for k in gains.k_x[i]), scientific(float(k_I), 6)]
        for i, k_I in enumerate(gains.k_I)
    ]
