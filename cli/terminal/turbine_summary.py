"""The summary of a turbine's design on the terminal: verdict, winds, wind class, bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees, inf, log10, pi
from typing import TYPE_CHECKING, Any

from takagi.cli.terminal.files import claim_lines
from takagi.cli.terminal.rows import headline, row_lines
from takagi.models.laws.protocol import law_words

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked
    from takagi.certificates.design.turbine.result import ClaimSummary, TurbineDesign
    from takagi.reports.loops.overlap_claims import OverlapClaim
    from takagi.reports.margins.margins import Margins


def as_data(design: TurbineDesign) -> dict[str, Any]:
    """Return the summary as plain data: verdict, claims, and the effort-sharing law's numbers."""
    from takagi.certificates.design.turbine.result import claim_summary

    found = claim_summary(design)
    return {
        "model": design.turbine.name,
        "law": design.settings.law,
        **claims_as_data(design.checked),
        **({} if found is None else _numbers(found)),
        **({} if found is None else {"synthesis": _synthesis(design)}),
        **({"notes": list(design.notes)} if design.notes else {}),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: TurbineDesign, *, every_claim: bool = False) -> str:
    """Return the summary in at most 20 lines; with ``every_claim`` every claim in full.

    A claim about the effort-sharing law that is not proved is quoted in full. Of the claims about a
    published law, the one for the law's own overlaps is shown, and each other one in one line.
    """
    from takagi.certificates.design.turbine.result import claim_summary
    from takagi.reports.loops.overlap_claims import overlap_claims, synthesis_words
    from takagi.reports.page.rounded_bounds import at_least

    verdict = design.checked.verdict.name
    name = f"{design.turbine.name}, {law_words(design.settings.law)}"
    count = f"{len(design.checked.claims)} claims"
    head = headline(verdict, name, count, proved=verdict == "PROVED")
    if overlaps := overlap_claims(design):
        return "\n".join([head, *_by_overlaps(overlaps), *assumed_line(design.checked)])
    found = claim_summary(design)
    if verdict != "PROVED" or found is None:
        return "\n".join([head, claims_as_text(design.checked), *_notes(design)])
    rows = [
        ("winds", f"{found.edges[0]:g} to {found.edges[-1]:g} m/s in {len(found.winds)} cells"),
        ("wind class", f"schedule wind within {_span(found.wind_error)} m/s of the wind, moving at "
         f"most {_span(found.wind_rate)} m/s^2"),
        ("plants", _plants(found)),
        ("rotor speed", _speed(design, found)),
        ("settling", f"decay of at least {at_least(found.common_rate)} 1/s while the wind is "
         "constant"),
        ("observer", _observer(design)),
        ("margins", _margins(design)),
        *([("found in", synthesis_words(design))] if every_claim else []),
        *_assumptions(design, every_claim=every_claim),
        ("not covered", "turbulence outside the wind class; sampling; tower, shaft and blades"),
    ]  # fmt: skip
    lines = [line for word, text in rows if text for line in row_lines(word, text)]
    if every_claim:
        lines += claim_lines(design.checked)
    return "\n".join([head, *lines, *_notes(design)])


def _assumptions(design: TurbineDesign, *, every_claim: bool) -> list[tuple[str, str]]:
    """Return what the set and the loop with the observer assume; each claim's for all claims.

    The claims of rates rest on the set, and add little to its assumptions.
    """
    claims = list(zip(design.document["claims"], design.checked.claims, strict=True))
    if every_claim:
        return [("assumes", f"{claim.name}: {'; '.join(claim.assumes)}") for _, claim in claims]
    words = {"coherent-loop": "set", "running-loop": "observer"}
    return [
        ("assumes", f"{words[stated['kind']]}: {'; '.join(claim.assumes)}")
        for stated, claim in claims
        if stated["kind"] in words
    ]


def _margins(design: TurbineDesign) -> str:
    """Return the least gain and phase margin of the loop that runs, of all plants and winds."""
    from takagi.reports.margins.running_search import design_margins

    rows = [row for row in design_margins(design).rows if row.loops]
    if not rows:
        return ""
    if any(row.decay_rate <= 0 for row in rows):
        return "the linear loop that runs is not stable at every wind, see the report"
    least = []
    for words, size in (("gain", _gain_margin), ("phase", _phase_margin)):
        value, row, loop = min(
            ((size(margins), row, loop) for row in rows for loop, margins in row.loops),
            key=lambda each: each[0],
        )
        unit = "dB" if words == "gain" else "deg"
        least.append(f"{words} {value:.3g} {unit} ({loop}, {row.wind:g} m/s)")
    return f"least of all plants: {', '.join(least)}; linear, not proved"


def _gain_margin(margins: Margins) -> float:
    """Return the factor, up or down, to which a gain may change [dB]."""
    lower = inf if margins.gain_decrease == 0 else 1 / margins.gain_decrease
    return 20 * log10(min(margins.gain_increase, lower))


def _phase_margin(margins: Margins) -> float:
    return degrees(margins.phase)


def _notes(design: TurbineDesign) -> list[str]:
    """Return lines on the margins that were asked; no line where none were."""
    return [f"  note: {note}" for note in design.notes]


