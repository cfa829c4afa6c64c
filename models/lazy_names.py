"""The public names of a package, each imported when it is first used (PEP 562)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module


def lazy_names(
    package: str, names: Sequence[str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package whose ``__all__`` is ``names``.

    The module of each name stands once: in the imports for type checkers, which the package's
    ``__init__`` has under ``if TYPE_CHECKING``.  They are read when the first name is asked for.
    """

    @cache
    def modules() -> dict[str, str]:
        import ast
        from pkgutil import get_data

        return {
            alias.name: str(statement.module)
            for block in ast.parse(get_data(package, "__init__.py") or b"").body
            if isinstance(block, ast.If)
            for statement in block.body
            if isinstance(statement, ast.ImportFrom)
            for alias in statement.names
        }

    def look_up(name: str) -> object:
        if name in names:
            return getattr(import_module(modules()[name]), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return look_up, lambda: sorted(names)
