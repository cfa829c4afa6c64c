"""Long lists of arguments are values: few parameters for a function, few positions in a call."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.syntax import Syntax, syntax

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ("models", "lmi", "certificates", "reports", "cli")
MOST_PARAMETERS = 10
MOST_POSITIONS = 8
MOST_FIELDS = 12
# What users type, by keyword: each makes one value of its arguments, or is documented one by one.
DOORS = {
    "models/sector/model.py": {"sector_model"},
    "models/sector/assembly.py": {"assemble"},
    "models/ts/model.py": {"__init__"},
    "lmi/gains/decay/pdc.py": {"pdc"},
    "lmi/gains/decay/relaxation_table.py": {"relaxation_ladder"},
    "lmi/gains/disturbance/energy_gain.py": {"hinf_pdc"},
    "lmi/gains/disturbance/peak_gain.py": {"peak_pdc"},
    "lmi/gains/structured/design.py": {"structured_pdc"},
    "lmi/gains/attraction/design.py": {"attraction_ellipsoid", "attraction_pdc"},
    "lmi/varying/varying_memberships.py": {"fuzzy_lyapunov"},
}


def sources(floor: str) -> list[tuple[str, Syntax]]:
    """Return (path, syntax) of every module of a floor."""
    return [
        (path.relative_to(ROOT).as_posix(), syntax(path))
        for path in sorted((ROOT / floor).rglob("*.py"))
    ]


@pytest.mark.parametrize("floor", FLOORS)
def test_a_function_has_few_parameters(floor: str) -> None:
    long = [
        f"{path}: {name} has {count} parameters"
        for path, source in sources(floor)
        for name, count in source.functions
        if count > MOST_PARAMETERS and name not in DOORS.get(path, set())
    ]

    assert long == []


@pytest.mark.parametrize("floor", FLOORS)
def test_a_call_passes_few_arguments_by_position(floor: str) -> None:
    long = [
        f"{path}:{line}: {ast.unparse(called)} is given {count} by position"
        for path, source in sources(floor)
        for line, called, count in source.calls
        if count > MOST_POSITIONS
    ]

    assert long == []


@pytest.mark.parametrize("floor", FLOORS)
def test_a_value_of_many_fields_takes_them_by_keyword(floor: str) -> None:
    """A named tuple of numbers for compiled code cannot, and is left out."""
    long = [
        f"{path}: {name} takes {count} fields by position"
        for path, source in sources(floor)
        for name, count in source.classes
        if count > MOST_FIELDS
    ]

    assert long == []


def test_every_door_is_there_and_needs_to_be_named() -> None:
    """A door that has become short is no exception any more."""
    for path, names in DOORS.items():
        counts = dict(syntax(ROOT / path).functions)
        assert all(counts.get(name, 0) > MOST_PARAMETERS for name in names), path
