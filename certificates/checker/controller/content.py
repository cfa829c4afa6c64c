"""The gain file that belongs to a certificate, worked out from the model and the law in it.

What follows from the two is worked out here: programs, units, limits, rest values, ranges, the
rotor's inertia and torque table.  What does not follow (observer gains, trim table, words) stands
in the certificate's member ``controller``, with a hash like its other parts.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.controller.coherent_program import coherent_program
from takagi.certificates.checker.controller.language import LANGUAGE
from takagi.certificates.checker.controller.paper_program import paper_program
from takagi.certificates.checker.controller.plant_program import plant_program
from takagi.certificates.checker.controller.texts import EQUATIONS, RAMP, law_texts
from takagi.certificates.checker.controller.turbine_programs import (
    observer_program,
    rate_limit_program,
)
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.plant.reading import constant_bracket

__all__ = ["FORMAT", "VERSION", "file_content"]

FORMAT, VERSION = "takagi-gains", 3


def file_content(model: Any, law: Any, own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the whole gain file of a law, but for the hashes in its member ``certificate``.

    Parameters
    ----------
    model, law : as the certificate states them, read or not yet written.
    own : the certificate's ``controller``: what does not follow from the two.
    """
    head = {"format": FORMAT, "version": Number(str(VERSION)), "language": LANGUAGE, "law": law}
    work = _plant if law["name"] == "pdc" else _turbine
    return {**own, **head, **law_texts(law), **work(model, law, own)}


def _turbine(model: Any, law: Any, own: Mapping[str, Any]) -> dict[str, Any]:
    coherent = law["name"] == "coherent"
    written = coherent_program(law) if coherent else paper_program(law)
    return {
        "programs": [observer_program(), written, rate_limit_program()],
        "ramp": {"overlap": law["overlap"], "formula": RAMP} if coherent else None,
        "limits": {
            "torque": [Number("0"), law["rated_torque"]],
            "torque_rate": model["torque_rate_limit"],
            "pitch": [model["pitch_min"], model["pitch_max"]],
            "pitch_rate": model["pitch_rate_limit"],
        },
        "start": None if coherent else own["start"],
        "observer": {**own["observer"], "equations": EQUATIONS},
        "rotor": _rotor(model),
    }


def _rotor(model: Any) -> dict[str, Any]:
    inertia = _exact(model["rotor_inertia"])
    inertia += _exact(model["gear_ratio"]) ** 2 * _exact(model["generator_inertia"])
    surface = model["torque_surface"]
    return {
        "torque_constant": model["torque_constant"],
        "radius": model["rotor_radius"],
        "rotor_inertia": model["rotor_inertia"],
        "generator_inertia": model["generator_inertia"],
        "gear_ratio": model["gear_ratio"],
        "inertia": _short(inertia),
        "torque_coefficient": {
            "knots": [surface["tip_speed_ratio_knots"], surface["pitch_knots"]],
            "coefficients": surface["coefficients"],
        },
    }


def _plant(model: Any, law: Any, own: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {"programs": [plant_program(model, law, own)]}
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
            "rest": _short(_exact(v["rest"])),
            "range": _range(v),
        }
        for v in model["disturbances"]
    ]
    # Of parameters and tables those that the program looks up.
    used = {entry["value"] for entry in found["programs"][0]["names"].values()}
    found["parameters"] = {
        name: _short(_exact(value))
        for name, value in model["parameters"].items()
        if f"parameters.{name}" in used
    }
    found["tables"] = {
        name: {"knots": table["knots"], "coefficients": table["coefficients"]}
        for name, table in model.get("tables", {}).items()
        if f"tables.{name}" in used
    }
    return found


def _range(variable: Any) -> Any:
    ends = variable["range"]
    return None if ends is None else [_short(_exact(end)) for end in ends]


def _exact(value: Any) -> Fraction:
    """Return a number exactly; a text without names, such as ``"sqrt(2)"``, to 36 places."""
    if isinstance(value, str) and not isinstance(value, Number):
        return sum(constant_bracket(value), Fraction(0)) / 2
    return Fraction(value if isinstance(value, str) else repr(value))


def _short(value: Fraction) -> Number:
    """Return the nearest float's shortest decimal: what a program computes with."""
    return Number(repr(float(value)))
