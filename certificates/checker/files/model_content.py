"""The content of a model's TOML file and its tables, without layout and descriptions.

Comments, line ends, the order of keys, file names and texts under ``description`` and ``source``
are left out. Every number becomes the shortest decimal of its double, so 0.10, 0.1 and 1e-1 are
equal. A text that looks like a number is marked as a text.  A table is
the SHA-256 of its numbers.  A certificate holds the content of the file it was made from in
``model.model_file``.

Parts of it are compared by their meaning as well (``plant_file``, ``turbine_file``): these may be
written otherwise, with another unit or in another form.  All other parts have to be the same.
"""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Any

from takagi.certificates.checker.files.differences import (
    MOST_COUNTED,
    Difference,
    differences_between,
    listed,
)
from takagi.certificates.checker.kernel.refusal import CertificateError

WORDS = ("description", "source")
LARGEST_EXACT, LARGEST_TABLE = 2**53, 16_000_000
# The form of a number, date or time; a text of this form, or one marked already, is marked.
MARK = "text "
LIKE_A_NUMBER = re.compile(
    rf"{MARK}.*+"
    r"|-?(?:\d[\d.]*+(?:e[-+]\d++)?|0x[\da-f]++|inf|nan)"
    r"|\d[\d-]*+ ?[\d:.+-]*+",
    re.DOTALL,
)
# Keys of a plant file that ``plant_file`` compares by meaning, in sections of named entries.
VARIABLE_KEYS = ("unit", "range", "rest")
BY_NAME = {
    "states": VARIABLE_KEYS,
    "inputs": VARIABLE_KEYS,
    "disturbances": VARIABLE_KEYS,
    "scheduling": VARIABLE_KEYS,
    "parameters": ("unit", "value", "range"),
}
NUMBERS = ("value", "values", "range", "rest", "overlap", "rate")
FORMULAS = ("equations", "mass", "outputs")
# There every key is a name chosen by the user, and no text is a description.
NAMED_BY_THE_USER = (("equations",), ("premises",), ("mass",))
REFERENCE_KEYS = ("unit", "range", "follow")
EFFORT_KEYS = ("unit", "range", "rest", "overlap", "rate")
ACTUATOR_KEYS = ("effectiveness", "error")
# Figures of a turbine file that ``turbine_file`` computes the certificate's numbers from.
TURBINE_FIGURES = {
    ("rotor", "radius"),
    ("rotor", "air_density"),
    ("rotor", "inertia"),
    ("rotor", "rated_speed"),
    ("generator", "inertia"),
    ("drivetrain", "gear_ratio"),
    ("pitch", "time_constant"),
    ("pitch", "rate_limit"),
    ("pitch", "minimum"),
    ("pitch", "maximum"),
}
WAKE_COLUMNS = ("wind", "factor", "power_sensitivity")


class OtherModel(CertificateError):
    """The model file differs from the certificate, so the proofs are not about it."""


def model_content(path: Path) -> dict[str, Any]:
    """Return the content of the file, with each table as the SHA-256 of its numbers.

    Raises
    ------
    CertificateError : the file or a table of it cannot be read.
    """
    file = read_toml(path, float, what="model file")
    for owner, key in _tables(file):
        owner[key] = f"numbers with SHA-256 {_numbers_digest(inside_folder(path, owner[key]))}"
    try:
        content = _plain(file, ())
    except RecursionError as error:
        raise CertificateError(f"{path}: nested deeper than any model file") from error
    if not isinstance(content, dict):
        raise CertificateError(f"{path}: not a model file")
    return content


def content_differences(content: dict[str, Any], recorded: Any) -> list[Difference]:
    """Return where a file's content differs from the recorded one, up to a maximum number."""
    return list(islice(differences_between(content, recorded), MOST_COUNTED))


