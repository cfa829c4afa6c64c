"""Finds the place in a file of an entry that the strict reader does not accept as a number.

The reader has no places while it reads.  Here a text that it has refused is read once more; what is
found stands in the message and decides nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from takagi.certificates.checker.kernel.refusal import CertificateError


class _Odd(NamedTuple):
    """Takes the place of an entry that is refused; ``why`` is the reader's message."""

    why: str


def place(written: str, error: CertificateError, literal: Callable[[str], object]) -> str:
    """Return e.g. ``law.K[0][1]: ``, the first entry that is refused with this error; "" for none.

    Parameters
    ----------
    literal : the reader's own function for a number, which refuses it.
    """

    def read(entry: str) -> _Odd | None:
        try:
            literal(entry)
        except CertificateError as refusal:
            return _Odd(str(refusal))
        return None

    try:
        value = json.loads(written, parse_float=read, parse_int=read, parse_constant=read)
    except ValueError:  # no JSON behind that entry
        return ""
    refused_path = next((path for path, odd in _odd(value, ()) if odd.why == str(error)), ())
    return f"{path_in_one_word(refused_path)}: " if refused_path else ""


def _odd(value: Any, path: EntryPath) -> Iterator[tuple[EntryPath, _Odd]]:
    if isinstance(value, _Odd):
        yield path, value
    elif isinstance(value, dict):
        for key, entry in value.items():
            yield from _odd(entry, (*path, key))
    elif isinstance(value, list):
        for k, entry in enumerate(value):
            yield from _odd(entry, (*path, k))


EntryPath = tuple[str | int, ...]


def path_in_one_word(path: EntryPath) -> str:
    """Return the keys from the top as one printable word, e.g. ``K[0][1]``."""
    words = (f"[{key}]" if isinstance(key, int) else f".{ascii(key)[1:-1]}" for key in path)
    return "".join(words).removeprefix(".")
