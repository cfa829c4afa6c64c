"""Misuse is named: which item, what was given, what to do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import common_lyapunov, max_decay_rate, pdc
from takagi.lmi.intake import symmetric
from takagi.models import ModelError, TSModel

Floats = NDArray[np.float64]


@dataclass
class Plain:
    """Only the attributes that are read: a model need not be a TSModel."""

    A: Floats
    B: Floats


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (np.zeros((0, 2, 2)), "no vertices"),
        (np.zeros((2, 2, 3)), r"\(N, n, n\) is needed"),
        (np.zeros(3), r"\(N, n, n\) is needed"),
        ([[[-1.0, np.nan], [0.0, -1.0]]], r"vertex 1 of 1: A\[0, 1\] is nan"),
        ([[-1.0, "x"], [0.0, -1.0]], "cannot be read"),
        ([[[1.0]], [[1.0, 2.0]]], "cannot be read"),
        (np.array([[1j]]), "cannot be read"),
    ],
)
def test_vertices_that_make_no_sense(vertices: object, message: str) -> None:
    """Shapes, entries and emptiness are told apart."""
    with pytest.raises(ModelError, match=message):
        common_lyapunov(vertices)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match=message):
        max_decay_rate(vertices)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("B", "message"),
    [
        (np.zeros((2, 2, 1)), "input 1 of 1: its column of B is zero in every vertex"),
        (np.tile([[1.0, 2.0], [2.0, 4.0]], (2, 1, 1)), "B has rank 1 over all vertices, but 2"),
        (np.zeros((2, 2, 0)), "no inputs"),
        (np.ones((3, 2, 1)), r"B has shape \(3, 2, 1\), A has \(2, 2, 2\)"),
        (np.full((2, 2, 1), np.inf), r"vertex 1 of 2: B\[0, 0\] is inf"),
    ],
)
def test_inputs_that_make_no_sense(B: Floats, message: str) -> None:
    """Inputs that do nothing, depend on one another or do not fit."""
    with pytest.raises(ModelError, match=message):
        pdc(Plain(np.tile(-np.eye(2), (2, 1, 1)), B))


def test_an_unstable_mode_out_of_reach_is_named() -> None:
    """Vertex 2 has a mode at 0.5 that the input does not move, in the state that carries it."""
    A = np.array([np.diag([-1.0, 1.0]), np.diag([0.5, 1.0])])
    model = TSModel(A, [[0.0], [1.0]], states=["drift [m]", "speed [m/s]"])

    with pytest.raises(ModelError, match=r"vertex 2 of 2: the mode at 0.5.*\+1 \* drift \[m\]"):
        pdc(model)


def test_a_vertex_without_authority_is_legal_where_it_is_stable() -> None:
    """Pitch does nothing in partial load; that vertex decays by itself."""
    A = np.array([[[-0.1]], [[0.5]]])
    design = pdc(TSModel(A, [[[0.0]], [[1.0]]]), relaxation="wang-tanaka-griffin")

    assert design.status in ("candidate", "infeasible")


def test_an_unknown_relaxation_lists_the_known_ones() -> None:
    """The message lists all names and offers the near one."""
    model = TSModel([[[1.0]]], [[[1.0]]])
    with pytest.raises(ModelError, match="wang-tanaka-griffin.*polya-<d>.*mean 'tanaka-wang'"):
        pdc(model, relaxation="tanaka-wong")


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"decay_rate": np.nan}, "decay_rate is nan"),
        ({"decay_rate": "fast"}, "decay_rate is 'fast'"),
        ({"input_limit": [0.0]}, r"input_limit\[0\] is 0"),
        ({"input_limit": [1.0, 2.0]}, r"input_limit has shape \(2,\)"),
        ({"initial_box": [1.0], "state_box": [0.5]}, "state 1: the initial box reaches to 1"),
        ({"gain_bound": -1.0}, "gain_bound is -1"),
        ({"scales": [-1.0]}, r"scales\[0\] is -1"),
        ({"state_box": [-np.inf]}, r"state_box\[0\] is -inf"),
    ],
)
def test_options_that_make_no_sense(option: dict[str, object], message: str) -> None:
    """Each option is checked where it is given."""
    with pytest.raises(ModelError, match=message):
        pdc(TSModel([[[1.0]]], [[[1.0]]]), **option)  # type: ignore[arg-type]


def test_a_weight_that_is_not_symmetric_is_not_halved() -> None:
    """cvxpy would use the symmetric part without a word."""
    with pytest.raises(ModelError, match=r"entry \[0, 1\] is 1, \[1, 0\] is 0"):
        symmetric("Q", [[1.0, 1.0], [0.0, 1.0]], 2, definite=False)
    with pytest.raises(ModelError, match="eigenvalue -1; it must be positive semidefinite"):
        symmetric("Q", [[1.0, 0.0], [0.0, -1.0]], 2, definite=False)


def test_small_units_are_not_taken_for_no_authority() -> None:
    """A torque in N m moves a rotor by 1e-12 of its unit; that is authority all the same."""
    model = TSModel(
        [[[0.1, 0.0], [0.0, -5.0]]],
        [[[-1e-12, 0.0], [0.0, 5.0]]],
    )

    assert pdc(model, decay_rate=0.05).found
