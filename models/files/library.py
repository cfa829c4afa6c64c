"""The models that come with the package, by name, and which kind of model a file describes."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.toml_document import Document, read_document


def data_folder() -> Path:
    """Return the folder with the package's model files."""
    return Path(__file__).parents[1] / "data"


@lru_cache(maxsize=1)
def _tables() -> dict[str, dict[str, Any]]:
    return {path.stem: read_document(path).data for path in sorted(data_folder().glob("*.toml"))}


def _descriptions() -> dict[str, str]:
    return {
        name: str(data.get("description", data.get("name", name)))
        for name, data in _tables().items()
    }


def built_in_kinds() -> dict[str, str]:
    """Return name -> ``"turbine"`` or ``"plant"`` of every built-in model."""
    return {name: str(data["kind"]) for name, data in _tables().items()}


def built_in_models() -> list[tuple[str, str]]:
    """Return (name, one-line description) of every built-in model, sorted by name."""
    return list(_descriptions().items())


def resolve_model(name_or_path: str | Path) -> Path:
    """Return the file of a built-in name, or the path of a user's own TOML file.

    A built-in name wins over a file of that name; write ``./name`` for the file.

    Raises
    ------
    ModelError : neither a built-in name (near names are offered) nor a readable file.
    """
    built_in = sorted(path.stem for path in data_folder().glob("*.toml"))
    if isinstance(name_or_path, str) and name_or_path in built_in:
        return data_folder() / f"{name_or_path}.toml"
    path = Path(name_or_path)
    if path.is_file():
        return path
    if path.is_dir():
        raise ModelError(f"{path}: is a folder; name the model's TOML file in it")
    text = str(name_or_path)
    looks_like_path = path.suffix == ".toml" or "/" in text or "\\" in text
    if looks_like_path:
        raise ModelError(
            f"{path}: no such file; check the path, or use a built-in model: " + ", ".join(built_in)
        )
    raise ModelError(
        f"model {text!r} is not known{did_you_mean(text, built_in)}; built-in models: "
        f"{', '.join(built_in)}; or give the path of a TOML file"
    )


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
            problem, suggestion = "is missing", ""
        case stated:
            problem = f"{stated!r} was given"
            suggestion = did_you_mean(stated, _SECTIONS) if isinstance(stated, str) else ""
    first = next((name for name, section in document.data.items() if isinstance(section, dict)), "")
    raise document.error(
        "kind", f"{problem}{suggestion}; {_NEEDED}{_guess(document)}", beside=first
    )


def _guess(document: Document) -> str:
    """Return whose sections the file has, and what to write; nothing where it has none."""
    own_sections = {
        kind: [name for name in document.data if name in sections]
        for kind, sections in _SECTIONS.items()
    }
    kind = max(own_sections, key=lambda candidate: len(own_sections[candidate]))
    if not own_sections[kind]:
        return ""
    section_names = ", ".join(f"[{name}]" for name in own_sections[kind][:3])
    belongs = "belongs" if len(own_sections[kind]) == 1 else "belong"
    return f'. {section_names} {belongs} to a {kind}: write kind = "{kind}"'
