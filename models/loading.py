"""The reader of model files: a built-in name or a path, read once.

``read_model`` returns the file as a value: its kind, its document, the files beside it, and the
model, made when it is asked for.  A verb reads it at its door and passes it on.

Which kind of model a file describes, by what it says.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, TypeAlias

from takagi.models.errors import did_you_mean
from takagi.models.files.toml_document import Document

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.plant_files.loader import PlantFile
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.loader import TurbineFile

    ModelFile: TypeAlias = PlantFile | TurbineFile


def read_model(name_or_path: str | Path) -> ModelFile:
    """Return the file of a built-in name or path, read once.

    Raises
    ------
    ModelError : no such model, a file that is not TOML, or one that states no kind of model.
    """
    from takagi.models.files.library import resolve_model
    from takagi.models.files.toml_document import decimal_of, read_document

    document = read_document(resolve_model(name_or_path), parse_float=decimal_of)
    if kind_of(document) == "plant":
        from takagi.models.plant_files.loader import PlantFile

        return PlantFile(name_or_path, document)
    from takagi.models.turbine.loader import TurbineFile

    return TurbineFile(name_or_path, document.in_floats())


def load_model(name_or_path: str | Path) -> Plant | Turbine:
    """Return the model of a built-in name (``"nrel5mw"``) or of a TOML file.

    A file with ``kind = "plant"`` gives a ``Plant``, one with ``kind = "turbine"`` a ``Turbine``.

    Raises
    ------
    ModelError : neither a built-in name nor a readable file, a file of another kind, or one that
        is malformed; the message names file, line, field and what was expected.
    """
    return read_model(name_or_path).model


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
