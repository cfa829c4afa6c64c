"""Types of arrays, and numba for loops over them that would be slow in Python."""

from __future__ import annotations

from collections.abc import Callable
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
