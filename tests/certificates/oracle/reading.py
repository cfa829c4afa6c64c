"""Members of a claim as exact numbers and matrices of FLINT.

The text is read, and its limits are kept, by the checker's reader: numbers are its ``Number``.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.checker.kernel.reader import Number

WIDEST = 128  # rows and columns of a matrix


class Refusal(ValueError):
    """A part of the claim is missing, or does not fit."""


def entry(owner: Any, key: str) -> Any:
    """Return owner[key].

    Raises
    ------
    Refusal : ``owner`` is no object, or has no such key.
    """
    if not isinstance(owner, dict) or key not in owner:
        raise Refusal(f"{key!r} is missing")
    return owner[key]


def rational(owner: Any, key: str) -> fmpq:
    """Return the number owner[key] exactly."""
    return _rational(entry(owner, key), key)


def integer(owner: Any, key: str) -> int:
    """Return the whole number owner[key]."""
    number = rational(owner, key)
    if number.q != 1:
        raise Refusal(f"{key}: a whole number is needed")
    return int(number.p)


def _rational(value: Any, key: str) -> fmpq:
    if not isinstance(value, Number):
        raise Refusal(f"{key}: a number is needed")
    return fmpq(*Decimal(value).as_integer_ratio())


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
    matrix_rows: Sequence[list[fmpq]] = [rational_row(row, key, width) for row in rows]
    if shape not in (None, (len(rows), width)) or max(len(rows), width) > WIDEST:
        raise Refusal(f"{key}: {shape or 'a smaller matrix'} is needed")
    return fmpq_mat(matrix_rows)
