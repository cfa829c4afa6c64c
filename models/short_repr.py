"""Short texts of large values: one line for a console, a table for a notebook."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from html import escape
from typing import Any

MOST_MEMBERS, LONGEST = 8, 40
# Members and properties that stand first where a class has them.
FIRST = ("name", "status", "verdict_words", "verdict")


class ShortRepr:
    """The base of dataclasses (``repr=False``) whose members are arrays, tables or long lists.

    ``repr`` is one line with the first members in short; ``_repr_html_`` is a table of all that
    are not empty, which notebooks show.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        members = [f"{name}={text}" for name, text in self._shown()]
        further = [f"and {len(members) - MOST_MEMBERS} more"] if len(members) > MOST_MEMBERS else []
        return f"{type(self).__name__}({', '.join([*members[:MOST_MEMBERS], *further])})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, text in self._shown()
        )
        return f"<table><caption>{type(self).__name__}</caption>{rows}</table>"

    def _shown(self) -> Iterator[tuple[str, str]]:
        field_names = [member.name for member in fields(self)]  # type: ignore[arg-type]
        for name in dict.fromkeys((*FIRST, *field_names)):
            value = getattr(self, name, None)
            if value is None or (isinstance(value, Collection) and not len(value)):
                continue
            yield name, _short(value)


def _short(value: Any) -> str:
    shape = getattr(value, "shape", None)
    if shape:
        return f"<array {' x '.join(map(str, shape))}>"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float | Fraction):
        return f"{float(value):.6g}"
    if is_dataclass(value):
        name = getattr(value, "name", "")
        return f"<{type(value).__name__}{f' {name}' if name else ''}>"
    text = "" if isinstance(value, Mapping) else repr(value)
    if (
        isinstance(value, Collection)
        and not isinstance(value, str)
        and not 0 < len(text) <= LONGEST
    ):
        return f"<{len(value)} {'entry' if len(value) == 1 else 'entries'}>"
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
