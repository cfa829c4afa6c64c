"""docs/published.md, made of the problems."""

from __future__ import annotations

from catalogue.github import github
from catalogue.problems import PROBLEMS, Problem

HEAD = """# Published problems

For those who want to know whether takagi finds what the literature, other tools and closed forms
say. The named tests check the rows: where "here" is a number or a status, a test computes it again
and compares it with the printed digits. "Published" is as printed at the source, or exact where it
says so. This page is written by `make docs`.
"""


COLLECTIONS = """
## Whole collections

`python benchmarks/collections_of_plants.py` runs the plants of COMPleib 1.1 (Leibfritz 2004) with
at most 30 states, 102 of them: state feedback of least H-infinity and H2 norm, at default options
and without sdpa, with a limit of 100 s for each design, beside the textbook LMI in cvxpy with
clarabel. The data are not part of this repository; the script takes their folder. "Found" is a norm
within a thousandth of the least that any method reached.

| plants | H-infinity | H2 |
|---|---|---|
| found by takagi and by cvxpy | 69 | 73 |
| found by takagi alone | 14 | 12 |
| found by cvxpy alone | 2 (EB4, HE7: time limit) | 0 |
| found by neither | 4 (JE2, NN3, NN11, ROC10) | 4 (IH, NN11, ROC4, ROC5) |
| the least norm is zero, so there is no thousandth of it; takagi answers | 9; 1 | 6; 6 |
| refused | 2 | 7 |
| not run within the time (AC13, JE1) | 2 | 0 |

With `--certify` both checkers prove the bounds of all 66 H-infinity designs with at most 9 states
(to within 0.03 % of the design's own bound), of all 69 H2 designs (0.02 %), and of 67 of 70 peak
designs (0.02 %); the other three have gains of 1e11 to 3e16. On random plants of two or three rules
all 33 H2 and all 36 peak designs are PROVED.

The problems of SDPLIB (Borchers 1999) are solved by `optimise`: control1 to control6, hinf1 to
hinf4, hinf6 to hinf11 and hinf14 to the printed optimum, control6 in 47 s of processor time. hinf5,
hinf12, hinf13 and hinf15 end "unknown", with 362.36, 1e-7, 44.63 and 24.42; the bounds are 0.3,
0.9 and 2.4 % below for all but hinf12. No point reaches these optima: towards them the unknowns
grow without end, in double precision to 1e9. The bound counts what the multipliers leave of
stationarity, 1e-6 to 1e-5, for unknowns ten times as large as those found. Multipliers corrected on
their own faces halve the gap of hinf5 and leave the others, so it is not done.

`takagi verify` says more, in exact arithmetic ([table](verify.md#beside-vsdp)). Three optima that
SDPLIB prints are not those of the files: hinf12's lies between 0 and 6.5e-5 (0.2 is printed), and
points that satisfy every constraint have 45.15 in hinf13 (46 is printed) and 24.42 in hinf15 (25 is
printed). VSDP's bounds of hinf12 and hinf15 agree.
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
