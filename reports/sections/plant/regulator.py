"""The design compared with a linear-quadratic regulator: gains, poles, settling, proved sets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.plant.file_units import file_unit, time_in_file_units
from takagi.reports.loops.linear_quadratic import MOST_RULES, MOST_STATES, Regulator, regulator
from takagi.reports.loops.settling import SETTLED
from takagi.reports.page.labels import name_of
from takagi.reports.page.rounded_bounds import at_least
from takagi.reports.page.text import DASH, Section, Table, complex_words, significant
from takagi.reports.sections.plant.gains import gain_columns

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop

COLUMNS = (("", ""), ("unit", ""), ("this law at rest", ""), ("LQR", ""))


def regulator_section(design: PlantDesign, loop: PlantLoop) -> Section | None:
    """Return the section; None where there is no regulator to compare with."""
    found = regulator(design)
    if found is None:
        return None
    sizes = [
        *zip(loop.plant.states, found.states, strict=True),
        *zip(loop.plant.inputs, found.inputs, strict=True),
    ]
    weights = [
        f"{v.name}: {significant(float(size) / file_unit(v)[0])} {_unit(file_unit(v)[1])}".strip()
        for v, size in sizes
    ]
    return Section(
        "lqr",
        "Beside a linear-quadratic regulator",
        {
            "weights": weights,
            "table": Table("This law and LQR where the plant rests", COLUMNS, _rows(loop, found)),
            "poles": ", ".join(complex_words(found.own_poles)),
            "others": ", ".join(complex_words(found.poles)),
            "sought": found.sought,
            "proved": found.starts is not None,
            "most": (MOST_RULES, MOST_STATES),
        },
    )


def _rows(loop: PlantLoop, found: Regulator) -> tuple[tuple[str, ...], ...]:
    heads = gain_columns(loop)[-found.gain.size :]
    pairs = zip(heads, found.own_gain.ravel(), found.gain.ravel(), strict=True)
    rows: list[tuple[str, ...]] = [
        (f"gain, {name}", unit, significant(float(own), 4), significant(float(other), 4))
        for (name, unit), own, other in pairs
    ]
    step = loop.model.sample_time
    times = [found.settling(own=own, step=step) for own in (True, False)]
    shown = [None if time is None else time_in_file_units(loop.plant, time) for time in times]
    rows.append(
        (
            f"slowest mode at rest falls to {SETTLED:.0%} in",
            "",
            *(DASH if t is None else f"{significant(t[0])} {t[1]}" for t in shown),
        )
    )
    own = None
    if loop.bounded and loop.level_proved:
        P, level = loop.ellipsoid
        own = np.sqrt(level / np.diag(P))
    for k, variable in enumerate(loop.plant.states):
        size, unit = file_unit(variable)
        ends = [
            DASH if one is None else f"±{at_least(float(one[k]) / size)}"
            for one in (own, found.starts)
        ]
        rows.append((f"proved start of {name_of(loop.names[k])} alone", unit, *ends))
    return tuple(rows)


def _unit(unit: str) -> str:
    return "" if unit == "-" else unit
