"""The path from the top of a file to one entry, as text without spaces."""

from __future__ import annotations

EntryPath = tuple[str | int, ...]


def path_in_one_word(path: EntryPath) -> str:
    """Return the keys from the top as one printable word, e.g. ``K[0][1]``."""
    words = (f"[{key}]" if isinstance(key, int) else f".{ascii(key)[1:-1]}" for key in path)
    return "".join(words).removeprefix(".")
