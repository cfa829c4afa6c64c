"""`check --model`: a law of states is one of what is measured where it uses no other state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_parts import compare_measured
from tests.certificates.kinds.claims import as_read

FILE: dict[str, Any] = {"measured": ["x"], "states": {"x": {}, "v": {}}}
LAW: dict[str, Any] = {
    "state_names": ["x [m]", "v [m/s]"],
    "premises": [{"name": "z1", "expression": "sin(x)/x"}],
    "K": [[[1.5, 0]], [[2, 0.0]]],
}
ONE_GAIN = [[[1.5, 0]], [[1.5, 0]]]
OF_V = [{"name": "z1", "expression": "sin(x)/x"}, {"name": "z2", "expression": "x*v^2"}]


def compared(file: dict[str, Any] = FILE, **changes: Any) -> None:
    compare_measured(as_read(LAW | changes), file, Path("plant.toml"))


def test_gains_of_zero_use_no_state() -> None:
    """Rules of their own need premises of what is measured; one gain needs none."""
    compared()
    compared(K=ONE_GAIN, premises=OF_V)
    compared(FILE | {"measured": ["v", "x"]}, K=[[[1, 1]], [[2, 3]]], premises=OF_V)
    compared(state_names=["delta_x [m]", "delta_v [m/s]"])
    # The integral of a reference is a state of the law.
    compared(state_names=["x [m]", "xi [m s]"], K=[[[1, 5]], [[2, 5]]])


@pytest.mark.parametrize(
    "changes",
    [
        {"K": [[[1.5, 0]], [[2, 1e-9]]]},
        {"K": [[[1.5, 1e-30]]]},
        {"premises": OF_V},
        {"premises": [{"name": "z1", "expression": "v"}]},
        {"premises": []},
        {"premises": None},
        {"state_names": ["x [m]"]},
        {"state_names": None},
        {"K": None},
        {"K": []},
        {"state_names": ["v [m/s]", "x [m]"]},
        # States that do not rest at 0 stand in a law as their deviations.
        {"state_names": ["delta_x [m]", "delta_v [m/s]"], "K": [[[1.5, 0.5]]]},
        {"premises": [{"name": "z1", "expression": "(delta_v + v_rest)^2"}]},
    ],
)
def test_another_state_is_another_law(changes: dict[str, Any]) -> None:
    """A gain however small, a premise, or members that do not say which states are used."""
    with pytest.raises(OtherModel, match="has all states, the field measured lists x alone"):
        compared(**changes)


def test_an_output_of_a_state_is_not_the_state() -> None:
    """The file names what a sensor shows; a law of states names states."""
    with pytest.raises(OtherModel, match="lists y alone"):
        compared(FILE | {"measured": ["y"], "outputs": {"y": {"expression": "x"}}})
