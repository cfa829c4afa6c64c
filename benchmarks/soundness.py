"""Counts false verdicts on problems whose truth is decided by other means, exactly.

    python benchmarks/soundness.py [--count N] [--seed N] [--processes N]

Loops (``known_loops``, ``known_blends``) are put to ``certify``, which has to find its own
evidence.  Claims with closed forms (``known_claims``, ``known_sets``, ``known_blends``) are thrown
straight at the checker, with the best evidence and with wrong ones.  Most lie on their threshold or
a hair beside it.  ``known_answers`` asks the public functions.  UNDECIDED is never false; how often
it is said, of what is true with evidence that fits, is part of the table.

The sums go to docs/benchmarks.md.  The exit status is 1 when a verdict is false.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402  the threads are counted when numpy is loaded
from known_answers import ANSWERS, Answered  # noqa: E402
from known_blends import PIECES, RULES  # noqa: E402
from known_claims import CLAIMS  # noqa: E402
from known_loops import LOOPS as PLAIN_LOOPS  # noqa: E402
from known_loops import Problem, Random  # noqa: E402
from known_sets import SETS  # noqa: E402
from measure import PAGE, placed, summary, table  # noqa: E402
from modes import Known, TooLong, as_read  # noqa: E402

from takagi.certificates import CertificateError, Verdict, certify  # noqa: E402
from takagi.certificates.checker.replay.claim_kinds import replay  # noqa: E402
from takagi.certificates.checker.replay.loop_reading import read_model_loop  # noqa: E402
from takagi.models import TSModel  # noqa: E402

Counts = Counter[str]
DIRECT = CLAIMS | SETS | PIECES
LOOPS = PLAIN_LOOPS | RULES
FALSE = ("false proved", "false disproved")


def main() -> int:
    """Run the campaign, print the tables, and write them into the page."""
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("--count", type=int, default=24_000, help="verdicts in all")
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    reader.add_argument("--print-only", action="store_true", help="leave the page as it is")
    asked = reader.parse_args()
    # A loop takes twenty times as long as a claim that is only checked.
    shares = {name: asked.count // 3 // len(LOOPS) + 1 for name in LOOPS}
    shares |= {name: 2 * asked.count // 3 // len(DIRECT) + 1 for name in DIRECT}
    shares |= {name: asked.count // 20 // len(ANSWERS) + 1 for name in ANSWERS}
    with ProcessPoolExecutor(asked.processes) as pool:
        runs = {name: pool.submit(counted, name, n, asked.seed) for name, n in shares.items()}
        seen = {name: run.result() for name, run in runs.items()}
    tables = {
        "soundness": searched_table({name: seen[name] for name in (*LOOPS, *ANSWERS)}),
        "soundness of claims": thrown_table({name: seen[name] for name in DIRECT}),
    }
    page = PAGE.read_text(encoding="utf-8")
    for name, text in tables.items():
        print(f"{text}\n")
        page = page if asked.print_only else placed(page, name, summary(text))
    if not asked.print_only:
        PAGE.write_text(page, encoding="utf-8")
    wrong = sum(counts[key] for counts in seen.values() for key in FALSE)
    print(f"{sum(counts['number'] for counts in seen.values())} verdicts, {wrong} false")
    return int(wrong > 0)


def counted(name: str, count: int, seed: int) -> Counts:
    """Return the counts of a family, drawn from the seed and the family's name."""
    rng = np.random.default_rng([seed, *name.encode()])
    if name in LOOPS:
        counts = family_of_loops(LOOPS[name], rng, count)
    elif name in ANSWERS:
        counts = family_of_answers(ANSWERS[name], rng, count)
    else:
        counts = family_of_claims(DIRECT[name], rng, count)
    print(f"{name}: {dict(counts)}", flush=True)
    return counts


def family_of_loops(family: Callable[[Random], Problem], rng: Random, count: int) -> Counts:
    """Return the counts of one family that is put to ``certify``."""
    seen: Counts = Counter()
    for _ in range(count):
        problem = family(rng)
        model = TSModel(problem.A, problem.B, sample_time=problem.step)
        verdict = certify(model, problem.K, decay_rate=problem.rate).verdict
        _count(seen, verdict, problem.truth)
    return seen


def family_of_claims(family: Callable[[Random], list[Known]], rng: Random, count: int) -> Counts:
    """Return the counts of one family that is thrown at the checker."""
    seen: Counts = Counter()
    while seen["number"] < count:
        for known in family(rng):
            verdict = said_of(known)
            if verdict is None:
                continue
            _count(seen, verdict, known.truth)
            seen["fitting"] += known.truth and known.fits
            seen["fitting proved"] += known.truth and known.fits and verdict is Verdict.PROVED
    return seen


def family_of_answers(family: Callable[[Random], Answered], rng: Random, count: int) -> Counts:
    """Return the counts of one family of questions to public functions."""
    seen: Counts = Counter()
    while seen["number"] < count:
        for verdict, truth in family(rng):
            _count(seen, verdict, truth)
    return seen


def said_of(known: Known) -> Verdict | None:
    """Return the checker's verdict; UNDECIDED where it refuses, which is not false either.

    None where the numbers have more digits than a certificate may.
    """
    try:
        model, gains, claim = as_read(known.model), as_read(known.gains), as_read(known.claim)
    except TooLong:
        return None
    family = read_model_loop(model, gains)
    try:
        return replay(claim, None, family, [], "claim").verdict
    except CertificateError:
        return Verdict.UNDECIDED


def _count(seen: Counts, verdict: Verdict, truth: bool) -> None:
    seen["number"] += 1
    seen["true"] += truth
    seen[verdict.name] += 1
    seen["false proved"] += verdict is Verdict.PROVED and not truth
    seen["false disproved"] += verdict is Verdict.DISPROVED and truth


def searched_table(seen: dict[str, Counts]) -> str:
    keys = ("number", "true", "PROVED", "DISPROVED", "UNDECIDED")
    heads = ("problems", "number", "true", "proved", "disproved", "undecided")
    return _table(seen, heads, keys)


def thrown_table(seen: dict[str, Counts]) -> str:
    keys = ("number", "true", "fitting", "fitting proved", "PROVED", "DISPROVED")
    heads = ("claims", "number", "true", "with evidence that fits", "of these proved")
    return _table(seen, (*heads, "proved in all", "disproved"), keys)


def _table(seen: dict[str, Counts], heads: tuple[str, ...], keys: tuple[str, ...]) -> str:
    columns = (*keys, *FALSE)
    rows = [(name, *(str(counts[key]) for key in columns)) for name, counts in seen.items()]
    total = [str(sum(counts[key] for counts in seen.values())) for key in columns]
    return table((*heads, *FALSE), [*rows, ("all", *total)])


if __name__ == "__main__":
    raise SystemExit(main())
