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


def page() -> str:
    """Return docs/published.md."""
    lines = [HEAD, "| problem | asks for | published | here | held by | source, notes |"]
    lines.append("|---|---|---|---|---|---|")
    lines += [_row(problem) for problem in PROBLEMS]
    return github("\n".join([lines[0], "\n".join(lines[1:])]))


def _row(problem: Problem) -> str:
    tests = ", ".join(f"`{name}`" for name in problem.tests) or "-"
    notes = "; ".join(text for text in (problem.source, problem.note) if text)
    cells = (problem.name, problem.asks, problem.published, problem.found or "-", tests, notes)
    return f"| {' | '.join(cells)} |"
