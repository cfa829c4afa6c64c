"""Types of arrays, numba for loops over them, and a short ``repr`` of what holds them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from html import escape
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]
Indices: TypeAlias = NDArray[np.intp]
Places: TypeAlias = NDArray[np.int64]
_Function = TypeVar("_Function", bound=Callable[..., Any])


def compiled(function: _Function) -> _Function:
    """Return a function compiled at its first call, kept on disk where there is a place for it.

    Numba keeps it beside the function's file, in the user's cache folder if that cannot be
    written, or where NUMBA_CACHE_DIR says; with no place at all every process compiles anew.  It
    knows a stored function by the date of its file, so compiled functions must not call those of
    another file.  It runs without the interpreter's lock, so that threads work side by side.
    """
    import numba

    try:
        compiled_function = numba.njit(cache=True, error_model="numpy", nogil=True)(function)
    except RuntimeError:
        compiled_function = numba.njit(error_model="numpy", nogil=True)(function)
    return cast(_Function, compiled_function)


def frozen(owner: object, name: str) -> Floats:
    """Return a member of a frozen dataclass as a read-only array, which it is from now on."""
    array = np.array(getattr(owner, name), dtype=np.float64)
    array.flags.writeable = False
    object.__setattr__(owner, name, array)
    return array


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
