"""The values for the templates of a plant's appendix."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.plant.plant import Plant, Variable
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise
from takagi.reports.appendix.tex import (
    NONE,
    Tex,
    checked_context,
    decimal,
    escape,
    matrix,
    scientific,
    theorems_context,
    unit,
    with_decimals,
)
from takagi.reports.appendix.turbine import posed_design, vertex_lines
from takagi.reports.loops.plant_local import PlantLocalLoop
from takagi.reports.loops.plant_loop import PlantLoop
from takagi.reports.page.mathml import readable, shortens
from takagi.reports.page.text import at_most, name_of
from takagi.reports.sections.plant.gains import equations_latex, gain_columns, kinds

# A table of gains with more columns does not fit the page: each rule then gets a matrix.
MOST_COLUMNS = 9
MOST_MARGINS = 40
# Steps of a derivation that the appendix writes in its own tables and formulas.
_OWN_STEPS = ("Plant", "Premise ", "Weights", "Memberships", "Rules", "Vertex")
# Bounds are rounded outward by at most this share; points where an extreme may lie, and the
# longest formula of one that is shown.
_ROUNDED, _MOST_POINTS, _LONGEST = 1.1e-7, 400, 48


def latex_context(
    design: PlantDesign, loop: PlantLoop, loops: Sequence[PlantLocalLoop]
) -> dict[str, Any]:
    """Return the values of all names in the templates."""
    name = design.plant.name or "Plant"
    topics = "and theorems" if loop.gains is None else "law, synthesis, theorems and margins"
    return {
        "subject": name,
        "title": name,
        "subtitle": f"Takagi-Sugeno model, {topics}",
        "contents": False,
        **_plant(design.plant),
        **_model(design),
        **_law(design, loop),
        **_claims(design, loop),
        "conditions": [
            *posed_design("Gains", design.design),
            *posed_design("Gains of the observer", design.observer, dual=True),
        ],
        "margins": [_margin_row(local_loop) for local_loop in loops[:MOST_MARGINS]],
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
        "state_names": _listed(v.symbol for v in plant.states),
        "inputs": _listed(v.symbol for v in plant.inputs),
        "disturbances": _listed(v.symbol for v in plant.disturbances if not v.schedules),
        "unknown": _listed(v.symbol for v in plant.disturbances if v.unknown),
        "ranged": _listed(v.symbol for v in plant.disturbances if v.range is not None),
        "unranged": _listed(v.symbol for v in plant.disturbances if v.range is None),
        "follows": Tex(
            " and ".join(f"${_latex(r.follows)} = {_latex(r.name)}$" for r in plant.references)
        ),
        "outputs": [
            Tex(rf"y_{{{k}}} = {readable(_latex(y.expression))}")
            for k, y in enumerate((y for y in plant.outputs if y.name in (plant.measured or ())), 1)
        ],
    }  # fmt: skip


def _listed(symbols: Iterable[Any]) -> Tex:
    return Tex(", ".join(map(_symbol, symbols)))


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


def _model(design: PlantDesign) -> dict[str, Any]:
    model = design.model
    steps = [] if model.derivation is None else model.derivation.steps
    listed_steps = [step for step in steps if not step.title.startswith(_OWN_STEPS)]
    removable = design.document.get("controller", {}).get("removable", {})
    zeros = {member["of"] for members in removable.values() for member in members}
    return {
        "steps": [(step.title.rstrip("."), Tex(readable(step.latex))) for step in listed_steps],
        "rounded": any(shortens(step.latex) for step in listed_steps),
        "premises": [_premise(p, model) for p in model.premises],
        "varying": [Tex(readable(p.latex)) for p in model.premises if len(p.corners) > 1],
        "rules": len(model.rules),
        "vertices": list(vertex_lines(model, measured=design.plant.measured is not None)),
        "model_equation": _equation(model, measured=design.plant.measured is not None),
        "removable": Tex(", ".join(f"${_latex(name)}$" for name in sorted(zeros))),
        "boxed": bool(model.box),
    }


def _premise(premise: Premise, model: TSModel) -> list[Tex]:
    formula = NONE
    ends = (NONE, NONE)
    if premise.proof is not None:
        formula = Tex(f"${readable(_latex(premise.proof.expression))}$")
        ends = _attained(premise, model.box)
    emitted = (decimal(premise.lower), decimal(premise.upper))
    return [Tex(f"${readable(premise.latex)}$"), formula, unit(premise.unit), *ends, *emitted]


def _attained(premise: Premise, box: Mapping[str, Any]) -> tuple[Tex, Tex]:
    """Return exact least and greatest values that the premise takes, as formulas.

    Looked for at the ends of its variables, at 0 and at multiples of pi/4; shown where the bound
    that is used is this value rounded outward, so that it is the extreme to seven decimals.
    """
    import sympy as sp

    assert premise.proof is not None  # asked before
    expression = premise.proof.expression
    sides = {name_of(label): ends for label, ends in box.items()}
    symbols = sorted(expression.free_symbols, key=str)
    if not symbols or any(str(s) not in sides for s in symbols):
        return NONE, NONE
    axes = []
    for symbol in symbols:
        low, high = (sp.Rational(*Fraction(end).as_integer_ratio()) for end in sides[str(symbol)])
        turns = [sp.pi * k / 4 for k in range(-4, 5)]
        axes.append([x for x in dict.fromkeys((low, high, *turns)) if low <= x <= high])
    if np.prod([len(axis) for axis in axes]) > _MOST_POINTS:
        return NONE, NONE
    values = [_value(expression, dict(zip(symbols, at, strict=True))) for at in product(*axes)]
    candidates = [(value, float(value)) for value in values if value is not None and value.is_real]

    def formula_of(bound: Fraction) -> Tex:
        room = _ROUNDED * max(1.0, abs(float(bound)))
        matches = [
            _latex(value) for value, number in candidates if abs(number - float(bound)) <= room
        ]
        best = min(matches, key=len, default="")
        return Tex(f"${best}$") if 0 < len(best) <= _LONGEST else NONE

    return formula_of(premise.lower), formula_of(premise.upper)


def _value(expression: Any, at: Mapping[Any, Any]) -> Any:
    """Return the expression at a point, with its limit where one variable alone makes it 0/0."""
    import sympy as sp

    substituted = expression.subs(at)
    if substituted.is_finite is not False and substituted is not sp.nan:
        return substituted
    zero = [symbol for symbol, value in at.items() if value == 0]
    if len(zero) != 1:
        return None
    nonzero = {symbol: value for symbol, value in at.items() if symbol not in zero}
    return sp.limit(expression.subs(nonzero), zero[0], 0)


def _equation(model: TSModel, *, measured: bool) -> Tex:
    left_side = r"\dot x" if model.sample_time is None else r"x^{+} - x^*"
    several = len(model.rules) > 1
    index, blend = ("i", rf"\sum_{{i=1}}^{{{len(model.rules)}}} h_i") if several else ("1", "")
    terms = [rf"A_{index} \tilde x"]
    terms += [rf"B_{index} \tilde u"] * bool(model.inputs)
    terms += [rf"E_{index} \tilde w"] * bool(np.any(model.E))
    inner = " + ".join(terms)
    equation = (
        rf"{left_side} = {blend} \bigl({inner}\bigr)" if several else f"{left_side} = {inner}"
    )
    if measured:
        equation += rf", \qquad \tilde y = {blend} C_{index} \tilde x"
    return Tex(equation)


def _law(design: PlantDesign, loop: PlantLoop) -> dict[str, Any]:
    context: dict[str, Any] = {"gains": None, "notes": list(design.notes), "observer": None}
    if loop.gains is None:
        return context
    columns = gain_columns(loop)
    if len(columns) > MOST_COLUMNS:
        rows = [
            [escape(i), Tex(f"${matrix(K, exactly=True)}$")] for i, K in enumerate(loop.gains, 1)
        ]
        heads = [Tex("Rule"), Tex("$K_i$, SI units")]
        units = []
    else:
        varying = [k for k, p in enumerate(loop.model.premises) if len(p.corners) > 1]
        corners = (Tex("lower"), Tex("upper"))
        rows = [
            [escape(i), *(corners[rule[k]] for k in varying), *map(decimal, map(float, K.ravel()))]
            for i, (rule, K) in enumerate(zip(loop.model.rules, loop.gains, strict=True), 1)
        ]
        heads = [escape(name) for name, _ in columns]
        units = [[Tex(f"[{unit(of)}]") if of else Tex("") for _, of in columns]]
    context |= {"gain_heads": [heads, *units], "gains": rows}
    if design.output_law is not None:
        context["observer"] = _observer(design.output_law)
    return context


def _observer(law: Any) -> dict[str, Any]:
    """Return the matrices of an observer as emitted, as one display each."""
    constant = getattr(law, "observer", None)
    if constant is not None:
        names = ("A", "B", "C", "L")
        named_matrices = [(name, matrix(getattr(constant, name), exactly=True)) for name in names]
        displays = [Tex(rf"{name}_\mathrm{{o}} = {value}") for name, value in named_matrices]
        return {"matrices": displays, "constant": True}
    same = bool((law.L == law.L[0]).all())
    gains = [
        Tex(f"L{'' if same else f'_{{{i}}}'} = {matrix(L, exactly=True)}")
        for i, L in enumerate(law.L[:1] if same else law.L, 1)
    ]
    return {"matrices": gains, "constant": False, "at_estimate": law.at_estimate, "same": same}


def _claims(design: PlantDesign, loop: PlantLoop) -> dict[str, Any]:
    plant, context = design.plant, theorems_context(design.document, design.checked)
    positions = {v.name: k for k, v in enumerate(plant.states)}
    rows = [positions[r.integral] for r in plant.references]
    ranged = [v for v in plant.disturbances if v.range is not None]
    followed = [v for v in plant.states if v.name in {r.follows for r in plant.references}]
    for theorem in context["theorems"]:
        claim = theorem["claim"]
        claim["inputs"] = _bounds(r"\tilde{%s}", plant.inputs, claim.get("input_limits") or ())
        pushed = plant.inputs if claim.get("disturbance") == "inputs" else plant.disturbances
        claim["entering"] = _bounds(r"\tilde{%s}", pushed, claim.get("disturbance_bounds") or ())
        if claim.get("kind") == "tracking":
            claim["moving"] = _bounds(r"\dot{%s}", ranged, claim["rates"], per=r"\,s^{-1}")
            claim["errors"] = [
                Tex(f"{bound}~{unit(v.unit)} of ${_latex(v.symbol)}$")
                for v, bound in zip(followed, _tracking_errors(claim, rows), strict=False)
            ]
        if claim.get("kind") == "region":
            claim["parts"] = [
                Tex(rf"(L, M) = \left({matrix(p['L'], exactly=True)}, "
                    rf"{matrix(p['M'], exactly=True)}\right)")
                for p in claim["parts"]
            ]  # fmt: skip
    law = design.output_law
    return checked_context(design.document, design.checked) | context | {
        "about_plant": design.is_about_plant,
        "discrete": loop.discrete,
        "shared": design.law is not None and len(design.model.rules) > 1,
        "estimated": law is not None,
        "at_estimate": law is not None and law.at_estimate,
    }  # fmt: skip


def _bounds(
    pattern: str, variables: Iterable[Variable], sizes: Iterable[Any], per: str = ""
) -> list[Tex]:
    """Return |x_k| <= b_k with the unit of x_k, for each bound; for 0 that it does not move."""
    return [
        Tex(rf"$|{pattern % _latex(v.symbol)}| \le {decimal(b)}\,{unit_of_product(v.unit, per)}$")
        if float(b)
        else Tex(rf"${_latex(v.symbol)}$ is constant")
        for v, b in zip(variables, sizes, strict=False)
    ]


def unit_of_product(name: str, per: str) -> Tex:
    """Return a unit with a factor behind it."""
    base_unit = Tex("") if name in ("-", "") else unit(name)
    return Tex(rf"{base_unit}\mathrm{{{per}}}") if per else base_unit


def _tracking_errors(claim: Mapping[str, Any], rows: Sequence[int]) -> list[Tex]:
    """Return c (e + sum d rho)/alpha + residual for each reference, rounded up."""
    names = ("residual_norm", "decay_rate")
    e, alpha = (Fraction(str(claim[name])) for name in names)
    lists = ("slope_norms", "rates", "error_factors", "residuals")
    d, rho, c, residuals = ([Fraction(str(x)) for x in claim[name]] for name in lists)
    push = e + sum((a * b for a, b in zip(d, rho, strict=True)), Fraction(0))
    bounds = [f * push / alpha + residuals[row] for f, row in zip(c, rows, strict=True)]
    return [escape(at_most(float(bound))) for bound in bounds]


def _margin_row(local_loop: PlantLocalLoop) -> list[Tex]:
    m = local_loop.margins
    head = [escape(local_loop.place), escape(name_of(local_loop.input))]
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


def _latex(value: Any) -> str:
    import sympy as sp

    return readable(str(sp.latex(sp.Symbol(value) if isinstance(value, str) else value)))


def _symbol(symbol: Any) -> Tex:
    return Tex(f"${_latex(symbol)}$")
