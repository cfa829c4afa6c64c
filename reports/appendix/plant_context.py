"""The values for the templates of a plant's appendix."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.reports.appendix.tex import (
    NONE,
    Tex,
    checked_context,
    decimal,
    escape,
    matrix,
    scientific,
    unit,
    with_decimals,
)
from takagi.reports.loops.plant_local import PlantLocalLoop
from takagi.reports.loops.proved_kinds import embedded
from takagi.reports.page.readable_latex import readable, shortens
from takagi.reports.page.text import name_of
from takagi.reports.sections.plant.gains import gain_columns
from takagi.reports.sections.plant.plant import derivation_steps, equations_latex, kinds

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable
    from takagi.reports.loops.plant_loop import PlantLoop

# A table of gains with more columns does not fit the page: each rule then gets a matrix.
MOST_COLUMNS = 9
# A table with more rows is broken over pages; more margins than this are left out.
MOST_ROWS = MOST_MARGINS = 40


def latex_context(
    design: PlantDesign, loop: PlantLoop, loops: Sequence[PlantLocalLoop]
) -> dict[str, Any]:
    """Return the values of all names in the templates."""
    name = design.plant.name or "Plant"
    shown = "certificate and poles" if loop.gains is None else "law, certificate and margins"
    return {
        "subject": name,
        "title": name,
        "subtitle": f"Derivation, {shown}",
        "contents": False,
        **_plant(design.plant),
        **_derivation(design),
        **_law(design, loop),
        **_certificate(design, loop),
        "margins": [_margin_row(one) for one in loops[:MOST_MARGINS]],
        "margins_left_out": max(len(loops) - MOST_MARGINS, 0),
    }


def _plant(plant: Plant) -> dict[str, Any]:
    return {
        "description": plant.description,
        "source": plant.source,
        "sample_time": None if plant.sample_time is None else decimal(plant.sample_time),
        "equations": [Tex(readable(line)) for line in equations_latex(plant)],
        "variables": [_variable(kind, v) for kind, v in kinds(plant)],
        "parameters": [
            [_symbol(p.symbol), decimal_or_rounded(p.value), unit(p.unit), escape(p.source)]
            for p in plant.parameters
        ],
    }


def _variable(kind: str, variable: Variable) -> list[Tex]:
    ends = [NONE, NONE]
    if variable.range is not None:
        ends = [
            decimal_or_rounded(variable.range.lower), decimal_or_rounded(variable.range.upper)
        ]  # fmt: skip
    return [
        _symbol(variable.symbol), escape(kind), unit(variable.unit), *ends,
        decimal_or_rounded(variable.rest), escape(variable.description),
    ]  # fmt: skip


def _derivation(design: PlantDesign) -> dict[str, Any]:
    steps, vertices = derivation_steps(design.model)
    return {
        "steps": [(step.title, Tex(readable(step.latex))) for step in steps],
        "vertices": [Tex(readable(step.latex)) for step in vertices],
        "rounded": any(shortens(step.latex) for step in steps),
        "rules": len(design.model.rules),
    }


def _law(design: PlantDesign, loop: PlantLoop) -> dict[str, Any]:
    if loop.gains is None:
        return {"law": False, "notes": list(design.notes)}
    columns = gain_columns(loop)
    if len(columns) > MOST_COLUMNS:
        rows = [
            [escape(i), Tex(f"${matrix(K, exactly=True)}$")] for i, K in enumerate(loop.gains, 1)
        ]
        heads = [Tex("Rule"), Tex("$K_i$, SI units")]
    else:
        varying = [k for k, p in enumerate(loop.model.premises) if len(p.corners) > 1]
        corners = (Tex("lower"), Tex("upper"))
        rows = [
            [escape(i), *(corners[rule[k]] for k in varying), *map(decimal, map(float, K.ravel()))]
            for i, (rule, K) in enumerate(zip(loop.model.rules, loop.gains, strict=True), 1)
        ]
        heads = [_head(name, of) for name, of in columns]
    return {
        "law": True,
        "gain_heads": heads,
        "gains": rows,
        "long_gains": len(rows) > MOST_ROWS,
        "notes": list(design.notes),
    }


def _certificate(design: PlantDesign, loop: PlantLoop) -> dict[str, Any]:
    level = loop.level if loop.bounded else None
    return checked_context(design.document, design.checked) | {
        "embedded": embedded(design),
        "discrete": loop.discrete,
        "decay": None if loop.decay_rate is None else decimal(loop.decay_rate),
        "P": None if loop.decay_P is None else matrix(loop.decay_P, exactly=True),
        "level": None if level is None else scientific(level, 4),
        "level_proved": loop.level_proved,
        "states": [escape(label) for label in loop.model.states],
    }


def _margin_row(one: PlantLocalLoop) -> list[Tex]:
    m = one.margins
    head = [escape(one.place), escape(name_of(one.input))]
    if not m.stable:
        return [*head, *[escape("unstable")] * 6]
    crossover = scientific(m.crossover, 3) if np.isfinite(m.crossover) else NONE
    return [
        *head,
        crossover,
        with_decimals(20 * np.log10(m.gain_increase), 1),
        with_decimals(float(np.degrees(m.phase)), 1),
        scientific(m.delay, 3) if np.isfinite(m.delay) else with_decimals(m.delay, 0),
        with_decimals(m.disk.alpha, 2),
        with_decimals(m.sensitivity_peak, 2),
    ]


def decimal_or_rounded(value: Any) -> Tex:
    """Return a value in up to 12 significant digits."""
    text = f"{float(value):.12g}"
    return decimal(text) if "e" not in text else scientific(float(value), 12)


def _symbol(symbol: Any) -> Tex:
    import sympy as sp

    return Tex(f"${readable(str(sp.latex(symbol)))}$")


def _head(name: str, of: str) -> Tex:
    words = escape(name)
    return Tex(rf"\shortstack[r]{{{words}\\{{}}[{unit(of)}]}}") if of else words
