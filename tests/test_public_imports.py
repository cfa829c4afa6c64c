"""Tests take names from the packages that offer them, so that a move inside a room leaves them."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from tests.syntax import syntax

TESTS = Path(__file__).parent
CHECKER = "takagi.certificates.checker."
# Names that tests take from modules inside a room.  The checker has its own number: it is tested
# from within, file by file, and its rooms offer nothing, because lists that only tests need would
# be more code to trust; it grows with the lines of the checker that a forged document or a formula
# written a second time looks at.  A new test elsewhere lowers the first or leaves it.
MOST_FROM_WITHIN, MOST_FROM_THE_CHECKER = 452, 623
# pyproject.toml names it as the program that is installed, so it is public where it is.
COMMAND = ("takagi.cli.main", "main")


def _inner_names() -> Iterator[tuple[Path, str, str]]:
    """Yield (file, module, name) of each name that a test imports from a module, not a package."""
    for path in sorted(TESTS.rglob("*.py")):
        for module, name in syntax(path).imports:
            if name and module.startswith("takagi.") and (module, name) != COMMAND:
                if not hasattr(import_module(module), "__path__"):
                    yield path, module, name


def _offered_by(module: str, name: str) -> str | None:
    """Return the highest package above the module that lists the same object, if one does."""
    parts = module.split(".")
    for depth in range(2, len(parts)):
        package = import_module(".".join(parts[:depth]))
        if name in getattr(package, "__all__", ()):
            if getattr(package, name) is getattr(import_module(module), name):
                return package.__name__
    return None


def test_a_name_is_taken_from_the_package_that_offers_it() -> None:
    wrong = [
        f"{path.relative_to(TESTS)}: take {name} from {offered}, not from {module}"
        for path, module, name in _inner_names()
        if (offered := _offered_by(module, name)) is not None
    ]

    assert not wrong, "\n".join(wrong)


def test_few_names_are_taken_from_within_a_room() -> None:
    """Where this fails: list the name in its room's ``__init__`` if others need it too."""
    checker = [module.startswith(CHECKER) for _, module, _ in _inner_names()]

    assert checker.count(False) <= MOST_FROM_WITHIN
    assert checker.count(True) <= MOST_FROM_THE_CHECKER
