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
from takagi.lmi.gains.disturbance.disturbed_plant import BARS

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

The conditions of `takagi.lmi`, with formula, cost and source. `make docs` typesets the formulas
from what the solver gets. An answer is a candidate, not proved:
[what an answer means](lmi.md#what-an-answer-means).

## How to read them

- An entry begins with its function and its builder, which solves nothing. A form that "Also" names
  is printed by `takagi.lmi.latex` of what the builder returns.
- $r$ rules (or vertices), $n$ states, $m$ inputs, $p$ outputs, $q$ disturbances; memberships
  $h_i(z) \ge 0$ with $\sum_i h_i = 1$. The plant is $\dot x = \sum_i h_i (A_i x + B_i u + E_i w)$,
  $y = \sum_i h_i (C_i x + D_i u)$; in discrete time $x^+$ stands for $\dot x$. The law is
  $u = -\sum_i h_i K_i x$.
- $\alpha$ is a decay rate in 1/s: $\dot V \le -2 \alpha V$, or with the sample time $T$
  $V(x^+) \le \rho^2 V(x)$, $\rho = e^{-\alpha T}$.
- $\mathrm{He}(X) = X + X^\top$; an asterisk is the block that symmetry implies; $\mathbb{S}^n$ are
  the symmetric matrices. $\prec$, $\succ$ hold with a margin, $\preceq$, $\succeq$ may be touched.
- Not printed: the matrix of $V$, $P$ or $Q = P^{-1}$, is positive definite, and its scale is
  fixed, as by $P \preceq I$.
- A line with $i$ and no range of $i$ holds for every rule.
- A line with $\Theta_{ii}$ stands for $\sum_{ij} h_i h_j \Theta_{ij} \prec 0$, where the gain in
  $\Theta_{ij}$ has the index $j$. A [relaxation](#relaxations) makes LMIs of it.
- A further form prints only what differs from the first: a line replaces the line of its name, or
  is added.
- "Cost" counts LMIs (cones) and scalar unknowns, with all pairs of rules; of a form after "Also"
  where it differs.
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
    lines = [f"### {entry.title}", "", calls, "", f"{entry.question} {entry.use}", ""]
    conditions = [case.pose(case.sizes) for case in entry.cases]
    costs = [_cost(*form) for form in zip(entry.cases, conditions, strict=True)]
    formulas = [
        formula(condition, case.sizes)
        for case, condition in zip(entry.cases, conditions, strict=True)
    ]
    shown = [number for number, case in enumerate(entry.cases) if case.shown]
    for place, number in enumerate(shown):
        lines += _case(entry.cases[number], formulas[number], formulas[0] if place else "")
        if costs[number] not in [costs[after] for after in shown[place + 1 : place + 2]]:
            lines += [f"Cost: {costs[number]}.", ""]
    if not shown:
        lines += [f"Cost: {costs[0]}.", ""]
    also = [
        case.title[0].lower() + case.title[1:] + ("" if cost == costs[0] else f" ({cost})")
        for case, cost in zip(entry.cases, costs, strict=True)
        if not case.shown
    ]
    if also:
        lines += ["Also: " + "; ".join(also) + ".", ""]
    named = (source for condition in conditions for source in condition.source.split("; "))
    # The bars of discrete time are no source.
    sources = dict.fromkeys(source for source in named if source and source != BARS)
    lines += ["Source: " + "; ".join(sources) + ".", ""]
    return "\n".join(lines)


def _case(case: Case, text: str, first: str) -> list[str]:
    """Return a form; of a further one, the lines alone that differ from the first form."""
    shown = changes(text, first) if first else text
    where = [f"Where {case.where}.", ""] if case.where else []
    return [f"**{case.title}**", "", "```math", shown, "```", "", *where]


def _cost(case: Case, condition: Condition) -> str:
    lmis = case.lmis or str(counts(condition)[0])
    return f"${_printed(lmis)}$ LMIs, ${_printed(case.variables)}$ variables"


def _printed(expression: str) -> str:
    """Return an expression in r, n, m, p, q as a paper prints it."""
    return re.sub(r"\s|(?<=\w)\*(?=[\w(])", "", expression)
