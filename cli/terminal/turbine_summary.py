"""The summary of a turbine's design on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.cli.options.turbine_options import typed_name
from takagi.cli.terminal.rows import (
    claims_as_data,
    headline,
    row_as_data,
    row_lines,
    summary_lines,
    wrapped_claims,
)
from takagi.models.laws.protocol import law_words

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

# Lines of the answer without --all, the headline among them.
MOST_LINES = 20
# Rows that the short answer leaves out, unless less is proved than stated.
DETAILS = ("known wind", "actuators", "other pairs")


def as_data(design: TurbineDesign) -> dict[str, Any]:
    """Return the summary as plain data: verdict, figures, claims, how the gains were found."""
    from takagi.reports.sections.turbine.summary import summary_rows

    synthesis = _synthesis(design)
    return {
        "model": design.turbine.name,
        "law": typed_name(design.settings.law),
        "summary": [row_as_data(row) for row in summary_rows(design)],
        **claims_as_data(design.checked),
        **({"synthesis": synthesis} if synthesis else {}),
        "notes": list(design.notes),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: TurbineDesign, *, every_claim: bool = False) -> str:
    """Return the answer in at most 20 lines; with ``every_claim`` also claims and notes.

    A claim that is not proved is quoted in full in any case.
    """
    from takagi.reports.loops.plant_claims import synthesis_words
    from takagi.reports.sections.turbine.summary import summary_rows

    checked = design.checked
    name = f"{design.turbine.name}, {law_words(design.settings.law)}"
    proved = sum(claim.verdict.name == "PROVED" for claim in checked.claims)
    count = f"{proved} of {len(checked.claims)} claims proved"
    lines = [headline(design.verdict_words, name, count, proved=design.proved)]
    for row in summary_rows(design):
        if every_claim or row.partial or row.name not in DETAILS:
            lines += summary_lines(row)
    notes = [line for note in design.notes for line in row_lines("note", note)]
    if every_claim:
        words = synthesis_words(design)
        found_in = row_lines("found in", words) if words else []
        return "\n".join([*lines, *found_in, *wrapped_claims(checked), *notes])
    shared = set.intersection(*(set(claim.assumes) for claim in checked.claims))
    each = [phrase for phrase in checked.assumes if phrase in shared]
    lines += row_lines("assumes", f"{', '.join(each)}; more: --all") if each else []
    lines += wrapped_claims(checked, but="PROVED")
    if not notes or len(lines) + len(notes) <= MOST_LINES:
        return "\n".join([*lines, *notes])
    return "\n".join([*lines, *row_lines("more", f"{len(design.notes)} notes: --all")])


def _synthesis(design: TurbineDesign) -> dict[str, Any] | None:
    """Return how the gains were found, as plain data."""
    from takagi.reports.loops.plant_claims import objective_name

    synthesis = design.synthesis
    if synthesis is None or synthesis.joint is None:
        return None if synthesis is None else {"steps": "two", "kept": synthesis.kept}
    joint = synthesis.joint
    reached = {
        name: {"wind_error": each.wind_error, "decay_rate": each.decay_rate}
        for name, each in (("two-step", joint.before), ("one-step", joint.after))
    }
    return {
        "steps": "one",
        "objective": objective_name(design),
        "joint_steps": len(joint.history) - 1,
        **reached,
    }
