"""Long lists of arguments are values: few parameters for a function, few positions in a call."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

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


def parameters(function: ast.FunctionDef) -> int:
    """Return how many parameters a caller may give."""
    named = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return sum(1 for one in named if one.arg not in ("self", "cls"))


def parsed(floor: str) -> list[tuple[str, ast.Module]]:
    """Return (path, syntax tree) of every module of a floor."""
    return [
        (path.relative_to(ROOT).as_posix(), ast.parse(path.read_text(encoding="utf-8")))
        for path in sorted((ROOT / floor).rglob("*.py"))
    ]


@pytest.mark.parametrize("floor", FLOORS)
def test_a_function_has_few_parameters(floor: str) -> None:
    long = [
        f"{path}: {node.name} has {parameters(node)} parameters"
        for path, tree in parsed(floor)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and parameters(node) > MOST_PARAMETERS
        and node.name not in DOORS.get(path, set())
    ]

    assert long == []


@pytest.mark.parametrize("floor", FLOORS)
def test_a_call_passes_few_arguments_by_position(floor: str) -> None:
    long = [
        f"{path}:{node.lineno}: {ast.unparse(node.func)} is given {len(node.args)} by position"
        for path, tree in parsed(floor)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and len(node.args) > MOST_POSITIONS
    ]

    assert long == []


def fields_by_position(item: ast.ClassDef) -> int:
    """Return how many fields of a data class or named tuple a caller may give by position."""
    decorators = " ".join(ast.unparse(one) for one in item.decorator_list)
    own_order = any(
        isinstance(one, ast.FunctionDef) and one.name == "__init__" for one in item.body
    )
    if "dataclass" not in decorators or "kw_only=True" in decorators or own_order:
        return 0
    fields = [one for one in item.body if isinstance(one, ast.AnnAssign)]
    kinds = [ast.unparse(one.annotation) for one in fields]
    last = kinds.index("KW_ONLY") if "KW_ONLY" in kinds else len(kinds)
    return sum(1 for kind in kinds[:last] if not kind.startswith("ClassVar"))


@pytest.mark.parametrize("floor", FLOORS)
def test_a_value_of_many_fields_takes_them_by_keyword(floor: str) -> None:
    """A named tuple of numbers for compiled code cannot, and is left out."""
    long = [
        f"{path}: {node.name} takes {fields_by_position(node)} fields by position"
        for path, tree in parsed(floor)
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and fields_by_position(node) > MOST_FIELDS
    ]

    assert long == []


def test_every_door_is_there_and_needs_to_be_named() -> None:
    """A door that has become short is no exception any more."""
    for path, names in DOORS.items():
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        counts = {
            node.name: parameters(node)
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef)
        }
        assert all(counts.get(name, 0) > MOST_PARAMETERS for name in names), path
