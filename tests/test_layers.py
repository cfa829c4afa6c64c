"""What is loaded: by the checker the standard library, by floors and fast verbs nothing heavy.

The order of the floors is a contract of import-linter (``make layers``).
"""

from __future__ import annotations

import subprocess
import sys

import pytest

FLOORS = ["models", "lmi", "certificates", "reports", "cli"]
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
    """`takagi check` must run where only the standard library can be trusted.

    Help of either loads no makers of designs, and no checker.
    """
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
    """sympy is needed for derivations only."""
    assert "sympy" not in loaded_by("from takagi.models import TSModel; TSModel([[[1.0]]])")


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
