"""The verdict: the proved properties of this plant, and what is not covered."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.loops.plant_local import PlantLocalLoop
from takagi.reports.loops.plant_loop import largest_commands
from takagi.reports.loops.proved_kinds import embedded, proved_kinds
from takagi.reports.page.text import (
    Section,
    at_least,
    behind,
    decimal,
    name_of,
    significant,
    unit_of,
)
from takagi.reports.sections.shared import verdict_box

if TYPE_CHECKING:
    from collections.abc import Sequence

    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop


def verdict_section(
    design: PlantDesign, loop: PlantLoop, loops: Sequence[PlantLocalLoop]
) -> Section:
    """Return the verdict box of a plant's design."""
    return verdict_box(
        design.checked,
        {
            "messages": list(design.checked.messages),
            "name": design.plant.name or "the plant",
            "embedded": embedded(design),
            "decays": loop.decay_rate is not None,
            "level_proved": loop.level_proved,
            "law": loop.gains is not None,
            "measured": list(design.plant.measured or ()),
            "facts": _facts(loop, loops, limits="input-limits" in proved_kinds(design)),
            "inputs_bounded": [v.name for v in design.plant.inputs if v.range is not None],
            "disturbances": [v.name for v in design.plant.disturbances if not v.schedules],
            "signals": [v.name for v in design.plant.disturbances if v.schedules],
            "discrete": loop.discrete,
        },
    )


def _facts(
    loop: PlantLoop, loops: Sequence[PlantLocalLoop], *, limits: bool
) -> list[tuple[str, str, str]]:
    """Return (name, figure, remark) of each fact.

    ``limits`` : a claim proves bounds of the inputs, so that none in floating point is shown.
    """
    model = loop.model
    varying = sum(len(p.corners) > 1 for p in model.premises)
    facts = [
        (
            "Model",
            f"{len(model.rules)} rules",
            f"from {varying} premises with proved bounds"
            if varying != 1
            else "from one premise with proved bounds",
        )
    ]
    if loop.decay_rate is not None:
        time = 1 / loop.decay_rate if loop.decay_rate > 0 else np.inf
        what = "the state" if loop.observed is None else "state and estimate"
        facts.append(
            (
                "Decay, proved",
                f"≥ {at_least(loop.decay_rate)} 1/s",
                f"of {what}, in the measure √V: a factor e in at most {significant(time)} s"
                if np.isfinite(time)
                else "V does not grow",
            )
        )
    facts += [
        (
            f"Box, {name_of(label)}",
            f"{_short(float(low))} to {_short(float(high))}{behind(unit_of(label))}",
            "deviation from rest",
        )
        for label, (low, high) in model.box.items()
    ]
    facts += [
        (
            "Largest command",
            f"{significant(size)}{behind(unit_of(name))}",
            f"of {name_of(name)}, from rest value, for states in the ellipsoid; floating point",
        )
        for name, size in ([] if limits else largest_commands(loop))
    ]
    rest = [one for one in loops if one.place == "rest"]
    facts += [
        (
            "Margins at rest",
            f"{significant(float(np.degrees(one.margins.phase)), 2)}° phase, "
            f"{significant(one.margins.disk.alpha, 2)} disk",
            f"loop at {name_of(one.input)}, linear; stable up to a delay of "
            f"{significant(one.margins.delay)} s",
        )
        for one in rest
        if one.margins.stable and np.isfinite(one.margins.phase)
    ]
    return facts


def _short(value: float) -> str:
    """Return at most six digits; the table of variables shows all."""
    return decimal(float(f"{value:.6g}"))