def beside_the_claims(change: Difference, content: dict[str, Any], model: Any, gains: Any) -> bool:
    """Return whether no comparison by meaning covers this difference."""
    of_a_plant = model.get("kind") == "plant"
    left_out = (change.first, change.second) in ((None, "-"), ("-", None))
    if left_out and of_a_plant and _is_unit(change.path):
        return False  # The content if no unit is written.
    if change.path[-1:] == ("unit",) and not _numbers_differ(
        _owner(content, change.path), _owner(model.get("model_file"), change.path)
    ):
        # Equal numbers may have another dimension, such as s instead of m.
        return True
    if of_a_plant:
        return not _of_a_plant(change)
    return not _of_a_turbine(change.path, model, gains)


def _owner(content: Any, path: tuple[str | int, ...]) -> dict[str, Any]:
    for key in path[:-1]:
        content = content.get(key) if isinstance(content, dict) else None
    return content if isinstance(content, dict) else {}


def _numbers_differ(first: dict[str, Any], second: dict[str, Any]) -> bool:
    return any(first.get(key) != second.get(key) for key in NUMBERS)


def told(path: Path, differences: Sequence[Difference], reason: str = "") -> str:
    """Return the fields in which a file differs from the certificate, with both values."""
    return (
        f"{path}: not the certificate's model: {listed(differences)}"
        f"{f' ({reason})' if reason else ''}; give the model of this certificate, or make a "
        "certificate of this one with 'takagi certify'"
    )


def inside_folder(path: Path, name: Any) -> Path:
    """Return a table's file; refuses a path outside the folder of the model's file."""
    relative = PurePosixPath(name) if isinstance(name, str) else PurePosixPath()
    plain = isinstance(name, str) and name.isprintable() and not set("\\:") & set(name)
    if not plain or not relative.name or relative.is_absolute() or ".." in relative.parts:
        raise CertificateError(f"{path}: {name!a} is not the name of a table in its folder")
    file = path.parent / relative
    try:
        within = file.resolve().is_relative_to(path.parent.resolve())
    except (OSError, RuntimeError) as error:
        raise CertificateError(f"{file}: cannot be read: {error}") from error
    if not within:
        raise CertificateError(f"{file}: is a link that leads out of the model's folder")
    return file


def _of_a_turbine(path: tuple[str | int, ...], model: Any, gains: Any) -> bool:
    if path[:2] in TURBINE_FIGURES:
        return True
    if path[:2] == ("generator", "torque_rate_limit"):
        return "torque_rate_limit" in model
    # Without this column in the law the wake is not compared.
    wake = isinstance(gains, dict) and "effectiveness_limit" in gains
    return wake and path[:2] in {("frozen_wake", column) for column in WAKE_COLUMNS}


def _is_unit(path: tuple[str | int, ...]) -> bool:
    """Return whether this place holds a unit of a plant file, which is optional."""
    match path:
        case ("tables", str(), "arguments", int(), "unit") | ("blending", "effort", "unit"):
            return True
        case (str(section), str(), "unit"):
            return section in BY_NAME or section in ("outputs", "tables", "reference")
    return False


def _of_a_plant(change: Difference) -> bool:
    match change.path:
        case ("sample_time",):
            return True
        case ("parameters", str()):  # An expression or a range alone, without fields.
            return change.first is not None and change.second is not None
        case ("parameters", str(), int()):
            return True
        case ("inputs", str(), "rest"):
            # Its equilibrium value may differ, if it holds the states at equilibrium.
            return False
        case (str(section), str(), str(key), *_) if section in BY_NAME:
            return key in BY_NAME[section]
        case (str(section), str(), *_) if section in FORMULAS:
            return (
                change.path[-1] != "unit" and change.first is not None and change.second is not None
            )
        case ("blending", "effort", str(key), *_):
            return key in EFFORT_KEYS
        case ("reference", str(), str(key), *_):
            return key in REFERENCE_KEYS
        case ("blending", "low" | "high", str(key)):
            return key in ACTUATOR_KEYS
    return False


