"""Every public name of an earlier version still works, and warns with the present one."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ("models", "lmi", "certificates", "reports", "cli")


def earlier_names() -> list[tuple[str, str, str]]:
    """Return (package, earlier name, present name) of all packages."""
    found = []
    for floor in FLOORS:
        for path in sorted((ROOT / floor).rglob("__init__.py")):
            package = ".".join(("takagi", *path.parent.relative_to(ROOT).parts))
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and ast.unparse(node.func) == "lazy_names":
                    for given in node.keywords:
                        found.append((package, str(given.arg), ast.literal_eval(given.value)))
    return found


@pytest.mark.parametrize(("package", "earlier", "name"), earlier_names())
def test_it_is_the_present_one_and_warns(package: str, earlier: str, name: str) -> None:
    module = importlib.import_module(package)

    with pytest.warns(
        DeprecationWarning, match=f"{package}.{earlier} is now called {package}.{name}"
    ):
        assert getattr(module, earlier) is getattr(module, name)
    assert name in dir(module) and earlier not in dir(module)


def test_there_are_some() -> None:
    assert ("takagi.models.laws", "CoherentLaw", "EffortSharingLaw") in earlier_names()
