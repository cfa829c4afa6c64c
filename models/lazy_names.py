"""The public names of a package, each imported when it is first used (PEP 562)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module


def lazy_names(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package with the names that it offers.

    Each name is listed once in the package's ``__init__``, with the module that it is in:

        if TYPE_CHECKING:
            from takagi.models.plant.plant import Plant as Plant

    ``as Plant`` makes the name public for type checkers.  At run time these imports are read, as
    text, when the first name is asked for; ``__all__`` is made of them.
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
            if alias.asname
        }

    def look_up(name: str) -> object:
        if name == "__all__":
            return sorted(modules())
        # Python itself asks for names with two underscores; none of them is offered.
        if not name.startswith("__") and name in modules():
            return getattr(import_module(modules()[name]), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return look_up, lambda: sorted(modules())
