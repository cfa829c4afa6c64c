"""What may import what: the floors, the checker's independence, and the fast verbs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.syntax import syntax

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ["models", "lmi", "certificates", "reports", "cli"]  # each may import those before it
CHECKER = "takagi.certificates.checker"
HEAVY = {
    "clarabel",
    "control",
    "cvxpy",
    "flint",
    "jinja2",
    "matplotlib",
    "numpy",
    "pydantic",
    "rich",
    "scipy",
    "sympy",
    "typer",
}


def imports(path: Path) -> Iterator[str]:
    """Yield the full name of every module that a file imports anywhere, also inside functions."""
    source = syntax(path)
    assert not source.relative, f"{path}: relative import"
    # `from takagi.lmi import pdc` may name a module or a member of the package.
    yield from (f"{module}.{name}" if name else module for module, name in source.imports)


def within(name: str, package: str) -> bool:
    """Whether a module is the package or lies in it."""
    return name == package or name.startswith(package + ".")


@pytest.mark.parametrize("floor", FLOORS)
def test_a_floor_imports_only_itself_and_those_below(floor: str) -> None:
    """cli -> reports -> certificates -> lmi -> models, and never upwards, not even lazily."""
    above = FLOORS[FLOORS.index(floor) + 1 :]

    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sorted((ROOT / floor).rglob("*.py"))
        for name in imports(path)
        if any(within(name, f"takagi.{other}") for other in above)
    ]

    assert wrong == []


def test_designs_reports_and_verbs_import_each_other_one_way() -> None:
    """No circle of modules, imports inside functions and for types counted."""
    rooms = ("certificates/design", "certificates/controller", "models/plant_files", *FLOORS[3:])
    modules = {
        "takagi." + ".".join(path.relative_to(ROOT).with_suffix("").parts): path
        for room in rooms
        for path in (ROOT / room).rglob("*.py")
        if path.name != "__init__.py"
    }
    named = {name: list(imports(path)) for name, path in modules.items()}
    graph = {
        name: {m for found in named[name] for m in (found, found.rpartition(".")[0])} & set(modules)
        for name in modules
    }

    assert len(list(TopologicalSorter(graph).static_order())) == len(modules)


def test_the_checker_imports_the_standard_library_alone() -> None:
    """What proves a certificate must not depend on anything that made it."""
    foreign = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sorted((ROOT / "certificates/checker").rglob("*.py"))
        for name in imports(path)
        if name.partition(".")[0] not in sys.stdlib_module_names and not within(name, CHECKER)
    ]

    assert foreign == []


def loaded_by(statement: str) -> set[str]:
    """The top-level names of the modules that a fresh interpreter has loaded after a statement."""
    report = "import sys; print('loaded:', *sorted({n.partition('.')[0] for n in sys.modules}))"
    ran = subprocess.run(
        [sys.executable, "-c", f"{statement}\n{report}"],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(ran.stdout.rpartition("loaded:")[2].split())


@pytest.mark.parametrize("arguments", [["--help"], ["check", "--help"], ["check", "no-such-file"]])
def test_the_fast_verbs_load_nothing_heavy(arguments: list[str]) -> None:
    """`takagi check` must run where only the standard library can be trusted."""
    loaded = loaded_by(f"from takagi.cli.main import main; main({arguments!r})")

    assert "takagi" in loaded
    assert loaded & HEAVY == set()


@pytest.mark.parametrize("floor", FLOORS)
def test_importing_a_floor_loads_nothing_heavy(floor: str) -> None:
    """Package `__init__`s are lazy (PEP 562): names are looked up when they are used."""
    assert loaded_by(f"import takagi.{floor}") & HEAVY == set()


@pytest.mark.parametrize("floor", FLOORS)
def test_every_promised_name_can_be_imported(floor: str) -> None:
    """A lazy `__init__` hides a misspelt module until somebody asks for it."""
    ran = subprocess.run(
        [sys.executable, "-c", f"from takagi.{floor} import *"],
        capture_output=True,
        text=True,
        check=False,
    )

    assert ran.returncode == 0, ran.stderr
