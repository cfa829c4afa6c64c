"""The table of docs/blends.md: each kind of claim for each kind of weights, theorem or refusal."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

PAGE = Path(__file__).parents[1] / "blends.md"
COLUMNS = ("shared", "own", "products", "tables", "secants", "sampled")

PROVED, REFUSED = "theorem", "refused"
THEOREM = (PROVED,) * 5
PLANT = "refused: no plant"
OTHER = ("refused: another model",) * 5
# Kind of claim -> what both checkers say of it for the first five kinds of weights.
CELLS = MappingProxyType(
    {
        "decay": THEOREM,
        "transient": THEOREM,
        "region": THEOREM,
        "gain-rounding": THEOREM,
        "no-common-decay": ("disproof", "open (9)", "disproof", "disproof", "open (9)"),
        "invariant-ellipsoid": THEOREM,
        "input-limits": THEOREM,
        "input-limits, rates": (PROVED, "refused (1)", PROVED, PROVED, "refused (1)"),
        "l2-gain": THEOREM,
        "l2-gain, output by rule": (PROVED, PROVED, PROVED, PROVED, "refused (2)"),
        "fuzzy-l2-gain": (PROVED, "refused (4)", PROVED, PROVED, "refused (5)"),
        "h2-norm": ("theorem (10)", "theorem (3, 10)", *("theorem (10)",) * 3),
        "peak": THEOREM,
        "exit-probability": ("theorem (10)", "theorem (3, 10)", *("theorem (10)",) * 3),
        "sampled-loop": THEOREM,
        "fuzzy-decay": (PROVED, "refused (4)", PROVED, PROVED, "refused (5)"),
        "observer": ("theorem (6)", "theorem (6)", PROVED, PROVED, "refused (7)"),
        "observed-feedback": ("theorem (6)", "refused (4)", PROVED, PROVED, "refused (7)"),
        "observed-loop": ("theorem (6)", "refused (4)", PROVED, PROVED, "refused (7)"),
        "observed-loop, by estimate": (
            *("refused (11)",) * 2,
            PROVED,
            "refused (12)",
            "refused (7)",
        ),
        "slope-embedding": (PLANT, PLANT, PROVED, "refused (12)", PROVED),
        "sector-embedding": (PLANT, PLANT, PROVED, PROVED, "refused: its form"),
        "secant-embedding": (PLANT, PLANT, "refused: its form", "refused: its form", PROVED),
        "tracking": (PLANT, PLANT, "refused: its form", "refused: its form", "refused (13)"),
        "effort-blend": (PLANT, PLANT, "theorem (8)", "theorem (8)", "refused (8)"),
        "bumpless": (PLANT, PLANT, "theorem (8)", "theorem (8)", "refused (8)"),
        "coherent-loop": OTHER,
        "paper-loop": OTHER,
        "wind-rate": OTHER,
        "set-points": OTHER,
        "running-loop": OTHER,
    }
)

FIRST, LAST = "<!-- weights: made by `make docs` -->\n", "<!-- end weights -->"


def page() -> str:
    """Return docs/blends.md with today's table."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(FIRST)
    _, _, after = rest.partition(LAST)
    return f"{before}{FIRST}{_table()}{LAST}{after}"


def _table() -> str:
    """Return the table; kinds of which the same is said share a row."""
    rows: dict[tuple[str, ...], list[str]] = {}
    for kind, cells in CELLS.items():
        name, _, rest = kind.partition(", ")
        rows.setdefault(cells, []).append(f"`{name}`{' ' + rest if rest else ''}")
    lines = [f"| kinds | {' | '.join(COLUMNS[:-1])} |", "|---" * len(COLUMNS) + "|"]
    lines += [f"| {', '.join(kinds)} | {' | '.join(cells)} |" for cells, kinds in rows.items()]
    return "\n".join(lines) + "\n"
