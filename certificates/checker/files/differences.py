"""Lists where two values of the strict reader differ, part by part."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from takagi.certificates.checker.kernel.reader import Number, canonical
from takagi.certificates.checker.kernel.refused_entry import EntryPath, path_in_one_word

LONGEST_TEXT, LEADING_CHARACTERS = 60, 20
# The number of differences that are reported, and that are counted.
MOST_TOLD, MOST_COUNTED = 3, 1000


class Difference(NamedTuple):
    """One part that differs: its path of keys and both values; None for a missing part."""

    path: EntryPath
    first: Any
    second: Any

    @property
    def place(self) -> str:
        """The path as printable text, e.g. ``K[0][1]``."""
        return path_in_one_word(self.path)


def differences_between(first: Any, second: Any, path: EntryPath = ()) -> Iterator[Difference]:
    """Yield the smallest parts that differ; numbers are compared by value, 1.0 equals 1.

    Lists of different length differ as a whole.
    """
    if isinstance(first, dict) and isinstance(second, dict):
        for key in (*first, *(key for key in second if key not in first)):
            yield from differences_between(first.get(key), second.get(key), (*path, key))
    elif isinstance(first, list) and isinstance(second, list) and len(first) == len(second):
        for k, (first_entry, second_entry) in enumerate(zip(first, second, strict=True)):
            yield from differences_between(first_entry, second_entry, (*path, k))
    elif not _same(first, second):
        yield Difference(path, first, second)


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, Number) and isinstance(second, Number):
        return Fraction(first) == Fraction(second)
    return canonical(first) == canonical(second)


def in_words(value: Any) -> str:
    """Return a value as one short printable text."""
    return _cut(_whole(value), 0)


def shown(change: Difference) -> tuple[str, str]:
    """Return both values as short printable texts; long ones are cut around the difference."""
    first, second = _whole(change.first), _whole(change.second)
    if first == second:
        # A text and a number with the same characters would look equal.
        first, second = (ascii(canonical(_plain(v)))[1:-1] for v in (change.first, change.second))
    shorter, longer = sorted((len(first), len(second)))
    same = next((k for k in range(shorter) if first[k] != second[k]), shorter)
    late = longer > LONGEST_TEXT and same >= LONGEST_TEXT - LEADING_CHARACTERS
    begin = same - LEADING_CHARACTERS if late else 0
    return _cut(first, begin), _cut(second, begin)


def listed(differences: Sequence[Difference], ours: str = "in the certificate") -> str:
    """Return the first differences with both values, and how many there are beside."""
    descriptions = [
        f"{difference.place} is {first} there, {second} {ours}"
        for difference in differences[:MOST_TOLD]
        for first, second in [shown(difference)]
    ]
    omitted = len(differences) - MOST_TOLD
    counted = f"{omitted}" if len(differences) < MOST_COUNTED else f"at least {omitted}"
    return "; ".join(descriptions) + (f" (and {counted} more)" if omitted > 0 else "")


def _cut(text: str, begin: int) -> str:
    if begin == 0 and len(text) <= LONGEST_TEXT:
        return text
    end = begin + LONGEST_TEXT
    return f"{'...' * (begin > 0)}{text[begin:end]}{'...' * (len(text) > end)}"


def _whole(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, list) and len(value) > 3:
        return f"{len(value)} entries"
    return ascii(value if isinstance(value, str) else canonical(_plain(value)))[1:-1]


def _plain(value: Any) -> Any:
    """Return a value of a TOML file, with its decimals, dates and times as text."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return value if value is None or isinstance(value, (str, int)) else Number(str(value))
