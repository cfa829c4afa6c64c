"""The computed part of a plant's gain file: program, equilibrium values, ranges, tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.controller.decimals import exact, short
from takagi.certificates.checker.controller.plant_program import plant_program


def plant_content(
    model: Any, law: Any, controller: Mapping[str, Any], *, called: bool = False
) -> dict[str, Any]:
    """Return the content; ``called`` as of ``plant_program``."""
    if "observer" in law:
        # Imported here: most laws have all states, and no observer.
        from takagi.certificates.checker.controller.observer_program import observer_program

        content: dict[str, Any] = {"programs": [observer_program(model, law, controller)]}
    else:
        content = {"programs": [plant_program(model, law, controller, called=called)]}
    if model.get("kind") != "plant":
        return content | {"signals": [], "parameters": {}, "tables": {}}
    trim = law["trim"]
    rests = {"states": trim["state"], "inputs": trim["input"]}
    for key, values in rests.items():
        stated = zip(controller[key], model[key], values, strict=True)
        content[key] = [
            {**words, "name": v["name"], "unit": v["unit"], "rest": rest_value, "range": _range(v)}
            for words, v, rest_value in stated
        ]
    content["signals"] = [
        {
            "name": v["name"],
            "unit": v["unit"],
            "rest": short(exact(v["rest"])),
            "range": _range(v),
        }
        for v in model["disturbances"]
    ]
    if "observer" in law:
        content["measured"] = _measured(model, law, content["programs"][0])
    # Only the parameters and tables that the program reads.
    values_read = {entry["value"] for entry in content["programs"][0]["names"].values()}
    content["parameters"] = {
        name: short(exact(value))
        for name, value in model["parameters"].items()
        if f"parameters.{name}" in values_read
    }
    content["tables"] = {
        name: {"knots": table["knots"], "coefficients": table["coefficients"]}
        for name, table in model.get("tables", {}).items()
        if f"tables.{name}" in values_read
    }
    return content


def _measured(model: Any, law: Any, program: Any) -> list[dict[str, Any]]:
    """Return the measured outputs by the names under which the program reads them."""
    outputs = {y["name"]: y for y in model["outputs"]}
    variables = {v["name"]: v for v in model["states"]}
    resting = dict(zip(variables, law["trim"]["state"], strict=True))
    measured = []
    for name, program_input in zip(law["observer"]["measured"], program["read"], strict=False):
        state = variables.get(str(outputs[name]["expression"]))
        measured.append({
            "name": program_input["name"],
            "output": name,
            "unit": outputs[name]["unit"],
            "expression": outputs[name]["expression"],
            "rest": None if state is None else resting[state["name"]],
            "range": None if state is None else _range(state),
        })  # fmt: skip
    return measured


def _range(variable: Any) -> Any:
    ends = variable["range"]
    return None if ends is None else [short(exact(end)) for end in ends]
