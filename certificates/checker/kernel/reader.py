"""A strict JSON reader for untrusted certificates.

Numbers are kept as the text in the file, so that a proof is about the emitted decimals.
Duplicate keys, non-finite numbers, huge numbers, deep nesting and large files are refused.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import CertificateError

LARGEST_FILE = 16_000_000
DEEPEST, MOST_PARTS, MOST_CLAIMS = 40, 2_000_000, 200
LONGEST_NUMBER, LARGEST_EXPONENT = 60, 40
# Exact elimination of larger matrices would take minutes.
LARGEST_MATRIX = 80
# Strings are skipped as a whole, so brackets inside them do not change the depth. The possessive
# repeat prevents a second attempt at a string without an end.
STRING_OR_BRACKET = re.compile(r'"(?:[^"\\]|\\.)*+"?|[\[{]|[\]}]', re.DOTALL)


class Number(str):
    """A number as the text in the file."""

    __slots__ = ()


def read_json(path: Path) -> dict[str, Any]:
    """Return the object in a file; numbers are ``Number``.

    Raises
    ------
    CertificateError : unreadable, too large, not strict JSON, or not an object.
    """
    try:
        if path.exists() and not path.is_file():  # Reading a pipe may block forever.
            raise CertificateError(f"{path}: a folder, pipe or device; a plain file is needed")
        with path.open("rb") as file:
            # One byte more than allowed: a larger file is recognised, and never read as a whole.
            written = file.read(LARGEST_FILE + 1).decode("utf-8")
    except OSError as error:
        raise CertificateError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise CertificateError(f"{path}: not UTF-8: {error}") from error
    return read_text(written, str(path))


def read_text(written: str, source: str) -> dict[str, Any]:
    """Return the object in a text; see ``read_json``."""
    if len(written) > LARGEST_FILE:
        raise CertificateError(f"{source}: larger than {LARGEST_FILE} bytes; no certificate is")
    _check_size(written, source)
    try:
        value = json.loads(
            written,
            parse_float=_literal,
            parse_int=_literal,
            parse_constant=_literal,
            object_pairs_hook=_object,
        )
    except CertificateError as error:
        # Imported here: only a refused file needs the search for its entry.
        from takagi.certificates.checker.kernel.refused_entry import place

        raise CertificateError(f"{source}: {place(written, error, _literal)}{error}") from error
    except (json.JSONDecodeError, RecursionError) as error:
        raise CertificateError(f"{source}: not JSON: {error}") from error
    if not isinstance(value, dict):
        raise CertificateError(f"{source}: an object is needed at the top")
    return value


def _check_size(written: str, source: str) -> None:
    """Refuse deep nesting and too many parts before any object is created."""
    if sum(map(written.count, ",[{")) > MOST_PARTS:
        raise CertificateError(f"{source}: over {MOST_PARTS} entries; no certificate has so many")
    depth = 0
    for token in STRING_OR_BRACKET.finditer(written):
        depth += (token[0] in "[{") - (token[0] in "]}")
        if depth > DEEPEST:
            raise CertificateError(f"{source}: nested deeper than {DEEPEST}")


def _literal(written: str) -> Number:
    if not written[-1].isdigit():  # Python's reader accepts such numbers, JSON does not.
        raise CertificateError(f"{written} is not a number; a finite decimal is needed")
    if len(written) > LONGEST_NUMBER:
        raise CertificateError(f"a number of {len(written)} characters; at most {LONGEST_NUMBER}")
    _, _, exponent = written.lower().partition("e")
    if exponent and abs(int(exponent)) > LARGEST_EXPONENT:
        raise CertificateError(f"number {written}: exponents go to {LARGEST_EXPONENT}")
    return Number(written)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members: dict[str, Any] = {}
    for key, value in pairs:
        # JSON readers differ in which duplicate they keep, so one file could mean two things.
        if key in members:
            raise CertificateError(f"key {key!r} appears twice in one object")
        members[key] = value
    return members


def canonical(value: Any) -> str:
    """Return one text for one value: sorted keys, no space, numbers as they were written."""
    if isinstance(value, Number):
        return value
    if isinstance(value, dict):
        return "{" + ",".join(f"{json.dumps(k)}:{canonical(value[k])}" for k in sorted(value)) + "}"
    if isinstance(value, list):
        return f"[{','.join(map(canonical, value))}]"
    return json.dumps(value)


def digest(value: Any) -> str:
    """Return the SHA-256 of the canonical text."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def member(owner: Any, key: str, where: str) -> Any:
    """Return owner[key]; if it is missing, the error names the place."""
    if not isinstance(owner, dict) or key not in owner:
        raise CertificateError(f"{where}: {key!r} is missing; `takagi certify` writes one anew")
    return owner[key]


