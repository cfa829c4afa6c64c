"""What is loaded: by the checker the standard library, by floors and fast verbs nothing heavy."""

from __future__ import annotations

import subprocess
import sys
from collections import defaultdict
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.syntax import syntax

FLOORS = ("models", "lmi", "certificates", "reports", "cli")
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


def loaded_by(statement: str) -> set[str]:
    """The names of the modules that a fresh interpreter has loaded after a statement."""
    report = "import sys; print('loaded:', *sys.modules)"
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

    assert "takagi.cli.main" in loaded
    assert loaded & HEAVY == set()
    if "--help" in arguments:
        rooms = ("takagi.cli.runs", "takagi.cli.options", "takagi.certificates", "takagi.models")
        assert [name for name in loaded if name.startswith(rooms)] == []


@pytest.mark.parametrize("verb", ["design", "simulate", "certify", "report", "export", "compare"])
def test_help_of_a_verb_loads_no_numbers(verb: str) -> None:
    """Help is read before anything is computed: numpy alone would take longer than all of it."""
    loaded = loaded_by(f"from takagi.cli.main import main; main([{verb!r}, '--help'])")

    assert loaded & {"numpy", "scipy", "sympy", "clarabel", "matplotlib"} == set()


def test_using_a_vertex_model_does_not_import_sympy() -> None:
    assert "sympy" not in loaded_by("from takagi.models import TSModel; TSModel([[[1.0]]])")


@pytest.mark.parametrize("floor", FLOORS)
def test_importing_a_floor_loads_nothing_heavy(floor: str) -> None:
    """Package `__init__`s are lazy (PEP 562): names are looked up when they are used."""
    assert loaded_by(f"import takagi.{floor}") & HEAVY == set()


@pytest.mark.parametrize("floor", FLOORS)
def test_every_promised_name_can_be_imported(floor: str) -> None:
    """A lazy `__init__` hides a misspelt module until somebody asks for it."""
    exec(f"from takagi.{floor} import *", {})


ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("models", "lmi", "reports", "cli")  # whose folders are in no circle either

Graph = dict[str, set[str]]


def imports(root: Path, floor: str) -> dict[str, list[tuple[str, str]]]:
    """Return import name -> (module, name) of its imports; the name of ``import x`` is empty."""
    return {
        ".".join(["takagi", *path.relative_to(root).with_suffix("").parts]).removesuffix(
            ".__init__"
        ): [(module, name) for module, name in syntax(path).imports if module]
        for path in sorted((root / floor).rglob("*.py"))
    }


def home(module: str, name: str, packages: dict[str, dict[str, str]], known: set[str]) -> str:
    """Return the module that an import leads to, through what packages hand out."""
    if f"{module}.{name}" in known:
        return f"{module}.{name}"
    further = packages.get(module, {}).get(name)
    return module if further in (None, module) else home(str(further), name, packages, known)


def _dots(module: str) -> list[int]:
    return [place for place, letter in enumerate(module) if letter == "."]


def graph_of(root: Path, floor: str) -> Graph:
    """An import of what a package's ``__init__`` hands out is one of the module that has it."""
    named = imports(root, floor)
    holders = {module[:place] for module in named for place in _dots(module)}
    packages = {
        module: {name: source for source, name in found}
        for module, found in named.items()
        if module in holders
    }
    known = set(named)
    modules = known - packages.keys()
    return {
        module: {
            target
            for source, name in named[module]
            for target in [home(source, name, packages, known)]
            if target in modules and target != module
        }
        for module in sorted(modules)
    }


def rooms_of(graph: Graph) -> Graph:
    """Return the graph of what lies side by side in a folder: rooms, and modules beside them."""
    found: Graph = defaultdict(set)
    for module, targets in graph.items():
        for target in targets:
            here, there = module.split("."), target.split(".")
            depth = next(k for k, (a, b) in enumerate(zip(here, there, strict=False)) if a != b)
            found[".".join(here[: depth + 1])].add(".".join(there[: depth + 1]))
    return dict(found)


def circle(graph: Graph) -> str:
    """Return one circle of a graph, each of it imports the next; empty without one."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        # Its list goes from what is imported to what imports it.
        return " -> ".join(reversed(error.args[1]))
    return ""


@pytest.mark.parametrize("floor", FLOORS)
def test_no_module_leads_back_to_itself(floor: str) -> None:
    found = graph_of(ROOT, floor)

    assert len(found) > 10
    assert circle(found) == "", f"modules of {floor} import each other in a circle"


@pytest.mark.parametrize("floor", ROOMS)
def test_no_room_leads_back_to_itself(floor: str) -> None:
    found = circle(rooms_of(graph_of(ROOT, floor)))

    assert found == "", f"rooms of {floor} import each other in a circle"


@pytest.mark.parametrize(
    "back",
    [
        "from takagi.models.low.value import value",
        "def late():\n    from takagi.models.low import value\n",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import takagi.models.low.value",
    ],
    ids=["plain", "lazy, through the package", "for types"],
)
def test_a_circle_is_found_and_named(tmp_path: Path, back: str) -> None:
    files = {
        "low/__init__.py": "from takagi.models.low.value import value",
        "low/value.py": "from takagi.models.high.reader import read\nvalue = 1",
        "high/__init__.py": "",
        "high/reader.py": back,
    }
    for name, text in files.items():
        path = tmp_path / "models" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    graph = graph_of(tmp_path, "models")

    assert set(circle(graph).split(" -> ")) == {
        "takagi.models.low.value",
        "takagi.models.high.reader",
    }
    assert set(circle(rooms_of(graph)).split(" -> ")) == {"takagi.models.low", "takagi.models.high"}
