"""Each claim about a plant in plain words: its number, its own assumptions, and why it matters.

Behind it the claims as the checker states them, and the proved set in pictures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.requests.tracking import jump_shares
from takagi.models.arrays import Floats
from takagi.models.plant.plant import file_unit, rate_in_file_units, time_in_file_units
from takagi.models.tracking import signals_of
from takagi.reports.figures.plant.proved_set import MOST_STATES, pairs, set_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.kinds_in_words import KINDS_IN_WORDS
from takagi.reports.loops.plant_claims import SETTLED, half_widths, overshoots, settling_time
from takagi.reports.loops.plant_local import regulator
from takagi.reports.loops.plant_loop import PlantLoop, embedded
from takagi.reports.page.text import (
    DASH,
    Section,
    at_least,
    at_most,
    behind,
    decimal,
    per_unit,
    table,
)
from takagi.reports.sections.plant.summary import (
    EMBEDDINGS,
    SETS,
    assumptions,
    set_starts,
    start_words,
)


def claim_rows(design: PlantDesign, loop: PlantLoop) -> list[dict[str, str]]:
    """Return the claims in the order of the certificate, as a reader needs them.

    ``number`` is the bound that is proved, for another verdict the reason; ``text`` the checker's
    own words, which the page folds.
    """
    stated: list[Mapping[str, Any]] = list(design.document.get("claims", []))
    stated += [{}] * (len(design.checked.claims) - len(stated))
    return [
        _row(design, loop, claim, result)
        for claim, result in zip(stated, design.checked.claims, strict=False)
    ]


def _row(
    design: PlantDesign, loop: PlantLoop, claim: Mapping[str, Any], result: Claim
) -> dict[str, str]:
    kind = str(claim.get("kind", ""))
    words = KINDS_IN_WORDS.get(kind)
    name, why = (words.name, words.why) if words else (result.name, "")
    bounds = claim.get("disturbance_bounds")
    number = result.text
    if result.verdict is Verdict.PROVED:
        # A decay at rate 0 has no number; a kind without phrases here shows its sentence.
        otherwise = DASH if "decay_rate" in claim else result.text
        number = "; ".join(_numbers(design, loop, kind, claim)) or otherwise
    if bounds and kind in SETS:
        name = f"{name} under disturbance"
    assumes, text = "; ".join(assumptions(loop, claim)), f"{result.name}: {result.text}"
    verdict = result.verdict.name
    return {"name": name, "verdict": verdict, "number": number, "assumes": assumes, "why": why,
            "text": text}  # fmt: skip


def _numbers(
    design: PlantDesign, loop: PlantLoop, kind: str, claim: Mapping[str, Any]
) -> list[str]:
    """Return the bounds that a proved claim has, in the units of the file."""
    if kind in EMBEDDINGS:
        rules = len(loop.model.rules)
        return ["one linear system" if rules == 1 else f"{rules} rules"]
    if kind in ("invariant-ellipsoid", "input-limits", "sampled-loop"):
        step = claim.get("sample_time")
        sampling = [] if step is None else [f"every {float(_exact(step)):g} s"]
        return [*_limits(loop, claim), *sampling, *_starts(loop, claim)]
    plain: dict[str, Callable[[Fraction], str]] = {
        "decay_rate": lambda x: f"decay rate at least {_rate(loop, x)}",
        "overshoot": lambda x: f"at most {at_most(x)} times the start",
        "settling_time": lambda x: f"to {100 * claim['settled_share']:g} % within {_time(loop, x)}",
        "relative": lambda x: f"all gains off by up to {at_least(100 * x)} %",
        "gain": lambda x: f"gain at most {at_most(x)}",
        "norm": lambda x: f"norm at most {at_most(x)}",
        "probability": lambda x: f"at most {at_most(x)}",
        "horizon": lambda x: f"in {_time(loop, x)}",
    }
    phrases = _limits(loop, claim)
    if kind == "tracking":
        phrases += _jumps(design, claim)
    for key, words in plain.items():
        value = claim.get(key)
        if value is not None and _exact(value) > 0:
            phrases.append(words(_exact(value)))
    return phrases


def _starts(loop: PlantLoop, claim: Mapping[str, Any]) -> list[str]:
    """Return how far a state may start, one at a time, and the disturbances that are withstood."""
    phrases = [start_words(number) for number in set_starts(loop, claim["P"], claim["level"])]
    bounds = claim.get("disturbance_bounds") or ()
    moving = [
        f"|{variable.name}| \u2264 {at_least(float(_exact(bound)) / size)}{behind(unit)}"
        for variable, bound in zip(loop.plant.disturbances, bounds, strict=False)
        for size, unit in (file_unit(variable),)
    ]
    return [", ".join(moving)] * bool(moving) + [f"one state at a time: {', '.join(phrases)}"]


def _limits(loop: PlantLoop, claim: Mapping[str, Any]) -> list[str]:
    return [
        f"|{variable.name}| \u2264 {at_most(float(_exact(limit)) / size)}{behind(unit)}"
        for variable, limit in zip(loop.plant.inputs, claim.get("input_limits") or (), strict=False)
        for size, unit in (file_unit(variable),)
    ]


def _jumps(design: PlantDesign, claim: Mapping[str, Any]) -> list[str]:
    signals = {variable.name: variable for variable in design.plant.disturbances}
    phrases = []
    for reference, share in zip(
        design.plant.references, jump_shares(design.plant, claim), strict=True
    ):
        side = signals[reference.name].range
        assert side is not None  # a reference has one
        size, unit = file_unit(signals[reference.name])
        jump = min(share, 1.0) * float(side.width)
        phrases.append(f"{reference.name} steps up to {at_least(jump / size)}{behind(unit)}")
    for variable, rate in zip(signals_of(design.plant), claim["rates"], strict=True):
        if rate:
            size, unit = file_unit(variable)
            fastest = at_least(float(_exact(rate)) / size)
            phrases.append(f"{variable.name} may move at {fastest} {per_unit(unit, 's')}")
    return phrases


def _rate(loop: PlantLoop, value: Fraction) -> str:
    rate, unit = rate_in_file_units(loop.plant, float(value))
    return f"{at_least(rate)} {unit}"


def _time(loop: PlantLoop, value: Fraction) -> str:
    time, unit = time_in_file_units(loop.plant, float(value))
    return f"{at_most(time)} {unit}"


def _exact(value: object) -> Fraction:
    return Fraction(str(value))


def certificate_section(design: PlantDesign, loop: PlantLoop) -> Section:
    """Return the section with each claim, and what none of them covers."""
    return Section(
        "certificate",
        "What is proved, claim by claim",
        {
            "claims": claim_rows(design, loop),
            "embedded": embedded(design),
            "law": loop.gains is not None,
            "measured": list(design.plant.measured or ()),
            "disturbances": [v.name for v in design.plant.disturbances if not v.schedules],
            "signals": [v.name for v in design.plant.disturbances if v.schedules],
            "discrete": loop.discrete,
            "tried": list(design.certificate.tried),
            "level_proved": loop.level_proved,
        },
    )


def set_section(design: PlantDesign, loop: PlantLoop) -> Section | None:
    """Return the section; None where no set is proved to be invariant."""
    reach = half_widths(loop)
    if reach is None:
        return None
    beside = regulator(design)
    regulator_starts = None if beside is None else beside.starts
    captioned_figures = []
    # Of two states the first screen has the picture.
    if len(pairs(loop)) > 1:
        captioned_figures.append(captioned_figure(set_figure(loop), "set"))
    rows = _rows(design, loop, reach, regulator_starts)
    whole = table("set", rows)
    # A column without a figure is left out.
    shown = [k for k in range(len(whole.columns)) if any(row[k] != DASH for row in rows)]
    time = settling_time(loop)
    settled = ""
    if time is not None:
        number, unit = time_in_file_units(loop.plant, time)
        settled = f"{at_most(number)} {unit}"
    return Section(
        "set",
        "The safe set",
        {
            "table": replace(
                whole,
                columns=tuple(whole.columns[k] for k in shown),
                rows=tuple(tuple(row[k] for k in shown) for row in rows),
            ),
            "overshoot": any(row[5] != DASH for row in rows),
            "none_beside": beside is not None and beside.sought and regulator_starts is None,
            "figures": captioned_figures,
            "left_out": max(len(loop.names) - MOST_STATES, 0) if captioned_figures else 0,
            "settled": settled,
            "share": f"{SETTLED:.0%}",
            "observed": loop.observed is not None,
        },
    )


def _rows(
    design: PlantDesign, loop: PlantLoop, reach: Floats, regulator_starts: Floats | None
) -> tuple[tuple[str, ...], ...]:
    P, level = loop.start_ellipsoid
    alone = np.sqrt(level / np.diag(P))
    beyond = overshoots(design, loop)
    count = len(loop.names) - len(loop.plant.integrators)
    rows = []
    for k, (name, variable) in enumerate(zip(loop.names, loop.plant.states, strict=True)):
        size, unit = file_unit(variable)
        ends = loop.model.box.get(loop.model.states[k])
        box = DASH
        if ends is not None:
            low, high = (decimal(float(f"{float(end) / size:.6g}")) for end in ends)
            box = f"{low} to {high}"
        rows.append(
            (
                name,
                unit,
                f"±{at_least(float(alone[k]) / size)}" if k < count else DASH,
                f"±{at_most(float(reach[k]) / size, 4)}",
                box,
                at_most(beyond[name]) if name in beyond else DASH,
                DASH
                if regulator_starts is None
                else f"±{at_least(float(regulator_starts[k]) / size)}",
            )
        )
    return tuple(rows)
