"""The computed part of a plant's gain file: program, equilibrium values, ranges, tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.controller.language import exact, short
from takagi.certificates.checker.controller.plant_program import plant_program


def plant_content(
    model: Any, law: Any, own: Mapping[str, Any], *, called: bool = False
) -> dict[str, Any]:
    """Return the content; ``called`` as of ``plant_program``."""
    if "observer" in law:
        # Imported here: most laws have all states, and no observer.
        from takagi.certificates.checker.controller.observer_program import observer_program

        found: dict[str, Any] = {"programs": [observer_program(model, law, own)]}
    else:
        found = {"programs": [plant_program(model, law, own, called=called)]}
    if model.get("kind") != "plant":
        return found | {"signals": [], "parameters": {}, "tables": {}}
    trim = law["trim"]
    rests = {"states": trim["state"], "inputs": trim["input"]}
    for key, values in rests.items():
        stated = zip(own[key], model[key], values, strict=True)
        found[key] = [
            {**words, "name": v["name"], "unit": v["unit"], "rest": rest, "range": _range(v)}
            for words, v, rest in stated
        ]
    found["signals"] = [
        {
            "name": v["name"],
            "unit": v["unit"],
            "rest": short(exact(v["rest"])),
            "range": _range(v),
        }
        for v in model["disturbances"]
    ]
    if "observer" in law:
        found["measured"] = _measured(model, law, found["programs"][0])
    # Only the parameters and tables that the program reads.
    used = {entry["value"] for entry in found["programs"][0]["names"].values()}
    found["parameters"] = {
        name: short(exact(value))
        for name, value in model["parameters"].items()
        if f"parameters.{name}" in used
    }
    found["tables"] = {
        name: {"knots": table["knots"], "coefficients": table["coefficients"]}
        for name, table in model.get("tables", {}).items()
        if f"tables.{name}" in used
    }
    return found


def _measured(model: Any, law: Any, program: Any) -> list[dict[str, Any]]:
    """Return the measured outputs by the names under which the program reads them."""
    given = {y["name"]: y for y in model["outputs"]}
    variables = {v["name"]: v for v in model["states"]}
    resting = dict(zip(variables, law["trim"]["state"], strict=True))
    found = []
    for name, one in zip(law["observer"]["measured"], program["read"], strict=False):
        state = variables.get(str(given[name]["expression"]))
        found.append({
            "name": one["name"],
            "output": name,
            "unit": given[name]["unit"],
            "expression": given[name]["expression"],
            "rest": None if state is None else resting[state["name"]],
            "range": None if state is None else _range(state),
        })  # fmt: skip
    return found


def _range(variable: Any) -> Any:
    ends = variable["range"]
    return None if ends is None else [short(exact(end)) for end in ends]
