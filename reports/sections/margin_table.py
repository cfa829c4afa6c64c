"""The table of margins of linear loops."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from takagi.reports.margins import Margins
from takagi.reports.page.text import Table, significant, with_decimals

BESIDE = (("disk: gain", "± dB"), ("disk: phase", "± °"), ("peak |S|", "-"))


def margin_table(
    caption: str,
    heads: tuple[tuple[str, str], ...],
    rows: Iterable[tuple[tuple[str, ...], Margins]],
    *,
    down: bool = False,
    folded_from: int | None = None,
) -> Table:
    """Return a table with one row for each loop.

    Parameters
    ----------
    heads : (heading, unit) of the columns that identify the loop.
    rows : (cells of these columns, margins) of each loop.
    down : also show the factor below 1 at which the loop becomes unstable.
    folded_from : a table with more rows is folded; None for never.
    """
    gain = (("gain up", "dB"), ("gain down", "dB")) if down else (("gain", "dB"),)
    factors = "factors up and down" if down else "upward factor"
    columns = (("crossover", "rad/s"), *gain, ("phase", "°"), ("delay", "s"), *BESIDE)
    found = tuple((*head, *_cells(m, down, len(columns))) for head, m in rows)
    many = folded_from is not None and len(found) > folded_from
    return Table(
        caption,
        (*heads, *columns),
        found,
        folded=f"All {len(found)} loops as a table" if many else "",
        note=f"Gain: {factors} to instability. Disk: gain and phase may change together by this "
        "much. Delay and phase are ∞ where the loop gain never reaches 1.",
    )


def _cells(m: Margins, down: bool, count: int) -> tuple[str, ...]:
    if not m.stable:
        return ("unstable",) * count
    least = 20 * np.log10(m.gain_decrease) if m.gain_decrease > 0 else -np.inf
    return (
        significant(m.crossover),
        with_decimals(20 * np.log10(m.gain_increase), 1),
        *([with_decimals(least, 1)] if down else []),
        with_decimals(float(np.degrees(m.phase)), 0),
        significant(m.delay),
        with_decimals(20 * np.log10(m.disk.gain_increase), 1),
        with_decimals(float(np.degrees(m.disk.phase)), 0),
        with_decimals(m.sensitivity_peak, 2),
    )
