"""Names that users may still use although a better one has taken their place."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from takagi.models.errors import ModelError

P = ParamSpec("P")
R = TypeVar("R")


def warn_renamed(earlier: str, name: str, *, levels: int = 3) -> None:
    """Warn the user's line that a name has become another one.

    Parameters
    ----------
    earlier, name : as users write them, ``Answer.family`` and ``Answer.lyapunov_function``.
    levels : of calls between here and the user's line, plus one.
    """
    warnings.warn(f"{earlier} is now called {name}", DeprecationWarning, stacklevel=levels)


def renamed_keywords(**names: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that also takes keywords by their earlier names, and warns.

    Parameters
    ----------
    names : earlier name -> present name.

    The function then raises ModelError where one argument is given by both names.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def renamed(*args: P.args, **kwargs: P.kwargs) -> R:
            for earlier in names.keys() & kwargs.keys():
                name = names[earlier]
                if name in kwargs:
                    raise ModelError(
                        f"{function.__name__} was given {earlier} and {name}, which are one "
                        f"argument; leave {earlier} out"
                    )
                warn_renamed(f"{function.__name__}({earlier}=)", f"{name}=")
                kwargs[name] = kwargs.pop(earlier)
            return function(*args, **kwargs)

        return renamed

    return decorate
