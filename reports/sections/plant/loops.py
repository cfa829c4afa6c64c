"""Linear checks of a plant's loop: poles, Bode plots and margins at rest and at the vertices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.figures.plant.captioned import bode_plates, poles_plate
from takagi.reports.figures.plant.poles import rest_poles
from takagi.reports.loops.plant_local import LISTED, LocalLoop
from takagi.reports.page.text import Section, Table, fixed, significant

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop

__all__ = ["MARGINS", "loops_section", "margin_rows", "poles_section"]

FOLDED = 8
MARGINS = (
    ("place", ""),
    ("loop", ""),
    ("crossover", "rad/s"),
    ("gain up", "dB"),
    ("gain down", "dB"),
    ("phase", "°"),
    ("delay", "s"),
    ("disk: gain", "± dB"),
    ("disk: phase", "± °"),
    ("peak |S|", "-"),
)


def poles_section(loop: PlantLoop) -> Section:
    """Return the section with the poles of vertices and of the plant at rest."""
    alone, closed = rest_poles(loop)
    return Section(
        "poles",
        "Poles",
        {
            "figure": poles_plate(loop),
            "alone": ", ".join(_complex(p) for p in _sorted(alone)),
            "closed": ", ".join(_complex(p) for p in _sorted(closed)),
            "discrete": loop.discrete,
        },
    )


def loops_section(loop: PlantLoop, loops: Sequence[LocalLoop]) -> Section:
    """Return the section with Bode plots and margins; only for a plant with a law."""
    rows = margin_rows(loops)
    return Section(
        "loops",
        "Bode plots and margins",
        {
            "figures": list(bode_plates(loops)),
            "table": Table(
                "Margins of the linear loops",
                MARGINS,
                rows,
                folded=f"All {len(rows)} loops as a table" if len(rows) > FOLDED else "",
                note="Gain: factors up and down to instability. Disk: gain and phase may change "
                "together by this much. Delay and phase are ∞ where the loop gain never reaches 1.",
            ),
            "unstable": [
                f"{one.place}, {one.input.split(' [')[0]}"
                for one in loops
                if not one.margins.stable
            ],
            "left_out": 0 if len(loop.model.rules) <= LISTED else len(loop.model.rules),
            "discrete": loop.discrete,
            "inputs": len(loop.model.inputs),
        },
    )


def margin_rows(loops: Sequence[LocalLoop]) -> tuple[tuple[str, ...], ...]:
    """Return one row of text per loop, in the columns of ``MARGINS``."""
    return tuple(_row(one) for one in loops)


def _row(one: LocalLoop) -> tuple[str, ...]:
    m, head = one.margins, (one.place, one.input.split(" [")[0])
    if not m.stable:
        return (*head, *["unstable"] * (len(MARGINS) - 2))
    down = 20 * np.log10(m.gain_decrease) if m.gain_decrease > 0 else -np.inf
    return (
        *head,
        significant(m.crossover),
        fixed(20 * np.log10(m.gain_increase), 1),
        fixed(down, 1),
        fixed(float(np.degrees(m.phase)), 0),
        significant(m.delay),
        fixed(20 * np.log10(m.disk.gain_increase), 1),
        fixed(float(np.degrees(m.disk.phase)), 0),
        fixed(m.sensitivity_peak, 2),
    )


def _sorted(poles: np.ndarray) -> list[complex]:
    return sorted((complex(p) for p in poles), key=lambda p: (-p.real, p.imag))


def _complex(value: complex) -> str:
    real = significant(value.real)
    if abs(value.imag) < 1e-9 * max(abs(value), 1e-9):
        return real
    return f"{real} {'+' if value.imag > 0 else '−'} {significant(abs(value.imag))} j"
