"""Names that are valid in a target's language."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

from takagi.models.errors import ModelError

LONGEST = 63  # characters that C99 promises to tell apart


def identifiers(
    names: Iterable[str], reserved: Collection[str], *, language: str, ignore_case: bool = False
) -> dict[str, str]:
    """Return a valid identifier for each name: the name itself, with ``_`` added if it is in use.

    Parameters
    ----------
    reserved : keywords and functions of the language, in lower case if case is ignored.
    language : its name, for the message.
    ignore_case : whether ``K`` and ``k`` are the same name in the language.

    Raises
    ------
    ModelError : a name that is too long for the language.
    """
    found: dict[str, str] = {}
    taken = {word.lower() if ignore_case else word for word in reserved}
    for name in dict.fromkeys(names):
        word = re.sub(r"\W", "_", name, flags=re.ASCII)
        while (word.lower() if ignore_case else word) in taken:
            word += "_"
        if len(word) > LONGEST:
            raise ModelError(
                f"name {name!r} has {len(word)} characters; {language} holds {LONGEST}: shorten it "
                "in the model file and design again"
            )
        taken.add(word.lower() if ignore_case else word)
        found[name] = word
    return found


def file_word(name: str) -> str:
    """Return a model's name as one word for files and identifiers: ``NREL 5-MW`` is nrel_5_mw."""
    word = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    if not word:
        return "controller"
    return f"law_{word}" if word[0].isdigit() else word
