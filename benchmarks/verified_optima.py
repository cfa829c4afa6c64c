"""Compares what `takagi verify` proves of SDPLIB's problems with the bounds that VSDP published.

    python benchmarks/verified_optima.py --sdplib FOLDER --vsdp FILE.csv ... [--limit 300]

FOLDER has the .dat-s files of SDPLIB, and FILE.csv are the tables of VSDP's results, with name, fL,
fU and fU-fL (github.com/vsdp/vsdp-2020, doc/res/2018_12/SDPLIB_SYS1.csv and SDPLIB_SYS2.csv).
Neither is part of this repository.  VSDP's problem is to minimise the opposite of SDPLIB's dual
objective: its upper bound of SDPLIB's optimum is -fL, its lower bound -fU.  Of the solvers that its
bounds rest on, the best one counts for each problem.

The table goes to docs/verify.md.  A problem that takes more than ``limit`` seconds of the processor
has no row of ours.
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterable
from fractions import Fraction
from math import inf
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from measure import placed, table  # noqa: E402  the threads first

from takagi.certificates.checker.words.rounded import at_least, at_most  # noqa: E402
from takagi.certificates.claims.problem_verification import verify  # noqa: E402
from takagi.lmi.problem_files.reading import read_problem_file  # noqa: E402

PAGE = Path(__file__).resolve().parents[1] / "docs" / "verify.md"
DIGITS = 10
HEADS = ("problem", "takagi proves", "width", "VSDP proves", "width", "time")
FAMILIES = ("truss", "control", "hinf", "theta", "qap", "inf")


class Bounds(NamedTuple):
    """Both bounds of an optimum, as printed, and the distance of the two."""

    lower: str
    upper: str
    width: float


def main() -> int:
    """Print the table, and write it into the page."""
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("names", nargs="*", help="problems; all of the folder unless given")
    reader.add_argument("--sdplib", type=Path, required=True)
    reader.add_argument("--vsdp", type=Path, nargs="+", required=True)
    reader.add_argument("--limit", type=int, default=300, help="seconds for each problem")
    reader.add_argument("--print-only", action="store_true", help="leave the page as it is")
    asked = reader.parse_args()
    published = vsdp_bounds(asked.vsdp)
    files = {path.name.removesuffix(".dat-s"): path for path in asked.sdplib.glob("*.dat-s")}
    names = asked.names or [n for n in files if n.startswith(FAMILIES) and n in published]
    rows = []
    for name in sorted(names, key=_in_order):
        theirs = _in_words(published[name])
        if name.startswith("inf"):
            # Their bounds are of no use there; that all four are infeasible stands in their text.
            theirs = ("infeasible", "-")
        row = (name, *_ours(files[name], asked.limit), *theirs)
        # The time stands last.
        rows.append((*row[:3], *row[4:], row[3]))
        print(f"| {' | '.join(rows[-1])} |", flush=True)
    if not asked.print_only:
        content = table(HEADS, rows)
        page = placed(PAGE.read_text(encoding="utf-8"), "verified optima", content)
        PAGE.write_text(page, encoding="utf-8")
    return 0


def vsdp_bounds(paths: Iterable[Path]) -> dict[str, Bounds]:
    """Return SDPLIB's bounds by problem, each by the solver that gave the best one."""
    best: dict[str, Bounds] = {}
    for path in paths:
        with path.open(encoding="utf-8", newline="") as file:
            for line in csv.DictReader(file):
                before = best.get(line["name"], Bounds("-inf", "inf", inf))
                lower, upper = (_opposite(line[key]) for key in ("fU", "fL"))
                width = float(line["fU-fL"])
                best[line["name"]] = Bounds(
                    max(before.lower, lower, key=float),
                    min(before.upper, upper, key=float),
                    min(before.width, width) if width == width else before.width,
                )
    return best


def _opposite(text: str) -> str:
    return text.removeprefix("-").lower() if text.startswith("-") else f"-{text.lower()}"


def _in_words(bounds: Bounds) -> tuple[str, str]:
    width = f"{bounds.width:.1e}" if bounds.width < inf else "-"
    if bounds.upper == "inf" or bounds.lower == "-inf":
        sides = [f"at most {bounds.upper}"] * (bounds.upper != "inf")
        sides += [f"at least {bounds.lower}"] * (bounds.lower != "-inf")
        return ", ".join(sides) or "no bound", "-"
    return f"{bounds.lower} to {bounds.upper}", width


def _ours(path: Path, limit: int) -> tuple[str, str, str]:
    """Return what is proved, the width and the seconds."""
    answer: tuple[str, str, str] | None = _within(
        limit, lambda: (*_proved(path), f"{time.process_time():.0f} s")
    )
    return answer or ("not finished", "-", f"> {limit} s")


def _proved(path: Path) -> tuple[str, str]:
    verification = verify(read_problem_file(path))
    claims = dict(zip((claim["kind"] for claim in verification.document["claims"]),
                      verification.checked.claims, strict=True))  # fmt: skip
    if "no-solution" in claims:
        return "no solution", "-"
    if "unbounded" in claims:
        return "no bound of the objective", "-"
    if not verification.checked.claims[0].verdict.name == "PROVED":
        return "nothing", "-"
    values = [claim.figures[0].value for claim in claims.values()]
    upper = Fraction(values[0] or 0)
    text = f"at most {at_most(upper, DIGITS)}"
    if len(values) == 1:
        return text, "-"
    lower = Fraction(values[1] or 0)
    if verification.settled:
        between = f"{at_least(lower, DIGITS)} to {at_most(upper, DIGITS)}"
        return between, f"{float(upper - lower):.1e}"
    size = claims["optimum-bound"].figures[1].value
    return f"{text}; at least {at_least(lower, DIGITS)} for \\|x\\| ≤ {float(size or 0):.1e}", "-"


def _within(seconds: int, work: Callable[[], Any]) -> Any:
    """Return the answer of a process of its own; None where it takes longer, or crashes."""
    context = get_context("fork")
    here, there = context.Pipe(duplex=False)

    def run() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        signal.signal(signal.SIGXCPU, lambda *_: os._exit(1))
        there.send(work())

    process = context.Process(target=run)
    process.start()
    there.close()
    try:
        return here.recv()
    except EOFError:
        return None
    finally:
        process.join()


def _in_order(name: str) -> tuple[int, int]:
    family = next(k for k, head in enumerate((*FAMILIES, "")) if name.startswith(head))
    return family, int("".join(filter(str.isdigit, name)) or 0)


if __name__ == "__main__":
    sys.exit(main())
