"""What the checker's functions return at chosen places, to the last digit.

``<room>.txt`` holds expressions, each with its value below it, in sections with a heading.  The
values are bounds that are rounded outward, refusals and whole sentences: what is pinned is how the
checker computes, not that it is right.  That it is right, other tests show: against mpmath, against
sampled points, by forged certificates.  Where a value differs, a proof is worth something else than
before: a bound has become wider or narrower, something else is refused, a sentence says more.

``python -m tests.certificates.pinned.pins`` writes the values of today, for one more expression
too.  A line that differs then is to be read before it is committed.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from takagi.certificates import CertificateError, Claim
from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.exponential import FINE
from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.result import Found
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.saying import in_words
from tests.certificates.pinned import loops, shapes, texts

FOLDER = Path(__file__).parent
CHECKER = "takagi.certificates.checker"
INDENT = "    "
ROOMS = ("arithmetic", "kernel", "kinds", "plant", "replay", "words")
# What was found of these is pinned by its values; ``words.txt`` has their sentences.
AS_VALUES = ("decay", "box_enlargement", "own_matrices")


class Section(NamedTuple):
    """A heading, and expressions with their values as text."""

    heading: str
    pins: list[tuple[str, str]]


def rooms() -> list[str]:
    """Return the rooms of the checker that have pins."""
    return sorted(path.stem for path in FOLDER.glob("*.txt"))


def sections(room: str) -> Iterator[Section]:
    """Yield the sections of a room; a value that is not written yet is empty."""
    found: Section | None = None
    for line in (FOLDER / f"{room}.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            if found:
                yield found
            found = Section(line.removeprefix("# "), [])
        elif line and found and not line.startswith(INDENT):
            found.pins.append((line, ""))
        elif line and found:
            found.pins[-1] = (found.pins[-1][0], line.removeprefix(INDENT))
    if found:
        yield found


def value(expression: str) -> str:
    """Return the value of an expression as text, or the refusal that it ends with."""
    try:
        return _text(eval(expression, _NAMES))
    except CertificateError as error:
        words = str(error)
    except ValueError as error:
        # Rows of different lengths, which ``zip`` refuses.
        return type(error).__name__
    # What json says behind this differs between versions of Python.
    head, mark, _ = words.partition("not JSON:")
    return f"refused: {head}{mark}"


def _text(found: Any) -> str:
    """Return a value in one line; sets in order, a generator as a list, a claim in short."""
    if isinstance(found, Found) and found.words not in AS_VALUES:
        found = in_words(found)
    if isinstance(found, Claim):
        return f"{found.verdict.name} {found.name!r}: {found.text}"
    if isinstance(found, (set, frozenset)):
        return f"{{{', '.join(sorted(map(_text, found)))}}}"
    if isinstance(found, Iterator):
        return f"[{', '.join(map(_text, found))}]"
    return repr(found).replace("\n", "\\n")


class _Room:
    """The modules of a room by name, imported when they are asked for."""

    def __init__(self, room: str) -> None:
        self._room = room

    def __getattr__(self, name: str) -> Any:
        found = importlib.import_module(f"{CHECKER}.{self._room}.{name}")
        return _Room(f"{self._room}.{name}") if hasattr(found, "__path__") else found


_NAMES: dict[str, Any] = {
    **{name: getattr(shapes, name) for name in shapes.__all__},
    **{name: getattr(texts, name) for name in texts.__all__},
    **{name: getattr(loops, name) for name in loops.__all__},
    **{room: _Room(room) for room in ROOMS},
    # ``loop`` is a function of the pins.
    "closed_loop": _Room("loop"),
    "Dual": Dual,
    "F": Fraction,
    "FINE": FINE,
    "PolytopicLoop": PolytopicLoop,
    "I": Interval,
    "Matrix": Matrix,
    "ONE": ONE,
    "replace": replace,
}


def written(room: str, of: Callable[[str], str] = value) -> str:
    """Return the text of a room's file with the values of today."""
    blocks = []
    for section in sections(room):
        lines = [f"# {section.heading}"]
        for expression, _ in section.pins:
            lines += [expression, INDENT + of(expression)]
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks) + "\n"


def main() -> None:
    """Write the values of today."""
    for room in rooms():
        text = written(room)
        (FOLDER / f"{room}.txt").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
