"""What a part of a plant file is, by its place: a unit that may be left out, or a formula."""

from __future__ import annotations

import pytest

from takagi.certificates.checker.files.model_content import _is_formula, _is_unit


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        (("states", "x", "unit"), True),
        (("outputs", "y", "unit"), True),
        (("tables", "cp", "unit"), True),
        (("tables", "cp", "arguments", 0, "unit"), True),
        (("blending", "effort", "unit"), True),
        (("blending", "low", "unit"), False),
        (("tables", "cp", "arguments", 0, "name"), False),
        (("equations", "x", "unit"), False),
        (("unit",), False),
    ],
)
def test_a_unit_stands_only_where_a_file_may_leave_it_out(
    path: tuple[str | int, ...], unit: bool
) -> None:
    assert _is_unit(path) is unit


@pytest.mark.parametrize(
    ("path", "formula"),
    [
        (("equations", "x"), True),
        # An output may be called so.
        (("outputs", "unit", "expression"), True),
        (("outputs", "y", "unit"), False),
        (("blending", "low", "effectiveness"), True),
        (("blending", "low", "input"), False),
        (("states", "x", "range"), False),
    ],
)
def test_a_formula_is_told_by_the_last_key(path: tuple[str, ...], formula: bool) -> None:
    assert _is_formula(path) is formula
