"""The claims one by one: verdicts, the proved functions, and the attempts that failed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.reports.loops.overshoot import overshoots
from takagi.reports.page.rounded_bounds import at_most
from takagi.reports.page.text import Section, Table, significant

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop


def certificate_section(design: PlantDesign, loop: PlantLoop) -> Section:
    """Return the section with each claim, P and its ellipsoid."""
    claims = design.document.get("claims", [])
    kinds = [str(claim.get("kind", "")) for claim in claims]
    kinds += [""] * (len(design.checked.claims) - len(kinds))
    found = zip(design.checked.claims, kinds, strict=False)
    level = loop.level
    return Section(
        "certificate",
        "The certificate, claim by claim",
        {
            "claims": Table(
                "Claims, in the order of the file",
                (("claim", ""), ("kind", ""), ("verdict", "")),
                tuple((c.name, kind, c.verdict.name) for c, kind in found),
                note="What each says, with its numbers, stands above in the verdict.",
            ),
            "tried": list(design.certificate.tried),
            "functions": _functions(loop),
            "together": _first_part(loop),
            "level": significant(level, 4) if level is not None and loop.bounded else "",
            "level_proved": loop.level_proved,
            "states": list(loop.model.states),
            "overshoot": [f"{name} {at_most(k)}" for name, k in overshoots(design, loop).items()],
        },
    )


def _first_part(loop: PlantLoop) -> str:
    """Return the first part of z = (., x - s) of a law with outputs; empty for any other."""
    if loop.observed is None:
        return ""
    return "s" if loop.observed.law.at_estimate else "x"


def _functions(loop: PlantLoop) -> list[tuple[str, list[list[str]]]]:
    """Return (name, rows of P) of the functions for decay and for the invariant set."""
    if loop.observed is not None and loop.observed.P is not None:
        P = loop.observed.P
        rows = [[significant(float(entry), 6) for entry in row] for row in P]
        return [("plant and estimate", rows)]
    found = [("decay", loop.decay_P)] if loop.decay_P is not None else []
    if loop.level_proved and loop.P is not None:
        found.append(("invariant set", loop.P))
    return [
        (words, [[significant(float(entry), 6) for entry in row] for row in P])
        for words, P in found
        if P is not None
    ]
