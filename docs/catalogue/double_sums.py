"""The section on relaxations: how a double sum over the memberships becomes LMIs."""

from __future__ import annotations

import re
from dataclasses import replace
from inspect import cleandoc
from types import MappingProxyType

import numpy as np

from catalogue.entry import SQUARE, THREE, plant
from catalogue.formula import body
from takagi.lmi import pdc_condition, relaxation_size
from takagi.lmi.sums.product_premises import polya, product
from takagi.lmi.sums.relaxations import RELAXATIONS
from takagi.models import ModelError
from takagi.models.arrays import Indices

WORDS = MappingProxyType(
    {
        "common-gain": (
            "One gain $K$ for all rules, a robust controller without a schedule: one LMI a rule."
        ),
        "wang-tanaka-griffin": "All pairs of rules; the default.",
        "tuan": (
            "$r(r-1)$ sums without unknowns, never more conservative than all pairs; here "
            "$2/(r-1) = 1$."
        ),
        "tanaka-wang": (
            "With a slack matrix a pair may be worse if each rule alone is better; here "
            "$r - 1 = 2$."
        ),
        "kim-lee": "A symmetric slack matrix for each pair; $E_i$ are the block columns of $I$.",
        "liu-zhang": (
            "As Kim and Lee's, with one slack $X \\prec 0$; blocks off the diagonal need not be "
            "symmetric."
        ),
        "polya-2": (
            "Every coefficient of $(h_1 + \\dots + h_r)^d \\sum_{ij} h_i h_j \\Theta_{ij}$, here "
            "for $d = 2$. Degree 0 is all pairs; necessary and sufficient as $d$ grows."
        ),
        "product-1": (
            "For models with premises, whose memberships are products of weights $w_{kc}$ of "
            "corner $c$ of premise $k$: equal products are added up, each premise raised by $d$, "
            "here $d = 1$. Never more conservative than all pairs; necessary and sufficient as "
            "$d$ grows."
        ),
        "product-liu-zhang": "Liu and Zhang's slack, with equal products added up.",
    }
)
NAMES = tuple(WORDS)
# Those that words say.
WITHOUT_FORMULA = ("common-gain", "liu-zhang", "product-liu-zhang")
# What is the condition's own, whatever the relaxation.
OWN = ("Q positive definite", "scale of Q", "input effort")
RULES = (4, 16)
# What the product prints -> the same by Theta_ij = He(A_i Q - B_i M_j) + 2 alpha Q.
BY_THETA = MappingProxyType(
    {
        r"\mathrm{He}\left(A_{i} Q - B_{i} M_{i}\right) + 2\alpha Q": r"\Theta_{ii}",
        r"\mathrm{He}\left(A_{i} Q - B_{i} M_{j} + A_{j} Q - B_{j} M_{i}\right) + 4\alpha Q": (
            r"\Theta_{ij} + \Theta_{ji}"
        ),
        r"\mathrm{He}\left(2A_{i} Q - B_{i} M_{i} - B_{i} M_{j} + A_{j} Q - B_{j} M_{i}\right)"
        r" + 6\alpha Q": r"\Theta_{ii} + \Theta_{ij} + \Theta_{ji}",
    }
)

INTRODUCTION = r"""A law whose gains share the memberships of the model leads to
$\sum_{ij} h_i h_j \Theta_{ij} \prec 0$ for all $h_i \ge 0$, $\sum_i h_i = 1$. A relaxation is a
finite set of LMIs that implies it. `relaxation=` takes the names below, or `"auto"`: the
relaxations in the order of their cost, until there are gains. The formulas are for `pdc` in
continuous time, $\Theta_{ij} = \mathrm{He}(A_i Q - B_i M_j) + 2\alpha Q$, with three rules
("product": two premises with two corners each).
"""

COSTS = """LMIs of one double sum and, after a plus, additional variables, for n = 4 (products:
premises with two corners each):
"""


def section() -> str:
    """Return the section in Markdown."""
    parts = [INTRODUCTION, *(_relaxation(name) for name in NAMES), COSTS, _costs()]
    return "\n".join(parts)


def _relaxation(name: str) -> str:
    lines = [f"### `{_named(name)}`", "", WORDS[name], ""]
    if name not in WITHOUT_FORMULA:
        lines += ["```math", _formula(name), "```", ""]
    source = _source(name)
    return "\n".join([*lines, *([f"Source: {source}", ""] if source else [])])


def _formula(name: str) -> str:
    sizes = SQUARE if name.startswith("product") else THREE
    condition = pdc_condition(plant(sizes), relaxation=name)
    lmis = tuple(lmi for lmi in condition.lmis if lmi.name not in OWN)
    formula = body(replace(condition, lmis=lmis, objective={}), sizes, declare=False)
    for printed, short in BY_THETA.items():
        formula = formula.replace(printed, short)
    return formula


def _named(name: str) -> str:
    return re.sub(r"-\d+$", "-<d>", name)


def _source(name: str) -> str:
    """Return the source that the relaxation's docstring names; "" for none."""
    functions = {**RELAXATIONS, "polya-2": polya, "product-1": product}
    for paragraph in cleandoc(functions[name].__doc__ or "").split("\n\n"):
        text = " ".join(paragraph.split())
        if text.startswith("Source: ") and not text.startswith(("Source: as", "Source: derived")):
            return text.removeprefix("Source: ")
    return ""


def _costs() -> str:
    lines = ["| relaxation | " + " | ".join(f"{r} rules" for r in RULES) + " |"]
    lines.append("|---" * (len(RULES) + 1) + "|")
    for name in ("common-gain", *NAMES[1:6], "polya-1", "polya-4", *NAMES[7:]):
        lines.append(f"| `{name}` | " + " | ".join(_cost(name, r) for r in RULES) + " |")
    return "\n".join(lines) + "\n"


def _cost(name: str, rules: int) -> str:
    try:
        size = relaxation_size(name, rules, _corners(rules), size=4)
    except ModelError:
        return "-"
    return f"{size.lmis}" + (f"+{size.slack_variables}" if size.slack_variables else "")


def _corners(rules: int) -> Indices:
    """Return (r, k) for r = 2^k rules, each a corner of k premises."""
    premises = rules.bit_length() - 1
    return np.array(list(np.ndindex(*(2,) * premises)), dtype=np.intp)
