"""Which kind of model a file describes, by what it says."""

from __future__ import annotations

from types import MappingProxyType
from typing import Literal, TypeAlias

from takagi.models.errors import did_you_mean
from takagi.models.files.toml_document import Document

Kind: TypeAlias = Literal["plant", "turbine"]

# Sections that files of one kind alone have; a guess is made of them, and never followed.
_SECTIONS = MappingProxyType(
    {
        "plant": (
            "states",
            "inputs",
            "disturbances",
            "scheduling",
            "parameters",
            "tables",
            "equations",
            "mass",
            "outputs",
            "premises",
            "blending",
        ),
        "turbine": (
            "rotor",
            "drivetrain",
            "generator",
            "pitch",
            "tower",
            "operation",
            "coefficients",
            "frozen_wake",
            "baseline",
        ),
    }
)
_NEEDED = 'a model file says kind = "plant" or kind = "turbine" above its first section'


def kind_of(document: Document) -> Kind:
    """Return the kind that a file states.

    Raises
    ------
    ModelError : none, or another one; says which the sections of the file belong to.
    """
    match document.data.get("kind"):
        case "plant":
            return "plant"
        case "turbine":
            return "turbine"
        case None:
            problem, near = "is missing", ""
        case stated:
            problem = f"{stated!r} was given"
            near = did_you_mean(stated, _SECTIONS) if isinstance(stated, str) else ""
    first = next((name for name, part in document.data.items() if isinstance(part, dict)), "")
    raise document.error("kind", f"{problem}{near}; {_NEEDED}{_guess(document)}", beside=first)


def _guess(document: Document) -> str:
    """Return whose sections the file has, and what to write; nothing where it has none."""
    found = {
        kind: [name for name in document.data if name in sections]
        for kind, sections in _SECTIONS.items()
    }
    kind = max(found, key=lambda one: len(found[one]))
    if not found[kind]:
        return ""
    told = ", ".join(f"[{name}]" for name in found[kind][:3])
    belongs = "belongs" if len(found[kind]) == 1 else "belong"
    return f'. {told} {belongs} to a {kind}: write kind = "{kind}"'
