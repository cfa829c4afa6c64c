"""Model files: parsed TOML with line numbers, and built-in models by name."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import Unit, parse_unit


@dataclass(frozen=True, slots=True)
class Document:
    """A parsed file: where it is, its text, and its tables."""

    path: Path
    text: str
    data: dict[str, Any]

    def in_floats(self) -> Document:
        """Return the same file with its decimals as floats, those nearest to them."""
        try:
            return replace(self, data=_in_floats(self.data))
        except RecursionError as error:
            raise _too_deep(self.path) from error

    def error(self, field: str, problem: str, *, beside: str = "") -> ModelError:
        """Return (not raise) an error that names file, line if it can be found, and field.

        ``beside`` : a field or section whose line is named where the field itself is not there.
        """
        line = self._line_of(field) or (self._line_of(beside) if beside else None)
        location = f"{self.path}:{line}" if line else f"{self.path}"
        return ModelError(f"{location}: field {field!r}: {problem}")

    @contextmanager
    def at(self, field: str | Callable[[str], str]) -> Iterator[None]:
        """Put the field's place before the message of an error raised inside, if it has none.

        ``field`` : the field, or what tells it from the message.
        """
        try:
            yield
        except ModelError as error:
            text = str(error)
            if text.startswith(str(self.path)):
                raise  # a table's file, or an inner field: the place is there already
            raise self.error(field if isinstance(field, str) else field(text), text) from error

    def unit(self, field: str, text: str) -> Unit:
        """Return the unit of a text; the error names the field."""
        with self.at(field):
            return parse_unit(text)

    def si_unit(self, field: str, text: str) -> str:
        """Return the unit of an expression's value; ModelError if it is not SI."""
        unit = self.unit(field, text)
        if not unit.is_si:
            raise self.error(
                field, f"{text!r} was given, but expressions have SI values; write {unit.si!r}"
            )
        return unit.si

    def _line_of(self, field: str) -> int | None:
        """Return the line where ``section.key`` is set, or its section begins."""
        section, _, key = field.rpartition(".")
        current, header_line = "", None
        for number, line in enumerate(self.text.splitlines(), start=1):
            header = re.match(r"\s*\[+\s*([^\]]+?)\s*\]+", line)
            if header:
                current = header.group(1)
                if current == section or current == field:
                    header_line = header_line or number
            elif current == section and re.match(rf"\s*\"?{re.escape(key)}\"?\s*[=.]", line):
                return number
        if header_line is None and "." in section:
            return self._line_of(section)
        return header_line


def read_text(path: Path) -> str:
    """Return a UTF-8 text file's content; ModelError says why it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise ModelError(f"{path}: no such file; check the path") from error
    except IsADirectoryError as error:
        raise ModelError(f"{path}: is a folder; name the file in it") from error
    except UnicodeDecodeError as error:
        raise ModelError(
            f"{path}: is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from error
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror})") from error


def _too_deep(path: Path) -> ModelError:
    return ModelError(f"{path}: nested deeper than any model file; check its brackets and dots")


def _in_floats(value: Any) -> Any:
    if isinstance(value, Decimal):
        return float(value)
    if isinstance(value, dict):
        return {key: _in_floats(inner) for key, inner in value.items()}
    return [_in_floats(inner) for inner in value] if isinstance(value, list) else value


def decimal_of(text: str) -> Decimal:
    """Return every digit of a number; where its exponent is beyond decimals, its float."""
    try:
        return Decimal(text)
    except InvalidOperation:
        return Decimal(float(text))


def read_document(path: Path, *, parse_float: Callable[[str], Any] = float) -> Document:
    """Return the parsed file; ``parse_float=decimal_of`` keeps every digit of a number.

    Raises
    ------
    ModelError : the file cannot be read, or is not TOML (the message has line and column).
    """
    text = read_text(path)
    try:
        return Document(path, text, tomllib.loads(text, parse_float=parse_float))
    except RecursionError as error:
        raise _too_deep(path) from error
    except tomllib.TOMLDecodeError as error:
        match = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        location = f"{path}:{match.group(1)}:{match.group(2)}" if match else f"{path}"
        if text.lstrip().startswith("{"):
            raise ModelError(f"{path}: {_of_json(text)}") from error
        raise ModelError(
            f"{location}: not valid TOML: {error}; expected lines such as "
            'key = { value = 1.0, unit = "m", source = "..." }'
        ) from error


def _of_json(text: str) -> str:
    """Return what a JSON file probably is, and where it is to be given."""
    if "takagi-gains" in text:
        return (
            "this is a gain file, and a model is needed: give the model's TOML file, or the name "
            "of a built-in model, and the gain file behind --gains"
        )
    if '"claims"' in text:
        return (
            "this is a certificate, and a model is needed: give the model's TOML file, or the name "
            "of a built-in model; 'takagi check' reads certificates"
        )
    return "this is JSON, and a model file is TOML, with lines such as x = { range = [-1, 1] }"


def data_folder() -> Path:
    """Return the folder with the package's model files."""
    return Path(__file__).parents[1] / "data"


@lru_cache(maxsize=1)
def _tables() -> dict[str, dict[str, Any]]:
    return {path.stem: read_document(path).data for path in sorted(data_folder().glob("*.toml"))}


def built_in_kinds() -> dict[str, str]:
    """Return name -> ``"turbine"`` or ``"plant"`` of every built-in model."""
    return {name: str(data["kind"]) for name, data in _tables().items()}


def built_in_models() -> list[tuple[str, str]]:
    """Return (name, one-line description) of every built-in model, sorted by name."""
    return [
        (name, str(data.get("description", data.get("name", name))))
        for name, data in _tables().items()
    ]


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
        "plant": "states inputs disturbances scheduling parameters tables equations mass outputs "
        "premises blending",
        "turbine": "rotor drivetrain generator pitch tower operation coefficients frozen_wake "
        "baseline",
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
        kind: [name for name in document.data if name in sections.split()]
        for kind, sections in _SECTIONS.items()
    }
    kind = max(own_sections, key=lambda candidate: len(own_sections[candidate]))
    if not own_sections[kind]:
        return ""
    section_names = ", ".join(f"[{name}]" for name in own_sections[kind][:3])
    belongs = "belongs" if len(own_sections[kind]) == 1 else "belong"
    return f'. {section_names} {belongs} to a {kind}: write kind = "{kind}"'
