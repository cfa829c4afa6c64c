"""Where two values of the strict reader differ, part by part."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from takagi.certificates.checker.kernel.reader import Number, canonical

__all__ = ["Difference", "differing", "in_words"]

LONGEST = 60


class Difference(NamedTuple):
    """One part that is not the same: its keys from the top, and both values; None for no part."""

    path: tuple[str | int, ...]
    first: Any
    second: Any

    @property
    def place(self) -> str:
        """The path in one word, printable, e.g. ``K[0][1]``."""
        words = (
            f"[{key}]" if isinstance(key, int) else f".{ascii(key)[1:-1]}" for key in self.path
        )
        return "".join(words).removeprefix(".")


def differing(first: Any, second: Any, path: tuple[str | int, ...] = ()) -> Iterator[Difference]:
    """Yield the smallest parts that differ; numbers are compared by value, 1.0 equals 1.

    Lists of different length differ as a whole.
    """
    if isinstance(first, dict) and isinstance(second, dict):
        for key in (*first, *(key for key in second if key not in first)):
            yield from differing(first.get(key), second.get(key), (*path, key))
    elif isinstance(first, list) and isinstance(second, list) and len(first) == len(second):
        for k, (one, other) in enumerate(zip(first, second, strict=True)):
            yield from differing(one, other, (*path, k))
    elif not _same(first, second):
        yield Difference(path, first, second)


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, Number) and isinstance(second, Number):
        return Fraction(first) == Fraction(second)
    return canonical(first) == canonical(second)


def in_words(value: Any) -> str:
    """Return a value as one short printable text."""
    if value is None:
        return "nothing"
    if isinstance(value, list) and len(value) > 3:
        return f"{len(value)} entries"
    text = ascii(value if isinstance(value, str) else canonical(_plain(value)))[1:-1]
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _plain(value: Any) -> Any:
    """Return a value of a TOML file without its decimals, dates and times: these as text."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return value if value is None or isinstance(value, (str, int)) else Number(str(value))
