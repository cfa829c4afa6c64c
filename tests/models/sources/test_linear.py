"""Plants from matrices: their linear systems again, and every blend of vertices."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
import scipy.io
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import (
    ModelError,
    Plant,
    from_arrays,
    from_control,
    from_csv,
    from_mat,
    plant_text,
    sector_model,
    statespace,
)
from takagi.models.plant_files.loader import load_plant
from tests.plant_files import filed_plant

A = np.array([[0, 1, 0], [17.3, -0.1, 0.25], [0, 3e-7, -2]])
B = np.array([[0, 0], [-0.18, 1.0], [0.0, 0.3]])
C = np.array([[1.0, 0.5, 0]])
D = np.array([[0.0, 0.125]])


def test_the_matrices_are_those_of_python_control() -> None:
    system = statespace(from_arrays(A, B, C=C, D=D, inputs=["force", "torque"]))

    assert np.array_equal(system.A, A) and np.array_equal(system.B, B)
    assert np.array_equal(system.C[-1:], C) and np.array_equal(system.D[-1:], D)
    assert system.input_labels == ["force", "torque"]


def test_a_system_of_python_control_comes_back(tmp_path: Path) -> None:
    names = {"states": ["a", "b", "c"], "inputs": ["u", "w"], "outputs": ["y"]}
    given_system = control.ss(A, B, C, D, 0.1, **names)
    plant = from_control(given_system, {"u": (-1, 1)}, disturbances=["w"])
    system = statespace(filed_plant(tmp_path, plant_text(plant)))

    for letter in "AB":
        assert np.array_equal(getattr(system, letter), getattr(given_system, letter))
    assert np.array_equal(system.C[-1:], C)
    assert system.dt == 0.1 and plant.sample_time == 0.1
    assert [v.name for v in plant.inputs] == ["u"] and plant.disturbances[0].name == "w"


def test_csv_files_in_any_of_the_usual_forms(tmp_path: Path) -> None:
    (tmp_path / "A.csv").write_text("# A\n0, 1, 0\n17.3, -0.1, 0.25\n0, 3e-7, -2\n")
    (tmp_path / "B.csv").write_text("0;0\n-0.18;1;\n\n0;0.3\n")
    (tmp_path / "C.csv").write_text("1 0.5 0\n")
    plant = from_csv([tmp_path / f"{letter}.csv" for letter in "ABC"])

    assert plant == from_arrays(A, B, C=C)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("1, 2\n3\n", r"A.csv:2: 1 numbers, and 2 in the rows above"),
        ("1, x\n", r"A.csv:1: column 2 is 'x'; a finite number is needed"),
        ("1, nan\n", "a finite number is needed"),
        ("\n", "has no numbers"),
        ("1, 2\n", r"A has shape \(1, 2\)"),
    ],
)
def test_a_matrix_that_is_none_is_told_with_its_line(text: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "A.csv").write_text(text)

    with pytest.raises(ModelError, match=told):
        from_csv([tmp_path / "A.csv"])


VERTICES = np.array([[[0, 1], [17.3, 0]], [[0, 1], [9.4, 0]], [[0, 1], [4.0, 1]]])
PUSHES = np.array([[[0], [-0.18]], [[0], [-0.15]], [[0], [-0.3]]])


@given(st.lists(st.floats(0, 1), min_size=2, max_size=2))
def test_the_signals_blend_the_vertices(w: list[float]) -> None:
    """h = (w1, (1 - w1) w2, (1 - w1)(1 - w2)) are weights, and the plant is sum h_i A_i."""
    plant = from_arrays(VERTICES, PUSHES)
    h = np.array([w[0], (1 - w[0]) * w[1], (1 - w[0]) * (1 - w[1])])
    system = statespace(plant, at={"w1": w[0], "w2": w[1]})

    assert np.allclose(system.A, np.tensordot(h, VERTICES, 1), atol=1e-12)
    assert np.allclose(system.B[:, :1], np.tensordot(h, PUSHES, 1), atol=1e-12)


def test_the_model_s_vertices_are_those_given() -> None:
    model = sector_model(from_arrays(VERTICES, PUSHES))
    pairs = {
        tuple(np.hstack([a.ravel(), b.ravel()])) for a, b in zip(model.A, model.B, strict=True)
    }
    given_pairs = {
        tuple(np.hstack([a.ravel(), b.ravel()])) for a, b in zip(VERTICES, PUSHES, strict=True)
    }

    assert pairs == given_pairs


def test_a_mat_file_gives_its_vertices(tmp_path: Path) -> None:
    path = tmp_path / "model.mat"
    scipy.io.savemat(path, {"A": np.moveaxis(VERTICES, 0, 2), "B": np.moveaxis(PUSHES, 0, 2)})

    assert from_mat(path) == from_arrays(VERTICES, PUSHES)
    assert from_mat(path, states=["angle", "rate"]).states[0].name == "angle"


@pytest.mark.parametrize(
    ("arrays", "told"),
    [
        ({"A": A, "B": B[:2]}, r"B must be \(1, 3, 2\) or \(3, 2\)"),
        ({"A": A, "states": ["a"]}, r"states: 1 names were given \(a\), and the matrices have 3"),
        ({"A": [[1j]]}, "complex entries"),
        ({"A": [[1, 2], [3]]}, "nested lists of equal length"),
        ({"A": [[np.inf]]}, "every entry must be finite"),
        ({"A": np.ones((8, 1, 1)) * np.arange(8)[:, None, None]}, "7 vertices are the most"),
        ({"A": VERTICES, "B": PUSHES[:2]}, r"B must be \(3, 2, 1\)"),
    ],
)
def test_what_does_not_fit_is_told(arrays: dict[str, Any], told: str) -> None:
    with pytest.raises(ModelError, match=told):
        from_arrays(**arrays)


def test_numbers_are_the_decimals_that_they_print_as() -> None:
    plant = from_arrays([[0.1]])

    assert isinstance(plant, Plant)
    assert plant.equations[0] == sp.Rational(1, 10) * plant.states[0].symbol


def test_a_sample_time_of_many_digits_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "sampled.toml"
    path.write_text(plant_text(from_arrays([[0.5]], [[1]], sample_time=1 / 30)), encoding="utf-8")

    assert load_plant(path).sample_time == 1 / 30
