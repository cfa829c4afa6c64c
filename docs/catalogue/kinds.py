"""The tables of docs/claims.md and docs/blends.md: each kind of claim in words, and its weights."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

from takagi.certificates.checker.replay.claim_kinds import TURBINE_KINDS
from takagi.reports.kinds_in_words import KINDS_IN_WORDS, OTHER_MODEL

DOCS = Path(__file__).parents[1]
COLUMNS = ("shared", "own", "products", "tables", "secants", "sampled")
# Kind of claim, with what is different in a variant -> what both checkers say of it.
CELLS = MappingProxyType(
    {kind: words.weights for kind, words in KINDS_IN_WORDS.items()}
    | {
        f"{kind}, {variant}": weights
        for kind, words in KINDS_IN_WORDS.items()
        for variant, weights in words.weights_of.items()
    }
)


def blends() -> str:
    """Return docs/blends.md with today's table; kinds of which the same is said share a row.

    Kinds about another model, a turbine's or a problem's, are left out.
    """
    rows: dict[tuple[str, ...], list[str]] = {}
    for kind, cells in CELLS.items():
        if cells == OTHER_MODEL:
            continue
        name, _, rest = kind.partition(", ")
        rows.setdefault(cells, []).append(f"`{name}`{' ' + rest if rest else ''}")
    lines = [f"| kinds | {' | '.join(COLUMNS[:-1])} |", "|---" * len(COLUMNS) + "|"]
    lines += [f"| {', '.join(kinds)} | {' | '.join(cells)} |" for cells, kinds in rows.items()]
    return _with_table("blends.md", "weights", lines)


def claims() -> str:
    """Return docs/claims.md with today's tables: claims about loops and plants, about turbines."""
    page = _with_table("claims.md", "kinds", _statements(turbine=False))
    return _with_table("claims.md", "turbine kinds", _statements(turbine=True), page)


def _statements(*, turbine: bool) -> list[str]:
    lines = ["| kind, request | what is proved | assumed |", "|---|---|---|"]
    for kind, words in KINDS_IN_WORDS.items():
        if words.proved and (kind in TURBINE_KINDS) is turbine:
            request = f", `{words.request}`" if words.request else ""
            proved, assumed = (x.replace("|", "\\|") for x in (words.proved, words.assumed))
            lines.append(f"| `{kind}`{request} | {proved} | {assumed}{' ' if assumed else ''}|")
    return lines


def _with_table(page: str, name: str, lines: list[str], text: str = "") -> str:
    """Return a page with these lines between its two comments of that name."""
    first, last = f"<!-- {name}: made by `make docs` -->\n", f"<!-- end {name} -->"
    before, _, rest = (text or (DOCS / page).read_text(encoding="utf-8")).partition(first)
    _, _, after = rest.partition(last)
    table = "\n".join(lines)
    return f"{before}{first}{table}\n{last}{after}"
