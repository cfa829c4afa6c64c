"""Static output feedback of COMPleib's plants beside HIFOO: norms, proofs, as a table.

    python benchmarks/static_output_feedback.py              all plants; writes the page's table
    python benchmarks/static_output_feedback.py AC3 MFP      these alone, printed

Every plant of tests/lmi/fixed_order/compleib.json gets ``hinf_fixed_order`` of order 0 at default
options.  Its loop is certified, and both checkers decide.  HIFOO's norm is the smaller one of its
published and its run, see tests/lmi/fixed_order/plants.py.  The table is put between the two marks
of docs/output-feedback.md: some ten minutes.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "output-feedback.md"
BEGIN, END = "<!-- begin table -->\n", "<!-- end table -->\n"
HEAD = "| plant | HIFOO published | HIFOO run | takagi, proved | ratio |\n|---|---|---|---|---|\n"


def main() -> None:
    """Print a row for each plant; write the page where all were asked for."""
    sys.path.insert(0, str(ROOT))
    from tests.lmi.fixed_order.plants import names

    asked = sys.argv[1:]
    rows = []
    print(HEAD, end="")
    for name in asked or names():
        rows.append(row(name))
        print(rows[-1], end="", flush=True)
    if not asked:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(BEGIN)
        PAGE.write_text(
            before + BEGIN + HEAD + "".join(rows) + END + rest.split(END)[1], encoding="utf-8"
        )


def row(name: str) -> str:
    """Return the table's row of one plant."""
    from takagi.certificates import certify
    from takagi.certificates.cross_check.comparison import cross_checked_document
    from takagi.certificates.requests import L2Gain
    from takagi.lmi import hinf_fixed_order
    from tests.lmi.fixed_order.plants import PRINTED, best_of_hifoo, hifoo, plant

    system = plant(name)
    design = hinf_fixed_order(system)
    published, run = hifoo(name)
    shown = [f"{value:.5g}" if value is not None else "-" for value in (published, run)]
    if not design.found:
        return f"| {name} | {shown[0]} | {shown[1]} | none | - |\n"
    answer = certify(design.model, design.gains, claims=[L2Gain(output=design.output)])
    gain = answer.document["claims"][0]["gain"]
    said = {row.second for row in cross_checked_document(answer.document).rows}
    mark = "" if said == {"PROVED"} else " (not proved)"
    mark += "" if design.exact else " *"
    best = best_of_hifoo(name)
    ratio = f"{gain / best:.3f}" if best > PRINTED else "both 0"
    return f"| {name} | {shown[0]} | {shown[1]} | {gain:.5g}{mark} | {ratio} |\n"


if __name__ == "__main__":
    main()
