"""Write the pages that are made from the code, and their figures: python docs/make_pages.py

--check         write nothing; status 1 where a page is not what this would write
--tex FILE      write the formulas as a LaTeX document, to be looked at
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from catalogue import kinds, page, published, rooms, schemas, trusted
from catalogue.sheet import sheet

HERE = Path(__file__).parent
PAGES = {
    "conditions.md": page.page,
    "published.md": published.page,
    "blends.md": kinds.blends,
    "claims.md": kinds.claims,
    "figures/rooms.svg": rooms.picture,
    **schemas.SCHEMAS,
}
# Measured on certificates that take seconds to make: their own tests compare them.
MEASURED = {"certificate.md": trusted.page}


def main() -> int:
    """Write or compare; return the exit status."""
    parser = argparse.ArgumentParser(description="Write the pages made from the code.")
    parser.add_argument("--check", action="store_true", help="compare only")
    parser.add_argument("--tex", type=Path, help="write the formulas as a LaTeX document")
    arguments = parser.parse_args()
    if arguments.tex:
        arguments.tex.write_text(sheet(page.page()), encoding="utf-8")
        return 0
    stale = 0
    pages = PAGES if arguments.check else {**PAGES, **MEASURED}
    for name, made in pages.items():
        path, text = HERE / name, made()
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            continue
        if arguments.check:
            print(f"docs/{name} is not what it is made of; run: make docs", file=sys.stderr)
            stale = 1
        else:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
            print(f"docs/{name}: written")
    return stale


if __name__ == "__main__":
    sys.exit(main())
