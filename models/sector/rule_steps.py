"""The last steps of a derivation: domain, weights, numbering of the rules, vertex matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING

from takagi.models.arrays import Floats
from takagi.models.equations.step import Step
from takagi.models.ts.premise import Premise
from takagi.models.ts.vertex_product import VertexProduct

if TYPE_CHECKING:
    from takagi.models.intervals.interval import Interval
    from takagi.models.ranges.cell import Cell
    from takagi.models.ranges.domain import Domain

MOST_LISTED = 16  # the most rules whose corners and vertices are written out


def rule_steps(
    premises: Sequence[Premise], products: Mapping[str, VertexProduct], *, discrete: bool = False
) -> tuple[Step, ...]:
    """Return the steps from proved ranges to vertices; empty for a model without premises.

    Up to 16 rules are listed with their matrices, to six digits; of more the numbering alone.
    """
    varying = [premise for premise in premises if len(premise.corners) > 1]
    if not varying:
        return ()
    corners = list(product(*(range(len(p.corners)) for p in varying)))
    steps = [
        Step("Weights of the premises.", r" \\ ".join(_weights(premise) for premise in varying)),
        _numbering(varying, len(corners), products, discrete),
    ]
    if len(corners) <= MOST_LISTED:
        steps.append(_listed(varying, corners))
        stacks = {letter: found.stack() for letter, found in products.items()}
        steps += [_vertex(rule, stacks) for rule in range(len(corners))]
    steps[0] = Step(steps[0].title, rf"\begin{{gathered}}{steps[0].latex}\end{{gathered}}")
    return tuple(steps)


def _weights(premise: Premise) -> str:
    z = premise.latex
    lower, upper = (f"{float(end):.9g}" for end in premise.corners)
    width = f"{float(premise.upper - premise.lower):.9g}"
    minus = f"- {lower}" if premise.lower >= 0 else f"+ {lower.removeprefix('-')}"
    first = rf"w_{{{z},0}} = \frac{{{upper} - {z}}}{{{width}}}"
    return first + rf", \quad w_{{{z},1}} = \frac{{{z} {minus}}}{{{width}}}"


def _numbering(
    varying: Sequence[Premise], count: int, products: Mapping[str, VertexProduct], discrete: bool
) -> Step:
    names = ", ".join(premise.name for premise in varying)
    weights = r"\, ".join(f"w_{{{p.latex},c_{{i,{k}}}}}" for k, p in enumerate(varying, start=1))
    pairs = (("A", "x"), ("B", "u"), ("E", "w"))
    terms = " + ".join(f"{m}_i {v}" for m, v in pairs if m in products and products[m].columns)
    left = "x^+" if discrete else r"\dot x"
    return Step(
        f"Memberships of the {count} rules; c counts the corners (0 lower, 1 upper) of {names}, "
        "the last changing first.",
        rf"h_i = {weights}, \qquad {left} = \sum_{{i=1}}^{{{count}}} h_i \left({terms}\right)",
    )


def _listed(varying: Sequence[Premise], corners: Sequence[tuple[int, ...]]) -> Step:
    head = " & ".join(["i", *(premise.latex for premise in varying)])
    rows = []
    for i, rule in enumerate(corners, start=1):
        values = [f"{float(p.corners[c]):.6g}" for p, c in zip(varying, rule, strict=True)]
        rows.append(" & ".join([str(i), *values]))
    body = r" \\ ".join([head + r" \\ \hline " + rows[0], *rows[1:]])
    columns = "c|" + "c" * len(varying)
    return Step("Rules and their corners.", rf"\begin{{array}}{{{columns}}}{body}\end{{array}}")


def _vertex(rule: int, stacks: Mapping[str, Floats]) -> Step:
    shown = [
        rf"{letter}_{{{rule + 1}}} = " + _matrix(stack[rule])
        for letter, stack in stacks.items()
        if stack.size
    ]
    return Step(f"Vertex {rule + 1}.", r",\quad ".join(shown))


def _matrix(rows: Floats) -> str:
    body = r"\\".join(" & ".join(_number(value) for value in row) for row in rows)
    return rf"\begin{{pmatrix}}{body}\end{{pmatrix}}"


def _number(value: float) -> str:
    text = f"{value:.6g}"
    if "e" not in text:
        return text
    mantissa, exponent = text.split("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"


MOST_SHOWN = 4


def domain_steps(domain: Domain | None) -> tuple[Step, ...]:
    """Return the steps of the derivation about a band or a union of cells; none for a box."""
    if domain is None:
        return ()
    count = len(domain.cells)
    shown = [_cell(cell) for cell in domain.cells[:MOST_SHOWN]]
    title = "Domain: the bounds hold there, not on the whole box around it"
    title += f"; {count} cells" if count > 1 else ""
    title += f", the first {MOST_SHOWN} of them are shown." if count > MOST_SHOWN else "."
    return (Step(title, r"\begin{gathered}" + r" \\ ".join(shown) + r"\end{gathered}"),)


def _cell(cell: Cell) -> str:
    import sympy as sp

    parts = [rf"{sp.latex(s)} \in {_ends(side)}" for s, side in cell.box.items()]
    parts += [f"{sp.latex(s)} = {sp.latex(place)}" for s, place in cell.places.items()]
    return r",\ ".join(parts)


def _ends(side: Interval) -> str:
    return rf"[{float(side.lower):.6g},\ {float(side.upper):.6g}]"
