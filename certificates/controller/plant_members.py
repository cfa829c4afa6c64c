"""Contents of a plant's gain file that model and law do not determine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from takagi.certificates.controller.longest_sample import longest_of_plant, sampling_member
from takagi.certificates.controller.removable_points import removable_points

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked
    from takagi.models.plant.plant import Plant, Variable
    from takagi.models.ts.model import TSModel


def plant_members(
    plant: Plant,
    model: TSModel,
    law: Mapping[str, Any],
    checked: Checked,
    notes: tuple[str, ...],
    *,
    proved_sample: float | None = None,
) -> dict[str, Any]:
    """Return the certificate's member ``controller`` for a plant with gains.

    ``proved_sample`` : a sample time [s] at which the sampled loop is proved.
    """
    removable, words = removable_points(model, law.get("premises"))
    return {
        "name": f"{plant.name}, law {'of outputs, ' if 'observer' in law else ''}by rules",
        "plant": plant.name,
        "units": {
            **{f"K, {u.name} per {x.name}": _per(u.unit, x.unit) for u in plant.inputs
               for x in plant.states},
            **_observer_units(plant, law),
            "sample_time": "s",
        },
        "states": [*map(_signal, plant.states, law["trim"]["state"])],
        "inputs": [*map(_signal, plant.inputs, law["trim"]["input"])],
        "removable": removable,
        "sampling": sampling_member(longest_of_plant(plant, model, law, proved_sample)),
        "notes": [*notes, *words],
        "certificate": statement(checked),
    }  # fmt: skip


def _observer_units(plant: Plant, law: Mapping[str, Any]) -> dict[str, str]:
    """Return the units of L, and of constant A, B and C, of a law with an observer."""
    if "observer" not in law:
        return {}
    output_units = {y.name: y.unit for y in plant.outputs}
    rate = "" if plant.sample_time is not None else "/s"
    estimated = [plant.states[k] for k in plant.own_states]
    measured = law["observer"]["measured"]
    pairs = [("L", x.name, y, x.unit, output_units[y], rate) for x in estimated for y in measured]
    if law["observer"]["weights"] == "constant":
        pairs += [("A", x.name, y.name, x.unit, y.unit, "/s") for x in estimated for y in estimated]
        pairs += [
            ("B", x.name, u.name, x.unit, u.unit, "/s") for x in estimated for u in plant.inputs
        ]
        pairs += [
            ("C", y, x.name, output_units[y], x.unit, "") for x in estimated for y in measured
        ]
    return {
        f"observer.{matrix}, {row} per {column}": f"{_per(above, below)}{suffix}"
        for matrix, row, column, above, below, suffix in pairs
    }


def _signal(variable: Variable, equilibrium: float) -> dict[str, Any]:
    """Return a variable; where the certificate has the plant, its numbers come from there."""
    side = variable.range
    return {
        "name": variable.name,
        "unit": variable.unit,
        "rest": float(equilibrium),
        "range": None if side is None else [float(side.lower), float(side.upper)],
        "description": variable.description,
    }


def statement(checked: Checked) -> dict[str, Any]:
    """Return verdict and claims, as they were when the file was written."""
    return {
        "verdict": checked.verdict.name,
        "claims": [
            {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
            for claim in checked.claims
        ],
    }


def _per(above: str, below: str) -> str:
    """Return a unit over another, e.g. ``"N/(rad/s)"``."""
    if below == "-":
        return above
    top = "1" if above == "-" else above if " " not in above and "/" not in above else f"({above})"
    return f"{top}/{below}" if " " not in below and "/" not in below else f"{top}/({below})"
