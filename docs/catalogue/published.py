"""docs/published.md, made of the problems."""

from __future__ import annotations

from catalogue.github import github
from catalogue.problems import PROBLEMS, Problem

HEAD = """# Published problems

This page compares takagi's results with numbers of the literature, of other tools' manuals and
tests, and with closed forms. The named tests check them: where "here" is a number or a status, a
test computes it again and compares it with the printed digits. "Published" is as printed at the
source, or exact where it says so. This page is written by `make docs`.
"""


COLLECTIONS = """
## Whole collections

`python benchmarks/collections_of_plants.py` runs all 102 plants of COMPleib 1.1 (Leibfritz 2004)
with at most 30 states: state feedback of least H-infinity and H2 norm, at default options and
without sdpa, with a limit of 100 s for each design. They are compared with the textbook LMI,
written in cvxpy and solved by clarabel, for H2 in both its forms. The data are not part of this
repository; the script takes their folder. "Found" is a norm within a thousandth of the least that
any method reached. takagi ran on two cores that ten other processes shared. There EB4, HE7 and JE2
(H-infinity), NN11 and plants of least norm zero were stopped by the time limit.

| plants | H-infinity | H2 |
|---|---|---|
| found by takagi and by cvxpy | 69 | 73 |
| found by takagi alone | 14 | 12 |
| found by cvxpy alone | 2 (EB4, HE7) | 0 |
| found by neither | 4 (JE2, NN3, NN11, ROC10) | 4 (IH, NN11, ROC4, ROC5) |
| the least norm is zero, so there is no thousandth of it; takagi answers | 9; 1 | 6; 6 |
| refused: no disturbance (NN10), a mode that no input moves (REA4) | 2 | 2 |
| refused: white noise reaches the output directly (AC4, HE6, HE7, JE3, NN13) | - | 5 |
| not run within the time (AC13, JE1) | 2 | 0 |

With one core of its own, takagi finds candidates for EB4 (0.500049, 5 s) and HE7 (2.42575, 2 s)
too.

With `--certify` the script also seeks a proof of the bound of every default design with at most 9
states. Both checkers prove all 66 H-infinity designs (to within 0.03 % of the design's own bound),
all 69 H2 designs (0.02 %), and 67 of 70 peak designs (0.02 %). The other three peak designs are
those of NN9, NN17 and ROC10, whose gains are 1e11 to 3e16. `peak_pdc` found no gains for NN3, ROC4
and ROC5; two more plants are refused.

The random plants have two or three rules, 2 to 4 states, one or two inputs, normally distributed
entries, and rules that differ by a quarter; half of them are in discrete time (seeds 0 to 39). All
33 H2 designs that were run are PROVED, within 0.005 %, and all 36 peak designs, within 0.02 %.

The problems of SDPLIB (Borchers 1999) are solved by `optimise`. For control1 to control4, hinf1 to
hinf4, hinf6 to hinf11 and hinf14 the answer is a candidate at the printed optimum. For hinf5 the
answer is "unknown", although the objective is the printed one, because the bound of its multipliers
is 0.3 % below it. hinf12, hinf13 and hinf15 also end "unknown": in units of their own solution the
objective of hinf13 is 44.36 with a bound of 44.24, that of hinf15 23.97 with 23.84, and that of
hinf12 decreases to 1e-7. control5 and control6 were stopped after 300 s; the optimum of the first
was bounded from below by 16.8828.
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
