"""`check --model`: a law of states is one of what is measured where it uses no other state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_parts import compare_measured
from takagi.certificates.checker.plant.expression import Scope
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.reading import PlantNodes, Variable
from tests.certificates.kinds.claims import as_read

FILE: dict[str, Any] = {"measured": ["x"], "states": {"x": {}, "v": {}}}
LAW: dict[str, Any] = {
    "state_names": ["x [m]", "v [m/s]"],
    "premises": [{"name": "z1", "expression": "sin(x)/x"}],
    "K": [[[1.5, 0]], [[2, 0.0]]],
}
ONE_GAIN = [[[1.5, 0]], [[1.5, 0]]]
OF_V = [{"name": "z1", "expression": "sin(x)/x"}, {"name": "z2", "expression": "x*v^2"}]


def plant_nodes(*states: tuple[str, str, str], others: tuple[str, ...] = ()) -> PlantNodes:
    """The states of a certificate, each with its symbol and unit, and the names beside them."""
    graph = Graph()
    listed = [Variable(name, symbol, unit, 0, None) for name, symbol, unit in states]
    names = {*others, *(v.name for v in listed), *(v.symbol for v in listed)}
    scope = Scope({name: graph.variable(name) for name in sorted(names)})
    return PlantNodes(graph, {}, listed, [], [], None, premise_scope=scope)


AT_ZERO = plant_nodes(("x", "x", "m"), ("v", "v", "m/s"))
INTEGRATING = plant_nodes(("x", "x", "m"), ("v", "v", "m/s"), ("xi", "xi", "m s"))
ELSEWHERE = plant_nodes(
    ("x", "delta_x", "m"), ("v", "delta_v", "m/s"), others=("x_rest", "v_rest", "k")
)


def compared(file: dict[str, Any] = FILE, plant: PlantNodes = AT_ZERO, **changes: Any) -> None:
    compare_measured(as_read(LAW | changes), file, Path("plant.toml"), plant)


def test_gains_of_zero_use_no_state() -> None:
    """Rules of their own need premises of what is measured; one gain needs none."""
    compared()
    compared(K=ONE_GAIN, premises=OF_V)
    compared(FILE | {"measured": ["v", "x"]}, K=[[[1, 1]], [[2, 3]]], premises=OF_V)
    compared(plant=ELSEWHERE, state_names=["delta_x [m]", "delta_v [m/s]"])
    # The integral of a reference is a state of the law.
    integrating: dict[str, Any] = {
        "state_names": ["x [m]", "v [m/s]", "xi [m s]"],
        "K": [[[1, 0, 5]]],
    }
    compared(plant=INTEGRATING, references=[{"follow": "x"}], **integrating)


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
        # A premise that does not say, or not in names of the plant, what it is computed from.
        {"premises": [{"name": "v", "lower": 0, "upper": 1}]},
        {"premises": [{"name": "z1", "expression": "hidden^2"}]},
        {"premises": [{"name": "z1", "expression": ["v"]}]},
        {"premises": {"name": "z1", "expression": "x"}},
        # The integral of v - r is computed from v, and a command over b(v) too.
        {"references": [{"follow": "v", "integral": "xi"}], "K": [[[1, 0]]]},
        {"references": [{"integral": "xi"}], "K": [[[1, 0]]]},
        {"blending": {"low": {"effectiveness": "1 + v^2"}, "high": {"effectiveness": "1"}}},
        {"blending": {"low": {"effectiveness": "1"}}},
        {"blending": 1},
    ],
)
def test_another_state_is_another_law(changes: dict[str, Any]) -> None:
    """A gain however small, a formula, or members that do not say which states are used."""
    with pytest.raises(OtherModel, match="has all states, the field measured lists x alone"):
        compared(**changes)


@pytest.mark.parametrize("symbol", ["delta_v", "moved", "d"])
def test_a_deviation_under_any_name_is_its_state(symbol: str) -> None:
    """A certificate chooses the names of deviations, in labels and in premises."""
    plant = plant_nodes(("x", "delta_x", "m"), ("v", symbol, "m/s"), others=("x_rest", "v_rest"))
    names: dict[str, Any] = {"state_names": ["delta_x [m]", f"{symbol} [m/s]"]}
    compared(plant=plant, **names)
    for changes in (
        {"K": [[[1.5, 0.5]]]},
        {"premises": [{"name": "z1", "expression": f"({symbol} + v_rest)^2"}]},
    ):
        with pytest.raises(OtherModel, match="has all states"):
            compared(plant=plant, **names | changes)


def test_a_state_of_which_another_output_has_the_name_is_not_measured() -> None:
    """What the file calls v there is a sensor of something else."""
    both: dict[str, Any] = {"K": [[[1, 1]]]}
    compared(FILE | {"measured": ["x", "v"], "outputs": {"v": {"expression": "v"}}}, **both)
    compared(FILE | {"measured": ["x", {"name": "v"}]}, **both)
    for file in (
        {"measured": ["x", "v"], "outputs": {"v": {"expression": "x^2"}}},
        {"measured": ["x", {"name": "v", "expression": "x"}]},
    ):
        with pytest.raises(OtherModel, match="has all states"):
            compared(FILE | file, **both)


def test_an_output_of_a_state_is_not_the_state() -> None:
    """The file names what a sensor shows; a law of states names states."""
    with pytest.raises(OtherModel, match="lists y alone"):
        compared(FILE | {"measured": ["y"], "outputs": {"y": {"expression": "x"}}})
