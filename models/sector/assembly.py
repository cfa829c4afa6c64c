"""From entries in premise symbols to a TSModel: exactness check, vertices, derivation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from takagi.models.equations.equations import Equations, Factored
from takagi.models.equations.step import Step
from takagi.models.intervals.interval import Interval, Number
from takagi.models.sector.exactness import Exactness, check_exact
from takagi.models.sector.multilinear import vertex_product
from takagi.models.sector.rule_steps import rule_steps
from takagi.models.ts.derivation import Derivation
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.equations.symbolic_form import SymbolicForm

LETTERS = ("A", "B", "C", "D", "E")


def assemble(
    plant: Equations,
    factored: Factored,
    premises: Sequence[Premise],
    *,
    steps: Sequence[Step] = (),
    names: Mapping[str, Sequence[str]] | None = None,
    box: Mapping[str, tuple[Number, Number]],
    sides: Mapping[sp.Symbol, Interval] | None = None,
    form: SymbolicForm | None = None,
    tell_rules: bool = False,
    name: str,
    source: str,
) -> TSModel:
    """Return the TSModel with the entries' values at every corner of the premises.

    Parameters
    ----------
    premises : one per symbol of ``factored.premises``, in that order.
    steps : put between the plant and its factored form in the derivation.
    names : states, inputs, outputs, disturbances; None names them by symbol and unit.
    sides : range of each variable, for the check of exactness at points.
    form : kept in the derivation.
    tell_rules : end the derivation with weights, rules and vertices.

    Raises
    ------
    ModelError : the factored form is not exact, or an entry is not multilinear in the premises.
    """
    shown = check_exact(factored.pairs(plant), dict(sides or {}))
    corners = [premise.corners for premise in premises]
    products = {
        letter: vertex_product(
            matrix, list(factored.premises), corners, constants=factored.constants, letter=letter
        )
        for letter, matrix in factored.matrices.items()
        if letter == "A" or 0 not in matrix.shape
    }
    labels = names or {
        "states": plant.named(plant.states),
        "inputs": plant.named(plant.inputs),
        "outputs": tuple(f"y{k} [-]" for k in range(1, len(plant.outputs) + 1)),
        "disturbances": plant.named(plant.disturbances),
    }
    derivation = replace(_derivation(plant, factored, premises, steps, shown), form=form)
    if tell_rules:
        told = rule_steps(premises, products, discrete=plant.sample_time is not None)
        derivation = replace(derivation, steps=(*derivation.steps, *told))
    return TSModel(
        products["A"],
        products.get("B"),
        C=products.get("C"),
        D=products.get("D"),
        E=products.get("E"),
        states=labels["states"],
        inputs=labels["inputs"],
        outputs=labels["outputs"],
        disturbances=labels["disturbances"],
        premises=premises,
        box=box,
        sample_time=plant.sample_time,
        name=name,
        source=source,
        derivation=derivation,
    )


def _derivation(
    plant: Equations,
    factored: Factored,
    premises: Sequence[Premise],
    between: Sequence[Step],
    shown: Exactness,
) -> Derivation:
    import sympy as sp

    symbols = {s: sp.Symbol(p.latex) for s, p in zip(factored.premises, premises, strict=True)}
    mark = r"\dot{{{}}}" if plant.sample_time is None else "{}^+"
    left = _matrix(sp.Matrix([sp.Symbol(mark.format(sp.latex(s))) for s in plant.states]))
    terms = [
        _matrix(factored.matrices[letter].subs(symbols)) + _matrix(sp.Matrix(vector))
        for letter, vector in (("A", plant.states), ("B", plant.inputs), ("E", plant.disturbances))
        if vector
    ]
    steps = [
        Step("Plant.", left + " = " + _matrix(sp.Matrix(plant.f))),
        *between,
        Step(
            f"Factored form, equal to the plant: {shown.words}.", left + " = " + " + ".join(terms)
        ),
    ]
    if factored.constants:
        values = [rf"{sp.latex(s)} = {_decimal(v)}" for s, v in factored.constants.items()]
        steps.append(Step("Constants, in SI units.", r",\quad ".join(values)))
    expressions = factored.premises.values()
    steps += [_premise_step(p, e) for p, e in zip(premises, expressions, strict=True)]
    sampled = [premise.name for premise in premises if premise.sampled]
    doubt = f"; bounds of {', '.join(sampled)} sampled, which is no proof" if sampled else ""
    return Derivation(tuple(steps), exactness=shown.words + doubt)


def _premise_step(premise: Premise, expression: sp.Expr) -> Step:
    import sympy as sp

    unit = "" if premise.unit == "-" else rf"\ \mathrm{{[{premise.unit}]}}"
    bounds = rf"{_decimal(premise.lower)} \le {premise.latex} \le {_decimal(premise.upper)}"
    return Step(
        f"Premise {premise.name}; bounds: {premise.evidence}.",
        rf"{premise.latex} = {sp.latex(expression)}, \qquad {bounds}{unit}",
    )


def _matrix(matrix: sp.Matrix) -> str:
    import sympy as sp

    return str(sp.latex(matrix, mat_delim="", mat_str="pmatrix"))


def _decimal(value: Number) -> str:
    text = f"{float(value):.12g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    return text
