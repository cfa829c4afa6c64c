"""Reserved names of C and C++, comments, and the helper functions that a law may need."""

from __future__ import annotations

import re
from collections.abc import Collection
from importlib.resources import files

from takagi.reports.code.controller_program import reserved_words

# Keywords of C11 and C++20, names of <math.h>, macros of common compilers and systems, and names
# that the generated files use themselves.
RESERVED = reserved_words("c")
_HEADERS = reserved_words("c-headers")


def _read_helpers() -> dict[str, str]:
    text = (files("takagi.reports.code.c") / "helpers.c").read_text(encoding="utf-8")
    return {_CALLED.findall(helper)[0]: helper.strip() for helper in text.split("\n\n")}


_CALLED = re.compile(r"@(\w+)\(")
# Helper -> its text.  In a text @ means the prefix, REAL the type, and ZERO and ONE the numbers in
# that type.  A helper comes after those that it calls.
HELPERS = _read_helpers()


def helpers(used: Collection[str], prefix: str, real: str, suffix: str) -> str:
    """Return the text of the used helpers and of those that they call, in the order of C."""
    needed: set[str] = set()
    waiting = list(used)
    while waiting:
        helper = waiting.pop()
        if helper not in needed:
            needed.add(helper)
            waiting += _CALLED.findall(HELPERS[helper])
    words = {"REAL": real, "ONE": f"1.0{suffix}", "ZERO": f"0.0{suffix}"}
    text = "".join(f"\n{body}\n" for name, body in HELPERS.items() if name in needed)
    text = re.sub(r"\b(REAL|ONE|ZERO)\b", lambda match: words[match[1]], text)
    return text.replace("@", prefix)


def comment(text: str) -> str:
    """Return a text that is safe inside a comment or string of C: one line of ASCII."""
    plain = " ".join(text.split()).encode("ascii", "replace").decode("ascii")
    # First the backslashes: a slash in their place may end a comment.
    plain = plain.replace("\\", "/").replace('"', "'")
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def file_name_word(word: str) -> str:
    """Return a word W such that ``W.h`` has not the name of a standard header."""
    return f"law_{word}" if word in _HEADERS or word in RESERVED else word
