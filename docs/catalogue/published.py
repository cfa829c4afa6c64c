"""docs/published.md, made of the problems."""

from __future__ import annotations

from catalogue.github import github
from catalogue.problems import PROBLEMS, Problem

__all__ = ["PROBLEMS", "page"]

HEAD = """# Published problems

Numbers of the literature, of other tools' manuals and tests, and closed forms, beside what takagi
finds. The tests named hold them; where "here" is a number or a status, a test finds it again and
compares it to the digits that are printed. "Published" is as printed at the source, or exact where
it says so. This page is written by `make docs`.
"""


COLLECTIONS = """
## Whole collections

`python benchmarks/collections_of_plants.py` runs all 102 plants of COMPleib 1.1 (Leibfritz 2004)
with at most 30 states, state feedback of least H-infinity and H2 norm, at default options and
without sdpa, 100 s a design. Beside it stands the textbook LMI, written in cvxpy and solved by
clarabel, for H2 in both its forms. The data are not part of this repository; the script takes the
folder. "Found" is a claimed norm within a thousandth of the least that any method reached. EB4, IH,
JE2 and NN11 were stopped by the time.

| plants | H-infinity | H2 |
|---|---|---|
| found by takagi and by cvxpy | 71 | 69 |
| found by takagi alone | 14 | 10 |
| found by cvxpy alone | 0 | 4 (EB4, JE2, NN3, ROC10) |
| found by neither | 6 (IH, JE2, NN3, NN11, PAS, ROC10) | 2 (NN11, PAS) |
| the least norm is zero, so there is no thousandth of it | 7 | 8 |
| refused: no disturbance (NN10), a mode that no input moves (REA4) | 2 | 2 |
| refused: white noise reaches the output directly (AC4, HE6, HE7, JE3, NN13) | - | 5 |
| not run within the time (AC13, JE1) | 2 | 2 |

`certify` of the default H-infinity designs with at most 9 states: 59 of 60 end PROVED, each
within 0.07 % of the design's own bound; the other is ROC6.

SDPLIB (Borchers 1999), by `optimise`: control1 to control3, hinf1 to hinf4, hinf6 to hinf9, hinf11
and hinf14 end as candidates at the printed optimum. hinf5 and hinf10 end "unknown" although the
objective is the printed one: the bound of their multipliers lies 0.35 % and 0.15 % below it.
hinf12, hinf13 and hinf15 end "unknown". control4 to control6 were not run.
"""


def page() -> str:
    """Return docs/published.md."""
    lines = [HEAD, "| problem | asks for | published | here | held by | source, notes |"]
    lines.append("|---|---|---|---|---|---|")
    lines += [_row(problem) for problem in PROBLEMS]
    return github("\n".join([lines[0], "\n".join(lines[1:]), COLLECTIONS]))


def _row(problem: Problem) -> str:
    tests = ", ".join(f"`{name}`" for name in problem.tests) or "-"
    notes = "; ".join(text for text in (problem.source, problem.note) if text)
    cells = (problem.name, problem.asks, problem.published, problem.found or "-", tests, notes)
    return f"| {' | '.join(cells)} |"
