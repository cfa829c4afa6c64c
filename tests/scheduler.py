"""Which tests run in one process: those of a file, and all files that need the same dear thing.

What is made once for several files (a design of the turbine, models of the paper's law) cannot be
sent from one process to another.  It is made once only where one process runs all that ask for it.
"""

from __future__ import annotations

import re
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


@cache
def group(path: str) -> str:
    """Return the name of what a file's tests run with.

    A file that is not recognised runs alone, which costs time and nothing else.
    """
    text = (ROOT / path).read_text(encoding="utf-8")
    return next((name for name, asks in SHARED.items() if asks.search(text)), path)
