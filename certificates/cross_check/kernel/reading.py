"""A certificate file as plain data: numbers as the text they are written as, and exact rationals.

A file that is not strict JSON is refused.  So is a file in which a key stands twice in one object,
a number is not finite or is longer than any certificate needs, or brackets are nested deeper.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from flint import fmpq, fmpq_mat

# Limits against files that are made to exhaust memory or time.
MOST_BYTES, MOST_LEVELS = 20_000_000, 48
MOST_CHARACTERS, MOST_POWER = 64, 48
WIDEST = 128  # rows and columns of a matrix


class Refusal(ValueError):
    """The file is no certificate that can be read, or a part of it does not fit."""


class NotReplayed(Exception):
    """A step of a claim that this checker cannot decide; the claim may still be true."""


class Written(str):
    """The characters of a number, which differ from a text with the same characters.

    No number passes through a float: it becomes a rational directly from its decimals.
    """

    __slots__ = ()


def load(path: Path) -> dict[str, Any]:
    """Return the object in a file.

    Raises
    ------
    Refusal : it cannot be read, or is no strict JSON object.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise Refusal(f"{path}: more than {MOST_BYTES} bytes")
        return loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Refusal(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise Refusal(f"{path}: not UTF-8") from error


def loads(written: str) -> dict[str, Any]:
    """Return the object that a text holds; see ``load``."""
    if _levels(written) > MOST_LEVELS:
        raise Refusal(f"more than {MOST_LEVELS} brackets inside one another")
    try:
        found = json.loads(
            written,
            parse_int=_number,
            parse_float=_number,
            parse_constant=_number,
            object_pairs_hook=_unique,
        )
    except (ValueError, RecursionError) as error:
        raise Refusal(f"not strict JSON: {error}") from error
    if not isinstance(found, dict):
        raise Refusal("an object is needed at the top")
    return found


def _levels(written: str) -> int:
    """Return how deeply brackets are nested; brackets inside strings do not count.

    This is counted before ``json.loads``, whose recursion a deep file could overflow.
    """
    most = level = 0
    inside = escaped = False
    for c in written:
        if inside:
            if escaped:
                escaped = False
            elif c == "\\":
                escaped = True
            elif c == '"':
                inside = False
        elif c == '"':
            inside = True
        elif c in "[{":
            level += 1
            most = max(most, level)
        elif c in "]}":
            level -= 1
    return most


def _number(written: str) -> Written:
    power = written.lower().partition("e")[2]
    if len(written) > MOST_CHARACTERS or (power and abs(int(power)) > MOST_POWER):
        raise Refusal("a number with more digits than any certificate has")
    if written in ("NaN", "Infinity", "-Infinity"):
        raise Refusal(f"{written} is no number")
    return Written(written)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise Refusal("a key stands twice in one object")
    return found


def hashes(document: dict[str, Any]) -> dict[str, str]:
    """Return the SHA-256 of model, gains and claims, each written with sorted keys and no spaces.

    Numbers are written with the characters of the file, so that 1.0 and 1.00 have other hashes.
    """
    return {
        part: hashlib.sha256(_one_text(document.get(part)).encode()).hexdigest()
        for part in ("model", "gains", "claims")
    }


def hashes_differ(document: dict[str, Any]) -> str:
    """Return the first part whose hash is not the stated one; empty where all hashes agree."""
    stated = entry(entry(document, "provenance"), "sha256")
    for part, found in hashes(document).items():
        if entry(stated, part) != found:
            return part
    return ""


def _one_text(value: Any) -> str:
    if isinstance(value, Written):
        return str(value)
    if isinstance(value, list):
        return "[" + ",".join(map(_one_text, value)) + "]"
    if isinstance(value, dict):
        return "{" + ",".join(f"{json.dumps(k)}:{_one_text(value[k])}" for k in sorted(value)) + "}"
    return json.dumps(value)


def entry(owner: Any, key: str) -> Any:
    """Return owner[key].

    Raises
    ------
    Refusal : ``owner`` is no object, or has no such key.
    """
    if not isinstance(owner, dict) or key not in owner:
        raise Refusal(f"{key!r} is missing")
    return owner[key]


def line(owner: Any, key: str) -> str:
    """Return the text owner[key].

    Raises
    ------
    Refusal : it is not a text, or has characters that cannot be printed on one line.
    """
    found = entry(owner, key)
    if type(found) is not str or not found.isprintable():
        raise Refusal(f"{key}: a line of text is needed")
    return str(found)


def rational(owner: Any, key: str) -> fmpq:
    """Return the number owner[key] exactly."""
    return _rational(entry(owner, key), key)


def whole(owner: Any, key: str) -> int:
    """Return the whole number owner[key]."""
    found = rational(owner, key)
    if found.q != 1:
        raise Refusal(f"{key}: a whole number is needed")
    return int(found.p)


def _rational(value: Any, key: str) -> fmpq:
    if not isinstance(value, Written):
        raise Refusal(f"{key}: a number is needed")
    try:
        p, q = Decimal(value).as_integer_ratio()
    except InvalidOperation as error:
        raise Refusal(f"{key}: {value!a} is no number") from error
    return fmpq(p, q)


def rationals(owner: Any, key: str, count: int | None = None) -> list[fmpq]:
    """Return a row of numbers."""
    return rational_row(entry(owner, key), key, count)


def rational_row(row: Any, key: str, count: int | None = None) -> list[fmpq]:
    """Return a row of numbers; if ``count`` is given the row must have so many."""
    if not isinstance(row, list) or not row or count not in (None, len(row)):
        raise Refusal(f"{key}: a row of {count or 'some'} numbers is needed")
    return [_rational(value, key) for value in row]


def table(owner: Any, key: str, shape: tuple[int, int] | None = None) -> fmpq_mat:
    """Return a matrix; if ``shape`` is given the matrix must have it."""
    return _table(entry(owner, key), key, shape)


def stack(owner: Any, key: str) -> list[fmpq_mat]:
    """Return a list of matrices of one shape."""
    listed = entry(owner, key)
    if not isinstance(listed, list) or not listed:
        raise Refusal(f"{key}: a list of matrices is needed")
    first = _table(listed[0], key, None)
    shape = first.nrows(), first.ncols()
    return [first, *(_table(rows, key, shape) for rows in listed[1:])]


def _table(rows: Any, key: str, shape: tuple[int, int] | None) -> fmpq_mat:
    if not isinstance(rows, list) or not rows or not isinstance(rows[0], list):
        raise Refusal(f"{key}: rows of numbers are needed")
    width = len(rows[0])
    found: Sequence[list[fmpq]] = [rational_row(row, key, width) for row in rows]
    if shape not in (None, (len(rows), width)) or max(len(rows), width) > WIDEST:
        raise Refusal(f"{key}: {shape or 'a smaller matrix'} is needed")
    return fmpq_mat(found)