def _observer(design: TurbineDesign) -> str:
    """Return what is proved with the observer in the loop, with its gaps; empty for nothing."""
    from takagi.certificates.design.turbine.result import running_loop_summary
    from takagi.reports.page.rounded_bounds import at_least

    found = running_loop_summary(design)
    if found is None:
        return ""
    rate, winds = found
    return (
        f"in the loop, constant wind of {winds}: decay of at least {at_least(rate)} 1/s, from a set"
    )


def _aligned(rows: Mapping[str, str]) -> list[str]:
    width = max(map(len, rows))
    return [f"  {name:<{width}}  {text}" for name, text in rows.items()]


def _by_overlaps(claims: Sequence[OverlapClaim]) -> list[str]:
    """Return lines on the chosen overlaps, then one per other pair."""
    from takagi.reports.loops.overlap_claims import wind_words, window_width

    told = [claim for claim in claims if claim.chosen] or list(claims[:1])
    lines = [line for claim in told for line in _aligned(_overlap_rows(claim))]
    others = [claim for claim in claims if claim not in told]
    if not others:
        return lines
    width = max(map(window_width, others))
    verdict, label = (
        max(map(len, words))
        for words in ([c.verdict.name for c in others], [c.label for c in others])
    )
    return [
        *lines,
        f"Other overlaps, proved winds{f' (windows {width:g} m/s wide)' if width else ''}",
        *(f"  {c.verdict.name:<{verdict}}  {c.label:<{label}}  {wind_words(c)}" for c in others),
    ]


def _overlap_rows(claim: OverlapClaim) -> dict[str, str]:
    from takagi.reports.loops.overlap_claims import gap_words, wind_words

    rows = {"overlaps": f"{claim.label}: {claim.verdict.name}", "proved winds": wind_words(claim)}
    if claim.left:
        rows["not proved"] = gap_words(claim)
    if not (claim.decay and claim.speed_share and claim.half_width):
        return rows | {"claim": claim.text}
    return rows | {
        "claim": "at each constant wind, v_hat = v, one equilibrium in a stated set, reached from "
        "all of it",
        "set": f"half-width in speed up to {claim.half_width} rad/s",
        "settling": f"decay of at least {' to '.join(claim.decay)} 1/s, by wind",
        "at rest": f"speed within {claim.speed_share} % of rated of its reference",
        **({"pitch": claim.pitch.removeprefix("pitch ")} if claim.pitch else {}),
    }


def claims_as_text(checked: Checked) -> str:
    """Return one line per claim, as `takagi check` prints them."""
    return "\n".join([*claim_lines(checked), *assumed_line(checked)])


def assumed_line(checked: Checked) -> list[str]:
    """Return the line on the assumptions of the verdict; no line where there are none."""
    return [f"  assumes: {'; '.join(checked.assumes)}"] if checked.assumes else []


def claims_as_data(checked: Checked) -> dict[str, Any]:
    """Return verdict and claims as plain data."""
    claims = [
        {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
        for claim in checked.claims
    ]
    return {"verdict": checked.verdict.name, "claims": claims, "assumes": list(checked.assumes)}


def _numbers(found: ClaimSummary) -> dict[str, Any]:
    return {
        "wind": [found.edges[0], found.edges[-1]],
        "cells": len(found.winds),
        "wind_error": [min(found.wind_error), max(found.wind_error)],
        "wind_rate": [min(found.wind_rate), max(found.wind_rate)],
        "inertia": list(found.inertia),
        "power_coefficient": list(found.power_coefficient),
        "frozen_wake": found.frozen_wake,
        "overspeed": found.overspeed,
        "decay_rate": found.common_rate,
    }


def _synthesis(design: TurbineDesign) -> dict[str, Any] | None:
    """Return how the gains were found, as plain data."""
    from takagi.reports.loops.overlap_claims import synthesis_summary

    found = synthesis_summary(design)
    if found is None or found.before is None or found.after is None:
        return None if found is None else {"steps": "two", "kept": found.kept}
    reached = {
        name: {"wind_error": each.wind_error, "decay_rate": each.decay_rate}
        for name, each in (("two-step", found.before), ("one-step", found.after))
    }
    return {"steps": "one", "objective": found.objective, "joint_steps": found.steps, **reached}


def _span(values: Sequence[float]) -> str:
    from takagi.reports.page.rounded_bounds import at_least

    return f"{at_least(min(values))} to {at_least(max(values))}"


def _plants(found: ClaimSummary) -> str:
    wake = "up to the frozen wake's" if found.frozen_wake else "of the equilibrium wake"
    low, high = found.inertia
    least, most = found.power_coefficient
    power = f", c_P {least:g} to {most:g} of the table's" if least < most else ""
    return f"inertia {low:g} to {high:g} of nominal{power}, pitch effectiveness {wake}"


def _speed(design: TurbineDesign, found: ClaimSummary) -> str:
    from takagi.reports.page.rounded_bounds import at_most

    side = "above" if found.overspeed >= 0 else "below"
    top = (1 + found.overspeed) * design.turbine.rated_rotor_speed * 30 / pi
    share = at_most(100 * found.overspeed).removeprefix("-")
    return (
        f"at most {at_most(top, 4)} rpm, {share} % {side} rated, in this class from any start in "
        "the set"
    )
