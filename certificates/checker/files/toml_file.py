"""Reads a model's TOML file in bounded time, because the file is not trusted."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel.refusal import CertificateError

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
