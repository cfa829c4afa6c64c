"""How `takagi simulate` shows its numbers on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from takagi.reports.simulation.runs import Simulation

# Width of the output in a pipe or a file, where there is no terminal with a width.
_WIDTH = 100
# Short headings in two or three lines, so that the table fits into 80 characters; the files have
# the full titles, and more columns.
_HEADS = {
    "energy": "energy\n[kWh]",
    "mean_power": "power\n[kW]",
    "overspeed": "over-\nspeed\n[%]",
    "speed_deviation": "speed\ndev.\n[%]",
    "pitch_travel": "pitch\ntravel\n[deg]",
    "torque_rate": "torque\nrate\n[kN m/s]",
    "tower_del": "tower\nDEL\n[MN m]",
    "both_active": "both\nact\n[%]",
}


def print_simulation(found: Simulation, written: Sequence[str]) -> None:
    """Print one table of all winds, notes that explain it, and what was written."""
    from rich.console import Console

    from takagi.reports.simulation.tables import notes, table_rows

    terminal = sys.stdout.isatty()
    console = Console(file=sys.stdout, width=None if terminal else _WIDTH, highlight=False)
    console.print(
        f"{found.turbine.name}, wind {', '.join(found.asked)}, {found.parts.wake} wake"
        f"{_without(found)}{_sampling(found)}"
    )
    console.print()
    console.print(_table(table_rows(found), wide=console.width >= _WIDTH))
    console.print()
    for note in notes(found):
        width = max(40, min(console.width, 100))
        console.print(fill(note, width, subsequent_indent="  "), markup=False, soft_wrap=True)
    if written:
        folder = Path(written[0]).parent
        figures = sum(name.endswith(".svg") for name in written)
        series = sum(Path(name).parent.name == "series" for name in written)
        console.print(
            f"\n{folder}\n  summary.md, simulation.csv, simulation.json\n"
            f"  figures/ ({figures}, as SVG and PNG)\n  series/ ({series})",
            markup=False,
            soft_wrap=True,
        )


def _without(found: Simulation) -> str:
    """Return words on the plant's options that are not at their default."""
    asked, words = found.parts, ""
    if asked.without:
        words += f", without {' and '.join(asked.without)}"
    if asked.speed_filter is not None:
        through = f"through {asked.speed_filter:g} rad/s" if asked.speed_filter else "unfiltered"
        words += f", speed {through}"
    return words + (f", ripple {asked.ripple:g}" if asked.ripple else "")


def _sampling(found: Simulation) -> str:
    """Return words on the laws' sampling where it differs from the default, 20 ms."""
    sample, late = 1e3 * found.sample_time, 1e3 * found.computation_time
    if sample == 20 and not late:
        return ""
    return f", laws every {sample:g} ms" + (f", {late:g} ms late" if late else "")


def _table(rows: Sequence[dict[str, object]], *, wide: bool) -> Table:
    from rich import box
    from rich.table import Table

    from takagi.cli.options.turbine_options import typed_name
    from takagi.reports.simulation.tables import rounded_text, short_names

    gap = (0, 2, 0, 0) if wide else (0, 1, 0, 0)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=gap)
    table.add_column("wind\n  law", no_wrap=True, vertical="bottom")
    for name in _HEADS:
        table.add_column(_HEADS[name].replace("[", r"\["), justify="right", vertical="bottom")
    wind, short = None, short_names([str(row["wind"]) for row in rows])
    for row in rows:
        if row["wind"] != wind:
            wind = row["wind"]
            # A seed is told where it tells two winds apart.
            table.add_row(f"[bold]{short[str(wind)]}[/bold]")
        table.add_row(
            f"  {typed_name(str(row['law']))}", *(rounded_text(row, name) for name in _HEADS)
        )
    return table
