"""Changes certificates in one place and counts what the checker lets pass.

    python benchmarks/mutations.py [--count N] [--seed N] [--processes N] [--without-turbine]

Every mutant is read twice: with the hashes of the original, where all have to be refused, and with
hashes made anew, as a forger would.  Of the latter some are PROVED, because what they say is still
true: a wider limit, a slower rate, another digit far behind the point.  Each of those is judged by
``judge``, which looks for an exact counterexample, or by ``turbine_judge``, which looks for one in
floats; words that no claim is made of are counted apart.  A mutant that is DISPROVED has to exclude
what it says by ``exact_truth``.

The sums go to docs/benchmarks.md.  The exit status is 1 when a mutant passes with the old
hashes, or when one is PROVED or DISPROVED falsely.
"""

from __future__ import annotations

import argparse
import os
import random
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from itertools import chain
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import turbine_judge  # noqa: E402
from damage import Data, Place, as_written, mutant, resealed, text_of  # noqa: E402
from exact_truth import cayley, pair_has_function, plus  # noqa: E402
from judge import why_false  # noqa: E402
from measure import PAGE, placed, summary, table  # noqa: E402
from mutated import exclusions, general_models, plants, problems, turbine  # noqa: E402

from takagi.certificates import CertificateError, Verdict, check  # noqa: E402

Counts = Counter[str]
KEYS = ("mutants", "passed", "refused", "undecided", "words", "weaker", "true", "unjudged", "false")
HEADS: tuple[str, ...] = (
    *("certificate", "mutants", "read with the old hashes", "refused", "undecided"),
    *("PROVED: words", "turbine: weaker", "still true", "not judged", "false"),
)
# What stands in a certificate and is not part of any claim.
WORDS = {"name", "source", "unit", "output_names", "units", "formula", "model_file", "provenance"}
NAMES = {"state_names", "input_names", "disturbance_names"}
# Where a turbine's mutant may claim less; counted so only if the judge finds it true.
WEAKER = {"wind_error", "wind_rate", "decay_rate", "integral_limit", "pitch_rate_limit", "peaks"}
WEAKER |= {"frozen_wake", "effectiveness_limit", "rated_rotor_speed", "inertia", "multiplier"}
WEAKER |= {"power_coefficient", "ranges", "torque_rate_limit", "torque_step"}
WEAKER |= {"pitch_rate", "signal_rate", "torque_rate", "schedule_bend"}


def main() -> int:
    """Run the campaign, print the table, and write it into the page."""
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("--count", type=int, default=6_000, help="mutants in all")
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    reader.add_argument("--print-only", action="store_true", help="leave the page as it is")
    reader.add_argument("--without-turbine", action="store_true", help="which takes a second each")
    reader.add_argument("--only", help="one certificate by name; leaves the page as it is")
    asked = reader.parse_args()
    sources: list[Iterator[tuple[str, Data]]] = [
        general_models(),
        exclusions(),
        problems(),
        plants(),
    ]
    if not asked.without_turbine:
        sources.append(turbine())
    documents = [each for each in chain(*sources) if asked.only in (None, each[0])]
    if not documents:
        reader.error(f"no certificate is named {asked.only!r}")
    share = -(-asked.count // len(documents))
    with ProcessPoolExecutor(asked.processes) as pool:
        runs = {
            name: pool.submit(
                campaign,
                name,
                as_written(document),
                random.Random(f"{asked.seed} {name}"),
                min(share, 150) if name == "nrel5mw" else share,
            )
            for name, document in documents
        }
        found = {name: run.result() for name, run in runs.items()}
    seen = {name: counts for name, (counts, _) in found.items()}
    wrong = [line for _, lines in found.values() for line in lines]
    rows = [(name, *(str(counts[key]) for key in KEYS)) for name, counts in seen.items()]
    totals = [sum(counts[key] for counts in seen.values()) for key in KEYS]
    text = table(HEADS, [*rows, ("all", *map(str, totals))])
    print("\n".join([text, *wrong]))
    if not (asked.print_only or asked.only):
        page = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(placed(page, "mutations", summary(text)), "utf-8")
    return int(bool(wrong))


def campaign(name: str, document: Data, rng: random.Random, count: int) -> tuple[Counts, list[str]]:
    """Return the counts of one certificate, and the mutants that should not have passed."""
    seen: Counts = Counter()
    wrong: list[str] = []
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        while seen["mutants"] < count:
            found = mutant(document, rng)
            if found is None:
                continue
            place, what, changed = found
            # Words are many, and nothing is claimed of them: one in five is enough.
            if WORDS & set(map(str, place)) and rng.random() < 0.8:
                continue
            seen["mutants"] += 1
            if said_of(changed, path) is not None:
                seen["passed"] += 1
                wrong.append(f"{name}: {place}, {what}: passes with the old hashes")
            outcome, why = judged(document, changed, place, path, rng)
            seen[outcome] += 1
            if outcome == "false":
                wrong.append(f"{name}: {place}, {what}: {why}")
            elif outcome == "unjudged":
                print(f"{name}: {place}, {what}: {why}", flush=True)
    print(f"{name}: {dict(seen)}, {time.perf_counter() - start:.0f} s", flush=True)
    return seen, wrong


def said_of(document: Data, path: Path) -> Verdict | None:
    """Return the verdict of a certificate as it is written; None where it is refused."""
    path.write_text(text_of(document), encoding="utf-8")
    try:
        return check(path).verdict
    except CertificateError:
        return None


def judged(
    original: Data, changed: Data, place: Place, path: Path, rng: random.Random
) -> tuple[str, str]:
    """Return what becomes of a mutant with its own hashes, and why it is false if it is."""
    verdict = said_of(resealed(changed), path)
    if verdict is None:
        return "refused", ""
    if verdict is Verdict.UNDECIDED:
        return "undecided", ""
    # Names of a law have to be its model's; without a law they are words.
    words = WORDS if changed.get("gains") else WORDS | NAMES
    if place[0] == "claims" and "state" in place:
        words = words | {place[-1]}
    if place[-1] in words or (len(place) > 1 and place[1] in words):
        return "words", ""
    if verdict is Verdict.DISPROVED:
        return ("false", "a function exists") if _pair_has_function(changed) else ("true", "")
    still = "true"
    try:
        if changed["model"]["kind"] == "turbine":
            shown = [claim.text for claim in check(path).claims]
            why = turbine_judge.why_false(changed, rng, shown)
            still = "weaker" if WEAKER & set(map(str, place)) else "true"
        else:
            why = why_false(changed, rng)
    except (ArithmeticError, KeyError, TypeError, ValueError, AttributeError) as error:
        return "unjudged", f"{type(error).__name__}: {error}"
    return ("false", why) if why else (still, "")


def _pair_has_function(document: Data) -> bool:
    """Return whether two matrices of order 2 share a function at the rate that is excluded."""
    model, claim = document["model"], document["claims"][0]
    rate, step = Fraction(claim["decay_rate"]), model["sample_time"]
    pair = [[[Fraction(entry) for entry in row] for row in vertex] for vertex in model["A"]]
    if len(pair) != 2 or (step is not None and rate):
        raise ValueError(f"no theorem is at hand for {len(pair)} vertices, rate {rate}")
    if step is not None:
        return pair_has_function(*map(cayley, pair))
    return pair_has_function(*(plus(A, rate) for A in pair))


if __name__ == "__main__":
    raise SystemExit(main())
