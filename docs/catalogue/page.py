"""docs/conditions.md, made of the entries."""

from __future__ import annotations

import re
from types import MappingProxyType

from catalogue import norms, outputs, regions, sets, stability, synthesis
from catalogue.double_sums import section
from catalogue.entry import Case, Entry
from catalogue.formula import changes, counts, formula
from catalogue.github import github
from takagi.lmi import Condition
from takagi.lmi.gains.disturbance.sums import BARS

SECTIONS = MappingProxyType(
    {
        "Stability of a given loop": stability.ENTRIES,
        "Disturbances on a given loop": norms.ENTRIES,
        "Regions": regions.ENTRIES,
        "Sets that a given loop keeps": sets.ENTRIES,
        "Gains": synthesis.ENTRIES + outputs.ENTRIES,
    }
)

HEAD = r"""# Conditions

For those who look up a condition of `takagi.lmi`: question, formula, cost and source. `make docs`
typesets the formulas from the objects that the solver gets. An answer is a candidate, checked by
eigenvalues and not proved: [what an answer means](lmi.md#what-an-answer-means).

## How to read them

- An entry begins with its function and its builder, which solves nothing.
- $r$ rules (or vertices), $n$ states, $m$ inputs, $p$ outputs, $q$ disturbances. The memberships
  are $h_i(z) \ge 0$ with $\sum_i h_i = 1$. The plant is
  $\dot x = \sum_i h_i (A_i x + B_i u + E_i w)$, $y = \sum_i h_i (C_i x + D_i u)$; in discrete time
  $x^+$ stands for $\dot x$. The law is $u = -\sum_i h_i K_i x$.
- $\alpha$ is a decay rate in 1/s: $\dot V \le -2 \alpha V$, or with the sample time $T$
  $V(x^+) \le \rho^2 V(x)$, $\rho = e^{-\alpha T}$.
- $\mathrm{He}(X) = X + X^\top$; an asterisk is the block that symmetry implies; $\mathbb{S}^n$ are
  the symmetric matrices. $\prec$, $\succ$ hold with a margin, $\preceq$, $\succeq$ may be touched.
- Not printed: the matrix of $V$, $P$ or $Q = P^{-1}$, is positive definite, and its scale is
  fixed, as by $P \preceq I$.
- A line with $i$ and no range of $i$ holds for every rule.
- A line with $\Theta_{ii}$ stands for $\sum_{ij} h_i h_j \Theta_{ij} \prec 0$, where the gain in
  $\Theta_{ij}$ has the index $j$. A [relaxation](#relaxations) makes LMIs of it: by default
  $\Theta_{ii} \prec 0$, and $\Theta_{ij} + \Theta_{ji} \prec 0$ for $i < j$.
- A further form prints only what differs from the first form, or from the one that it names: a
  line replaces the line of its name, or is added. One with "find" or "minimise" is whole.
- In discrete time a bar divides $A_i - I$ (written $\bar A_i$) and $B_i$ by $s$, and $C_i$,
  $D^{12}_i$, $E_i$ by $\sqrt s$. Any $s > 0$ gives the same inequality.
- "Cost" counts LMIs (cones) and scalar unknowns of the forms above it, with all pairs of rules.
"""


def entries() -> tuple[Entry, ...]:
    """Return all entries, in the order of the page."""
    return tuple(entry for group in SECTIONS.values() for entry in group)


def page() -> str:
    """Return the page in Markdown."""
    parts = [HEAD, _contents()]
    for title, group in SECTIONS.items():
        parts += [f"## {title}\n", *(_entry(entry) for entry in group)]
    parts += ["## Relaxations\n", section()]
    return github("\n".join(parts))


def anchor(title: str) -> str:
    """Return what GitHub makes of a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def _contents() -> str:
    lines = ["## All conditions", ""]
    for title, group in SECTIONS.items():
        links = ", ".join(f"[`{entry.call}`](#{anchor(entry.title)})" for entry in group)
        lines.append(f"- {title}: {links}")
    return "\n".join(lines) + "\n"


def _entry(entry: Entry) -> str:
    calls = f"`takagi.lmi.{entry.call}`"
    if entry.builder:
        calls += f", `takagi.lmi.{entry.builder}`"
    lines = [f"### {entry.title}", "", calls, "", entry.question, entry.use, ""]
    conditions = [case.pose(case.sizes) for case in entry.cases]
    costs = [_cost(*form) for form in zip(entry.cases, conditions, strict=True)]
    formulas = [
        formula(condition, case.sizes)
        for case, condition in zip(entry.cases, conditions, strict=True)
    ]
    for number, case in enumerate(entry.cases):
        lines += _case(
            case, formulas[number], list(zip(entry.cases[:number], formulas[:number], strict=True))
        )
        if costs[number] not in costs[number + 1 : number + 2]:
            lines += [costs[number], ""]
    named = (source for condition in conditions for source in condition.source.split("; "))
    # The bars of discrete time are no source, and the head explains them.
    sources = dict.fromkeys(source for source in named if source and source != BARS)
    lines += ["Source: " + "; ".join(sources) + ".", ""]
    return "\n".join(lines)


def _case(case: Case, text: str, earlier: list[tuple[Case, str]]) -> list[str]:
    """Return a form; of a further one, the lines that differ from the nearest one before it."""
    title = f"**{case.title}**"
    if earlier:
        differences = [(other, *changes(text, before)) for other, before in earlier]
        nearest, shown, lacking = min(differences, key=lambda form: len(form[1]))
        if len(lacking) <= 1:
            if nearest is not earlier[0][0]:
                title += f", as {nearest.title[0].lower()}{nearest.title[1:]}"
            title += "".join(f', without "{name}"' for name in lacking)
            text = shown
    where = [f"Where {case.where}.", ""] if case.where else []
    return [title, "", "```math", text, "```", "", *where]


def _cost(case: Case, condition: Condition) -> str:
    lmis = case.lmis or str(counts(condition)[0])
    return f"Cost: ${_printed(lmis)}$ LMIs, ${_printed(case.variables)}$ variables."


def _printed(expression: str) -> str:
    """Return an expression in r, n, m, p, q as a paper prints it."""
    return re.sub(r"\s|(?<=\w)\*(?=[\w(])", "", expression)
