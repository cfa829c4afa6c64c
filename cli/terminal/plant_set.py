"""The proved set in the summary of a plant, in the units of the plant's file."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.plant.file_units import file_unit, rate_in_file_units, time_in_file_units
from takagi.reports.loops.linear_quadratic import regulator
from takagi.reports.loops.plant_claims import (
    SETTLED,
    half_widths,
    overshoots,
    settling_time,
    withstood,
)
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.page.rounded_bounds import at_least, at_most
from takagi.reports.page.text import behind, name_of, unit_of
from takagi.reports.simulation.plant import proved_jumps

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop

SMALL = 0.1  # share of the box below which the proved set is called small


def starts_alone(design: PlantDesign) -> dict[str, float]:
    """Return state -> sqrt(c / P_kk) in SI; {} where no set {x'Px <= c} is proved invariant.

    It is the largest deviation of this state in the set while all other states are at rest.
    """
    return _starts(plant_loop(design))


def box_line(design: PlantDesign) -> list[str]:
    """Return the box, one range for each variable that has one."""
    plant, model = design.plant, design.model
    labels = (*model.states, *model.inputs, *model.disturbances)
    variables = (*plant.states, *plant.inputs, *plant.disturbances)
    units = {label: file_unit(v) for label, v in zip(labels, variables, strict=False)}
    sides = []
    for label, (low, high) in model.box.items():
        size, unit = units.get(label, (1.0, unit_of(label)))
        ends = f"[{float(low) / size:.6g}, {float(high) / size:.6g}]"
        sides.append(kept(f"{name_of(label)} in {ends}{behind(unit)}"))
    return told("box", ", ".join(sides)) if sides else []


def set_lines(design: PlantDesign) -> list[str]:
    """Return the lines on the proved set: starts, largest states, decay and overshoot."""
    loop = plant_loop(design)
    return [
        *_set(loop),
        *_motion(loop),
        *_follows(design),
        *_withstood(design),
        *_decay(loop),
        *_overshoot(design, loop),
    ]


def regulator_line(design: PlantDesign) -> list[str]:
    """Return gains, settling and proved set of an LQR at rest, compared with this law."""
    found = regulator(design)
    if found is None:
        return []
    loop = plant_loop(design)
    plant, step = loop.plant, loop.model.sample_time
    names = ", ".join(loop.names)
    gains = [
        kept(f"{label} {'; '.join(f'{float(k):.4g}' for k in row)}")
        for label, row in zip(loop.model.inputs, found.gain, strict=True)
    ]
    text = f"at rest, floating point, weights 1/range^2: gains from ({names}) to {', '.join(gains)}"
    times = [found.settling(own=own, step=step) for own in (False, True)]
    if times[0] is not None and times[1] is not None:
        one, two = (time_in_file_units(plant, time) for time in times if time is not None)
        text += (
            f"; slowest mode to {SETTLED:.0%} in {one[0]:.3g} {one[1]}, here {two[0]:.3g} {two[1]}"
        )
    if not found.sought:
        text += "; its proved set was not sought"
    elif found.starts is None:
        text += "; no invariant set was proved for it"
    else:
        starts = []
        for variable, name, reach in zip(plant.states, loop.names, found.starts, strict=True):
            size, unit = file_unit(variable)
            starts.append(kept(f"{name} {at_least(float(reach) / size)}{behind(unit)}"))
        text += f"; its own proved set, within the ranges, has starts up to {', '.join(starts)}"
    return told("LQR", text)


def _starts(loop: PlantLoop) -> dict[str, float]:
    if not (loop.bounded and loop.level_proved):
        return {}
    P, level = loop.start_ellipsoid
    reach = (float(np.sqrt(level / size)) for size in np.diag(P))
    return dict(zip(loop.model.states, reach, strict=True))


def _set(loop: PlantLoop) -> list[str]:
    """Return the starts in the proved set, with a hint where they are a small part of the box."""
    box = loop.model.box
    parts, shares = [], []
    for variable, (label, reach) in zip(loop.plant.states, _starts(loop).items(), strict=False):
        size, unit = file_unit(variable)
        part = f"{name_of(label)} {at_least(reach / size)}{behind(unit)}"
        if label in box:
            shares.append(reach / max(abs(float(end)) for end in box[label]))
            part += f" ({100 * shares[-1]:.2g} %)" if shares[-1] < 0.995 else " (all)"
        parts.append(kept(part))
    if not parts:
        return []
    text = f"starts with one state alone off rest stay in the box up to {', '.join(parts)}"
    if shares and max(shares) < SMALL:
        text += (
            ". That is little of the box: see whether smaller ranges of the states, a lower decay "
            "rate or larger inputs give more"
        )
    return told("set", text)


def _motion(loop: PlantLoop) -> list[str]:
    """Return the largest states from any start in the proved set, and the settling time."""
    reach, time = half_widths(loop), settling_time(loop)
    if reach is None:
        return []
    parts = []
    for variable, label, most in zip(loop.plant.states, loop.model.states, reach, strict=True):
        size, unit = file_unit(variable)
        parts.append(kept(f"|{name_of(label)}| <= {at_most(float(most) / size, 4)}{behind(unit)}"))
    text = f"from anywhere in the set {', '.join(parts)}"
    if time is not None:
        number, unit = time_in_file_units(loop.plant, time)
        text += f"; within {at_most(number)} {unit} all are below {SETTLED:.0%} of that"
    return told("motion", text)


def _follows(design: PlantDesign) -> list[str]:
    """Return what follows which reference, and after which jumps all ranges are kept."""
    jumps = proved_jumps(design)
    if not jumps:
        return []
    signals = {v.name: v for v in design.plant.disturbances}
    parts = []
    for one in design.plant.references:
        variable = signals[one.name]
        size, unit = file_unit(variable)
        assert variable.range is not None  # a reference has one
        low, high = (float(end) / size for end in (variable.range.lower, variable.range.upper))
        reach = max(abs(j[one.name] - float(variable.rest)) for j in jumps if one.name in j) / size
        parts.append(
            f"{one.follows} comes to {one.name} without error for every constant {one.name} in "
            + kept(f"[{low:.6g}, {high:.6g}]{behind(unit)}")
            + ", and after jumps from rest of up to "
            + kept(f"{at_least(reach)}{behind(unit)}")
            + " all ranges are kept"
        )
    return told("follows", "; ".join(parts))


def _withstood(design: PlantDesign) -> list[str]:
    """Return which disturbance a proved set withstands, beside the range that the file states."""
    # What follows a reference is said in a line of its own.
    followed = {name for jump in proved_jumps(design) for name in jump}
    rows = [row for row in withstood(design) if row.variable.name not in followed]
    kinds = {claim["kind"] for claim in design.document["claims"]}
    if not rows or design.gains is None or kinds == {"tracking"}:
        # Where references alone are claimed, no set against moving disturbances was asked for.
        return []
    parts, less = [], False
    for one in rows:
        size, unit = file_unit(one.variable)
        stated = f"{one.stated / size:.6g}{behind(unit)}"
        name = one.variable.name
        if not one.proved:
            parts.append(kept(f"{name}: no set is proved for any of its {stated}"))
        elif one.share < 1:
            found = f"{at_least(one.proved / size)}{behind(unit)}"
            parts.append(kept(f"{name} up to {found}, which is {one.share:.2g} times the {stated}")
                         + " of the file")  # fmt: skip
        else:
            parts.append(kept(f"{name} up to {stated}") + ", all of its range")
        less = less or one.share < 1
    text = f"off rest, under which a set of states is never left: {', '.join(parts)}"
    if less:
        text += (
            ". To withstand more: wider ranges of states and inputs, or a faster loop; or state a "
            "smaller disturbance"
        )
    return told("withstands", text)


def _decay(loop: PlantLoop) -> list[str]:
    """Return the proved decay rate; claims that are listed below it may have rates of another V."""
    if not loop.decay_rate:
        return []
    rate, unit = rate_in_file_units(loop.plant, loop.decay_rate)
    time, seconds = time_in_file_units(loop.plant, 1 / loop.decay_rate)
    disturbed = any(not v.schedules for v in loop.plant.disturbances)
    still = ", without disturbance," if disturbed else ""
    if loop.observed is not None:
        return told(
            "decay",
            f"{at_least(rate)} {unit}: in the proved set{still} the square root of V of state and "
            f"estimate falls to 37% in {at_most(time)} {seconds}",
        )
    return told(
        "decay",
        f"{at_least(rate)} {unit}: in the box{still} the square root of V falls to 37% in "
        f"{at_most(time)} {seconds}; other rates below belong to claims with another V",
    )


def _overshoot(design: PlantDesign, loop: PlantLoop) -> list[str]:
    parts = [kept(f"{name} {at_most(k)}") for name, k in overshoots(design, loop).items()]
    if not parts:
        return []
    return told(
        "overshoot",
        f"a state that alone starts off rest, in the set, goes at most so many times as far: "
        f"{', '.join(parts)}",
    )


WIDTH, INDENT = 100, " " * 13
_TIE = "\N{NO-BREAK SPACE}"


def told(word: str, text: str) -> list[str]:
    """Return the heading and its text, broken into indented lines."""
    start = f"  {word}".ljust(len(INDENT))
    filled = fill(text, WIDTH, initial_indent=start, subsequent_indent=INDENT)
    return [filled.replace(_TIE, " ")]


def kept(part: str) -> str:
    """Return the part with no-break spaces, so that it stays on one line."""
    return part.replace(" ", _TIE)
