"""Which tests run in one process: those of a file, and all files that need the same dear thing.

What is made once for several files (a design of the turbine, models of the paper's law) cannot be
sent from one process to another.  It is made once only where one process runs all that ask for it.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
# What is shared -> how a file of tests asks for it: by a fixture's name, or by an import.
SHARED = {
    "the turbine's design": re.compile(r"\b(turbine_design|finished|asked): (?!str)"),
    "models of the paper's law": re.compile(
        r"import regional_models|from tests\.certificates\.test_paper_certificate import"
    ),
    "the arm with a reference": re.compile(r"kinds\.tracking_documents import"),
    "syntax of the sources": re.compile(r"from tests\.(syntax|certificates\.imported) import"),
    "designs of plants": re.compile(r"from tests\.reports\.plant_designs import"),
}


# The groups whose tests take longest, in seconds of one core with TAKAGI_REDUCED=1.  They begin
# first: one that began last would keep one process busy while the others have nothing left to do.
SECONDS: dict[str, float] = {
    "the turbine's design": 300,
    "tests/certificates/test_coherent_synthesis.py": 175,
    "tests/gallery/test_gallery.py": 55,
    "tests/certificates/campaigns/test_soundness.py": 40,
    "tests/certificates/campaigns/test_mutations.py": 31,
}


@cache
def group(path: str) -> str:
    """Return the name of what a file's tests run with.

    A file that is not recognised runs alone, which costs time and nothing else.
    """
    text = (ROOT / path).read_text(encoding="utf-8")
    return next((name for name, asks in SHARED.items() if asks.search(text)), path)


def in_order(nodeids: Sequence[str]) -> list[int]:
    """Return the places of tests in the order in which they shall be handed out.

    Groups of known length come first, the longest before the others; then those of many tests.
    """
    groups = [group(nodeid.split("::", 1)[0]) for nodeid in nodeids]
    tests = Counter(groups)
    first = {name: place for place, name in reversed([*enumerate(groups)])}

    def rank(place: int) -> tuple[float, int, int, int]:
        name = groups[place]
        return -SECONDS.get(name, 0.0), -tests[name], first[name], place

    return sorted(range(len(nodeids)), key=rank)
