"""docs/conditions.md, made of the entries."""

from __future__ import annotations

import re
from types import MappingProxyType

from catalogue import norms, outputs, regions, sets, stability, synthesis
from catalogue.double_sums import section
from catalogue.entry import Case, Entry
from catalogue.formula import counts, formula
from catalogue.github import github
from takagi.lmi import Condition

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

For those who look up a condition: every one that `takagi.lmi` poses, with its question, formula,
cost and source. The formulas are typeset by `make docs` from the objects that are given to the
solver.

How to read them:

- $\mathrm{He}(X) = X + X^\top$; an asterisk is the block that symmetry implies; $\mathbb{S}^n$ are
  the symmetric matrices. $\prec$, $\succ$ hold with a margin, $\preceq$, $\succeq$ may be touched.
- $r$ rules (or vertices), $n$ states, $m$ inputs, $p$ outputs, $q$ disturbances. $h_i(z) \ge 0$,
  $\sum_i h_i = 1$ are the memberships; the plant is $\dot x = \sum_i h_i (A_i x + B_i u + E_i w)$,
  $y = \sum_i h_i (C_i x + D_i u)$, or $x^+$ in the place of $\dot x$; the law
  $u = -\sum_i h_i K_i x$.
- $\alpha$ is a decay rate in 1/s: $\dot V \le -2 \alpha V$; in discrete time, with the sample time
  $T$, it is $V(x^+) \le \rho^2 V(x)$ with $\rho = e^{-\alpha T}$.
- Two lines of most conditions are left out: the matrix of $V$, $P$ or $Q = P^{-1}$, is positive
  definite, and its scale is fixed, as by $P \preceq I$.
- "Rule" defines $\Theta_{ii}$; in the "pair" below it $\Theta_{ij}$ has the gain with index $j$.
- "Cost" counts LMIs (cones) and scalar unknowns, of every form above it that has none of its own;
  "pairs" is for `relaxation="wang-tanaka-griffin"`.

What is found is a candidate, checked by eigenvalues and not proved:
[the guide](lmi.md#what-an-answer-means) says what that means, and how to get a proof.
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
    lines = ["| condition | call | time |", "|---|---|---|"]
    for entry in entries():
        titles = " ".join(case.title for case in entry.cases).lower()
        times = [
            word for word in ("continuous", "discrete") if word in titles or "time" not in titles
        ]
        link = f"[{entry.title}](#{anchor(entry.title)})"
        lines.append(f"| {link} | `{entry.call}` | {' and '.join(times)} |")
    return "\n".join(lines) + "\n"


def _entry(entry: Entry) -> str:
    calls = f"`takagi.lmi.{entry.call}`"
    if entry.builder:
        calls += f"; posed by `takagi.lmi.{entry.builder}`"
    lines = [f"### {entry.title}", "", entry.question, "", f"Call: {calls}.", "", entry.use, ""]
    conditions = [case.pose(case.sizes) for case in entry.cases]
    costs = [_cost(*form) for form in zip(entry.cases, conditions, strict=True)]
    for number, (case, condition) in enumerate(zip(entry.cases, conditions, strict=True)):
        lines += _case(case, condition)
        if costs[number] not in costs[number + 1 : number + 2]:
            lines += [costs[number], ""]
    named = (source for condition in conditions for source in condition.source.split("; "))
    sources = dict.fromkeys(filter(None, named))
    lines += ["Source: " + "; ".join(sources) + ".", ""]
    return "\n".join(lines)


def _case(case: Case, condition: Condition) -> list[str]:
    where = [f"Where {case.where}.", ""] if case.where else []
    text = formula(condition, case.sizes)
    return [f"**{case.title}**", "", "```math", text, "```", "", *where]


def _cost(case: Case, condition: Condition) -> str:
    lmis = case.lmis or str(counts(condition)[0])
    return f"Cost: ${_printed(lmis)}$ LMIs, ${_printed(case.variables)}$ variables."


def _printed(expression: str) -> str:
    """Return an expression in r, n, m, p, q as a paper prints it."""
    text = re.sub(r"(\w)\*\((\w)\+1\)/2", r"\1(\2+1)/2", expression)
    return re.sub(r"\s*\*\s*", " ", text)
