"""OpenFAST's linearisation files: names, inputs, states that settle, and what is refused."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from takagi.models import ModelError, from_lin, statespace

# Tower, generator's angle, generator's speed, a wake, a state that never moves.
STATES = [
    ("F", "ED 1st tower fore-aft bending mode DOF (internal DOF index = DOF_TFA1), m"),
    ("F", "ED Variable speed generator DOF (internal DOF index = DOF_GeAz), rad"),
    ("F", "ED First time derivative of 1st tower fore-aft bending mode DOF (internal DOF index = "
          "DOF_TFA1), m/s"),
    ("F", "ED First time derivative of Variable speed generator DOF (internal DOF index = "
          "DOF_GeAz), rad/s"),
    ("T", "AD vind (axial) at blade 1, node 1, m/s"),
    ("F", "HD ExctnPtfmSg1"),
]  # fmt: skip
INPUTS = [
    "IfW Extended input: horizontal wind speed (steady/uniform wind) (hub), m/s",
    "ED Yaw moment, Nm",
    "ED Generator torque, Nm",
    "ED Extended input: collective blade-pitch command, rad",
]
A = np.array(
    [
        [0, 0, 1, 0, 0, 0],
        [0, 0, 0, 1, 0, 0],
        [-4.0, 1e-3, -0.1, 0.2, 0.5, 0],
        [0.01, 2e-3, -0.3, -0.5, 0.7, 0],
        [0.1, 0, 0.2, 0.3, -2.0, 0],
        [0, 0, 0, 0, 0, 0],
    ]
)
B = np.array(
    [[0, 0, 0, 0], [0, 0, 0, 0], [0.3, 0, 0, -2], [0.4, 0, -1e-7, -3], [0.5, 0, 0, 1], [0, 0, 0, 0]]
)


def lin_text(states: Sequence[tuple[str, str]] = STATES, matrix: Any = A) -> str:
    def rows(listed: Sequence[tuple[str, str]], order: str) -> str:
        return "\n".join(
            f"{k:11d}   {0.1 * k:.6E}      {frame}    {order}    {words}"
            for k, (frame, words) in enumerate(listed, start=1)
        )

    def numbers(letter: str, values: Any) -> str:
        lines = "\n".join("  ".join(f"{cell:.6E}" for cell in row) for row in values)
        return f"{letter}: {len(values)} x {len(values[0])}\n{lines}\n"

    head = "   Row/Column Operating Point  Rotating Frame? Derivative Order Description\n   -- --\n"
    return "\n".join(
        [
            "\nLinearized model: made for a test",
            f"   Number of continuous states:     {len(states)}\n",
            f"Order of continuous states:\n{head}{rows(states, '2')}\n",
            f"Order of continuous state derivatives:\n{head}{rows(states, '2')}\n",
            f"Order of inputs:\n{head}{rows([('F', words) for words in INPUTS], '0')}\n",
            "Linearized state matrices:\n",
            numbers("A", matrix),
            numbers("B", B),
        ]
    )


def lin_file(folder: Path, text: str) -> Path:
    path = folder / "turbine.1.lin"
    path.write_text(text, encoding="utf-8")
    return path


KEPT = ["TFA1", "d_TFA1", "d_GeAz"]


def test_the_other_states_settle_as_python_control_lets_them(tmp_path: Path) -> None:
    """Against control.model_reduction, by the gain at rest, without angle and still state."""
    plant = from_lin(lin_file(tmp_path, lin_text()), states=KEPT)
    moving = [0, 2, 3, 4]
    full = control.ss(
        A[np.ix_(moving, moving)],
        B[moving],
        np.eye(4)[:3],
        np.zeros((3, 4)),
        remove_useless_states=False,
    )
    reduced = control.model_reduction(full, [3], method="matchdc")
    system = statespace(plant)

    assert np.allclose(system.A, reduced.A, rtol=1e-9)
    assert np.allclose(system.B, reduced.B[:, [2, 3, 0]], rtol=1e-9)
    assert system.state_labels == KEPT
    assert system.input_labels == [
        "Generator_torque",
        "collective_blade_pitch_command",
        "horizontal_wind_speed",
    ]
    assert "1 of its states settle at once" in plant.source
    assert plant.states[0].description == STATES[0][1]


def test_all_states_but_the_rotor_s_angle_are_kept_unless_named(tmp_path: Path) -> None:
    fixed = [("F", words) for _, words in STATES]
    plant = from_lin(lin_file(tmp_path, lin_text(fixed)), inputs=["collective_blade_pitch_command"])

    assert [v.name for v in plant.states] == [*KEPT, "vind_at_blade_1_node_1", "ExctnPtfmSg1"]
    assert np.allclose(statespace(plant).A, A[np.ix_([0, 2, 3, 4, 5], [0, 2, 3, 4, 5])])


def test_states_in_the_rotating_frame_are_refused(tmp_path: Path) -> None:
    told = r"1 states are in the rotating frame \(vind_at_blade_1_node_1\).*--state"
    with pytest.raises(ModelError, match=told):
        from_lin(lin_file(tmp_path, lin_text()))


def test_what_does_not_settle_is_kept(tmp_path: Path) -> None:
    unstable = A.copy()
    unstable[4, 4] = 2.0
    path = lin_file(tmp_path, lin_text(matrix=unstable))

    with pytest.raises(ModelError, match="1 states that are not kept do not settle by themselves"):
        from_lin(path, states=KEPT)


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (
            {"states": ["TFA2"]},
            r"TFA2 is no state \(did you mean 'TFA1'.*; states are TFA1, GeAz",
        ),
        ({"inputs": ["pitch"]}, "pitch is no input"),
    ],
)
def test_a_name_that_is_not_there_is_told(names: Any, told: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=told):
        from_lin(lin_file(tmp_path, lin_text()), **names)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("nothing", "has no 'Order of continuous states'"),
        (lin_text().replace("A: 6 x 6", "A: 7 x 6"), "'A: 6 x 6' and its numbers are needed"),
        (lin_text().replace("B: 6 x 4", "Q: 6 x 4"), "'B: 6 x 4' and its numbers are needed"),
        (lin_text(STATES[:5]), "'A: 5 x 5' and its numbers are needed"),
    ],
)
def test_a_file_of_another_form_is_told(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=told):
        from_lin(lin_file(tmp_path, text))