def text(owner: Any, key: str, where: str) -> str:
    """Return one line of text; refuses characters that a terminal does not print."""
    value = member(owner, key, where)
    if not isinstance(value, str) or isinstance(value, Number) or not value.isprintable():
        raise CertificateError(f"{where}.{key}: one line of printable text is needed")
    return value


def number(owner: Any, key: str, where: str) -> Fraction:
    """Return a number exactly."""
    return _fraction(member(owner, key, where), f"{where}.{key}")


def positive(owner: Any, key: str, where: str) -> Fraction:
    """Return a number exactly; refuses one that is not positive."""
    value = number(owner, key, where)
    if value <= 0:
        raise CertificateError(f"{where}.{key}: a positive number is needed")
    return value


def integer(owner: Any, key: str, where: str) -> int:
    value = number(owner, key, where)
    if value.denominator != 1:
        raise CertificateError(f"{where}.{key}: a whole number is needed")
    return int(value)


def numbers(owner: Any, key: str, where: str, count: int | None = None) -> list[Fraction]:
    """Return a row of numbers exactly; ``count`` asks for that many."""
    return _row(member(owner, key, where), f"{where}.{key}", count)


def listed(owner: Any, key: str, where: str, shortest: int, longest: int) -> list[Any]:
    """Return a list with this number of entries of any type."""
    values = member(owner, key, where)
    if not isinstance(values, list) or not shortest <= len(values) <= longest:
        raise CertificateError(f"{where}.{key}: a list of {shortest} to {longest} is needed")
    return values


def matrix(owner: Any, key: str, where: str) -> list[list[Fraction]]:
    """Return a rectangular matrix of numbers exactly."""
    rows = member(owner, key, where)
    if not isinstance(rows, list) or not rows:
        raise CertificateError(f"{where}.{key}: rows of numbers are needed")
    first = _row(rows[0], f"{where}.{key}", None)
    return [first, *(_row(row, f"{where}.{key}", len(first)) for row in rows[1:])]


def read_matrix(owner: Any, key: str, where: str, shape: tuple[int, int] | None = None) -> Matrix:
    """Return a matrix of the file; ``shape`` asks for rows and columns."""
    rows = matrix(owner, key, where)
    size = len(rows), len(rows[0])
    if shape is not None and size != shape:
        raise CertificateError(f"{where}.{key}: {shape[0]} by {shape[1]} is needed, not {size}")
    if max(size) > LARGEST_MATRIX:
        raise CertificateError(
            f"{where}.{key}: matrices go to {LARGEST_MATRIX} by {LARGEST_MATRIX}"
        )
    return Matrix.of(rows)


def read_stack(owner: Any, key: str, where: str) -> tuple[Matrix, ...]:
    """Return a list of matrices, all of the first one's shape."""
    stack = member(owner, key, where)
    if not isinstance(stack, list) or not stack:
        raise CertificateError(f"{where}.{key}: a list of matrices is needed")
    first = read_matrix({"0": stack[0]}, "0", f"{where}.{key}")
    following = (read_matrix({f"{i}": M}, f"{i}", f"{where}.{key}", first.shape)
            for i, M in enumerate(stack[1:], start=1))  # fmt: skip
    return (first, *following)


def _row(values: Any, where: str, count: int | None) -> list[Fraction]:
    if not isinstance(values, list) or not values or (count is not None and len(values) != count):
        needed = "numbers" if count is None else f"{count} numbers"
        raise CertificateError(f"{where}: a row of {needed} is needed")
    return [_fraction(value, where) for value in values]


def _fraction(value: Any, where: str) -> Fraction:
    if not isinstance(value, Number):
        raise CertificateError(f"{where}: a number is needed, not {type(value).__name__}")
    # A decimal keeps every digit, and is read in a third of the time that a fraction takes.
    return Fraction(Decimal(value))


def increasing(values: Sequence[Fraction], where: str) -> None:
    """Refuse a row that does not strictly increase."""
    if any(b <= a for a, b in pairwise(values)):
        raise CertificateError(f"{where}: the numbers must increase")
