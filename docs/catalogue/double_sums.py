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
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.product_premises import polya, product
from takagi.lmi.sums.relaxations import RELAXATIONS
from takagi.models import ModelError

WORDS = MappingProxyType(
    {
        "common-gain": "One gain for all rules: a robust controller without a schedule.",
        "wang-tanaka-griffin": "All pairs of rules. No unknowns of its own; the default.",
        "tuan": (
            "$r(r-1)$ sums without unknowns, never more conservative than all pairs. With "
            "`active_rules` $s$ of the rules act at a time: $2/(s-1)$ in the place of $2/(r-1)$."
        ),
        "tanaka-wang": (
            "With a slack matrix a pair may be worse if each rule alone is better. With "
            "`active_rules` $s - 1$ stands in the place of $r - 1$."
        ),
        "kim-lee": "A symmetric slack matrix for each pair; $E_i$ are the block columns of $I$.",
        "liu-zhang": (
            "As Kim and Lee's, but the blocks off the diagonal of $X$ need not be symmetric."
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
# What is the condition's own, whatever the relaxation.
OWN = ("Q positive definite", "scale of Q", "input effort")
RULES = (2, 4, 8, 16)

INTRODUCTION = r"""A law whose gains share the memberships of the model leads to

```math
\sum_{i=1}^r \sum_{j=1}^r h_i h_j \Theta_{ij} \prec 0
\quad\text{for all } h_i \ge 0,\ \textstyle\sum_i h_i = 1,
```

and a relaxation is a finite set of LMIs that implies it. `relaxation=` takes the names below, or
`"auto"`: the relaxations in the order of their cost, until there are gains. `relaxation_ladder`
shows cost and result of each. The formulas are for `pdc` in continuous time with three rules
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
    sizes = SQUARE if name.startswith("product") else THREE
    condition = pdc_condition(plant(sizes), relaxation=name)
    lmis = tuple(lmi for lmi in condition.lmis if lmi.name not in OWN)
    formula = body(replace(condition, lmis=lmis, objective={}), sizes, declare=False)
    lines = [f"### `{_named(name)}`", "", WORDS[name], "", "```math", formula, "```", ""]
    source = _source(name)
    return "\n".join([*lines, *([f"Source: {source}", ""] if source else [])])


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
    for name in ("common-gain", *NAMES[1:6], "polya-1", "polya-2", "polya-4", *NAMES[7:]):
        lines.append(f"| `{name}` | " + " | ".join(_cost(name, r) for r in RULES) + " |")
    return "\n".join(lines) + "\n"


def _cost(name: str, rules: int) -> str:
    try:
        size = relaxation_size(name, rules, _corners(rules), size=4)
    except ModelError:
        return "-"
    return f"{size.lmis}" + (f"+{size.slack_variables}" if size.slack_variables else "")


def _corners(rules: int) -> Corners:
    """Return (r, k) for r = 2^k rules, each a corner of k premises."""
    premises = rules.bit_length() - 1
    return np.array(list(np.ndindex(*(2,) * premises)), dtype=np.intp)
