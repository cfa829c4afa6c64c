"""The matrix inequalities that gains were found with, typeset from what the solver was given."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from takagi.lmi.condition.typeset import formula_lines, plain_label
from takagi.reports.appendix.tex import Tex, decimal, escape, listed

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.lmi.condition.term import Condition

# What a formula contains -> what the symbol means.
_SYMBOLS = (
    (r"\mathrm{He}", r"$\He(X) = X + X^\top$"),
    ("M_{i}", "$K_i = M_i Q^{-1}$ and $P = Q^{-1}$"),
    (r"\nu", r"$\nu$ bounds the effort, $K Q K^\top \preceq \nu I$"),
    (r"\bar u_k", r"$\bar u_k$ is the limit of input $k$"),
    (r"\bar x_k", r"$\bar x_k$ is the half width of the range of state $k$"),
    (r"\rho", r"$\rho = e^{-\alpha T}$"),
    ("(F S)", r"$K = M S^{-1}$, $\int |F x|^2 + |G u|^2\,dt$ is the cost"),
    (r"L^\top", r"$L L^\top$ is the mean of the starts"),
    (r"T_{\text{lower}}", "$T$ is a triangular factor; its diagonal bounds the volume"),
    (r"e_k^\top", "$e_k$ is column $k$ of the unit matrix"),
)  # fmt: skip
_DUAL = (
    r"The problem is the dual one: $A_i$ and $B_i$ stand for the transposed matrices of the error "
    r"and its outputs, and $L^\top = M Q^{-1}$ is the gain."
)
_RELAXATIONS = {"wang-tanaka-griffin": "all pairs", "common-gain": "one gain for all rules"}


def posed(
    title: str,
    condition: Condition,
    *,
    numbers: Sequence[Tex] = (),
    remark: str = "",
    renamed: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Any]:
    """Return the values of one condition in the templates: what it says, line by line.

    Parameters
    ----------
    numbers : of the data that were used.
    remark : what is to be said of its symbols; "" takes those that are known.
    renamed : symbol of the builder -> symbol of the appendix, where that has another meaning for
        the first.
    """
    lines = formula_lines(condition)
    for symbol, replacement in renamed.items():
        lines = [(label, formula.replace(symbol, replacement)) for label, formula in lines]
    everything = " ".join(formula for _, formula in lines)
    explanations = [words for token, words in _SYMBOLS if token in everything]
    return {
        "title": title,
        "source": condition.source,
        "numbers": list(numbers),
        "remark": Tex(remark or f"Here {'; '.join(explanations)}."),
        "lines": [(escape(plain_label(label)), _powers(formula)) for label, formula in lines],
    }


def _powers(formula: str) -> Tex:
    return Tex(re.sub(r"(\d)e([+-]\d+)", lambda m: rf"{m[1]} \cdot 10^{{{int(m[2])}}}", formula))


def posed_design(title: str, design: Design | None, *, dual: bool = False) -> list[dict[str, Any]]:
    """Return the same for gains with the numbers used; [] for gains that were given.

    Parameters
    ----------
    dual : whether they are an observer's, found by the dual problem.
    """
    if design is None or design.answer.condition is None:
        return []
    name, scales = design.relaxation, design.answer.coordinates
    relaxation = f"{_RELAXATIONS[name]} ({name})" if name in _RELAXATIONS else name
    numbers = [Tex(f"relaxation of the double sum: {escape(relaxation)}")]
    if design.decay_rate:
        numbers.insert(0, Tex(rf"$\alpha = {decimal(design.decay_rate)}$~1/s"))
    if scales is not None:
        numbers.append(Tex(f"states in units of $({listed(map(float, scales))})$"))
    remark = _DUAL if dual else ""
    return [posed(title, design.answer.condition, numbers=numbers, remark=remark)]
