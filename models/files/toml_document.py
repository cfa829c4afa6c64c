"""A TOML file that can say where in it something is wrong."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from takagi.models.errors import ModelError


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

        Parameters
        ----------
        beside : a field or section whose line is named where the field itself is not there.
        """
        line = self._line_of(field) or (self._line_of(beside) if beside else None)
        location = f"{self.path}:{line}" if line else f"{self.path}"
        return ModelError(f"{location}: field {field!r}: {problem}")

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