def _plain(value: Any, path: tuple[str, ...]) -> Any:
    if isinstance(value, dict):
        return {
            key: _plain(entry, (*path, key))
            for key, entry in value.items()
            if not (_is_words(key, entry) and path[:1] not in NAMED_BY_THE_USER)
        }
    if isinstance(value, list):
        return [_plain(entry, path) for entry in value]
    if isinstance(value, str):
        marked = LIKE_A_NUMBER.fullmatch(value) and not _is_formula(path)
        return f"{MARK}{value}" if marked else value
    if isinstance(value, bool):
        return value
    if isinstance(value, int) and abs(value) > LARGEST_EXACT:
        return hex(value)
    return _decimal(value) if isinstance(value, int | float) else str(value)  # a date or a time


def _is_words(key: str, entry: Any) -> bool:
    return key in WORDS and isinstance(entry, str)


def _is_formula(path: tuple[str, ...]) -> bool:
    """Return whether a text there is compared by its meaning."""
    if path[0] == "blending":
        return path[-1] == "effectiveness"
    return path[0] in FORMULAS and path[-1] != "unit"


def _decimal(number: float) -> str:
    return repr(float(number)).removesuffix(".0")


def _tables(content: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str]]:
    """Yield each place that names the file of a table."""
    coefficients, tables = content.get("coefficients"), content.get("tables")
    if isinstance(coefficients, dict):
        for key, entry in coefficients.items():
            if not _is_words(key, entry):
                yield coefficients, key
    if isinstance(tables, dict):
        for entry in tables.values():
            if isinstance(entry, dict) and "file" in entry:
                yield entry, "file"


def _numbers_digest(path: Path) -> str:
    """Return the SHA-256 of a table's numbers, row by row; cells that are not numbers are empty."""
    try:
        lines = (
            file_content(path, what="table", largest=LARGEST_TABLE).decode("utf-8-sig").splitlines()
        )
    except UnicodeDecodeError as error:
        raise CertificateError(f"{path}: cannot be read: not UTF-8") from error
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    text = "\n".join(",".join(_cell(cell) for cell in row.split(",")) for row in rows)
    return hashlib.sha256(text.encode()).hexdigest()


def _cell(cell: str) -> str:
    try:
        return _decimal(float(cell))
    except ValueError:
        return ""


LARGEST_FILE = 4_000_000
# The time of the standard library's reader grows as the square of a dotted key's length.  The first
# group holds the start of a word, so that a long word is not tried from each of its letters.
LONG_KEY = re.compile(r"(?<![^\s.,=\[\]{}])(?:[^\s.,=\[\]{}]++\s*+\.\s*+){64}")


def file_content(path: Path, *, what: str = "model's file", largest: int = LARGEST_FILE) -> bytes:
    """Return a file's bytes, at most ``largest``.

    Raises
    ------
    CertificateError : it cannot be read, is no plain file, or too large.
    """
    try:
        if not path.is_file():
            raise CertificateError(f"{path}: cannot be read: not a file")
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except OSError as error:
        raise CertificateError(f"{path}: cannot be read: {error.strerror or error}") from error
    if len(data) > largest:
        raise CertificateError(f"{path}: larger than {largest} bytes; no {what} is")
    return data


def read_toml(path: Path, parse_float: Callable[[str], Any], *, what: str) -> dict[str, Any]:
    """Return what a TOML file says.

    Parameters
    ----------
    parse_float : makes a number of a decimal; a ValueError refuses the file.
    what : the file is, for messages: ``"plant file"``.

    Raises
    ------
    CertificateError : it cannot be read, is too large, is not TOML, or would take too long.
    """
    data = file_content(path, what=what)
    try:
        text = data.decode("utf-8-sig")
        if LONG_KEY.search(text):
            raise ValueError("a key of more than 64 parts")
        return tomllib.loads(text, parse_float=parse_float)
    except (ValueError, ArithmeticError, RecursionError) as error:
        raise CertificateError(f"{path}: not a {what}: {error}") from error
