"""Certificates about outputs that follow references."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from takagi.models import Plant
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import Data, resealed, sealed
from tests.plant_files import written

# An arm in gravity: what holds it at an angle depends on the angle and on its mass.
ARM = """
format = 1
kind = "plant"
name = "arm"

[states]
q = { unit = "deg", range = [-60, 60] }
w = { unit = "deg/s", range = [-180, 180] }

[inputs]
tau = { unit = "N m", range = [-15, 15] }

[parameters]
m = "[0.9, 1.1] kg"
l = { value = 0.5, unit = "m" }
g = { value = 9.81, unit = "m/s^2" }
c = { value = 0.5, unit = "N m s" }

[equations]
q = "w"
w = "(tau - c*w - m*g*l*sin(q))/(m*l^2)"

[outputs]
twice = { expression = "2*q", unit = "rad" }

[reference]
target = { follow = "q", range = [-30, 30], rate = 5 }
"""


GAINS = [[30.0, 6.0, 60.0]]
RECORDED = Path(__file__).parents[1] / "recorded" / "arm.json"


def plant_of(folder: Path, text: str = ARM) -> tuple[Plant, Path]:
    path = written(folder, text, "arm.toml")
    return load_plant(path), path


def arm() -> Data:
    """Return the certificate of ``ARM`` under ``GAINS``, recorded as ``certify_plant`` made it."""
    found: Data = json.loads(RECORDED.read_text(encoding="utf-8"))
    return found


def claims() -> list[Data]:
    return [c for c in arm()["claims"] if c["kind"] == "tracking"]


def changed(change: Callable[[Data], None], which: int = 1) -> Data:
    found = arm()
    kept = [c for c in found["claims"] if c["kind"] == "tracking"][which]
    found["claims"] = [c for c in found["claims"] if c["kind"] == "secant-embedding"] + [kept]
    change(found)
    return resealed(found)


def pure(
    drift: str = "0", slope: str = "0", x: Any = (-2, 2), u: Any = (-10, 10), r: Any = (-1, 1)
) -> Data:
    """Return x' = u + drift with the slope -1 or 0, xi' = x - r, and u = -K (x, xi).

    A - B K is [[-3, -2], [1, 0]]: poles -1, -2.  With the drift 0 it rests at (r, -3 r/2).
    """
    ranges = {"x": x, "u": u, "r": r}

    def listed(*names: str) -> list[Data]:
        sides = [None if ranges.get(n) is None else list(ranges[n]) for n in names]
        return [
            {"name": n, "unit": "-", "range": side, "rest": 0}
            for n, side in zip(names, sides, strict=True)
        ]

    model: Data = {"kind": "plant", "name": "integrator", "source": "", "sample_time": None}
    model |= {"states": listed("x", "xi"), "inputs": listed("u"), "disturbances": listed("r")}
    model |= {"parameters": {}, "equations": [f"u + {drift}", "x - r"], "outputs": []}
    model["references"] = [{"reference": "r", "integral": "xi", "follow": "x"}]
    model["embedding"] = {"form": "secant", "premises": [], "A": [[slope, "0"], ["1", "0"]]}
    model["embedding"] |= {"B": [["1"], ["0"]], "E": [["0"], ["-1"]]}
    gains: Data = {"name": "pdc", "sample_time": None, "state_names": ["x [-]", "xi [-]"]}
    gains |= {"input_names": ["u [-]"], "K": [[[3 + int(slope), 2]]]}
    gains |= {"trim": {"state": [0, 0], "input": [0]}, "references": [*model["references"]]}
    first = {"name": "embedding", "kind": "secant-embedding"}
    return sealed(model, gains, first)


def at(document: Data | None = None, **numbers: Any) -> Data:
    """The claim with V of the modes: P = T'T for T = [[1, 1], [1, 2]], rates 1 and 2."""
    found = copy.deepcopy(document or pure())
    claim = {
        "name": "x follows r",
        "kind": "tracking",
        "decay_rate": 1,
        "P": [[2, 3], [3, 5]],
        "radius": 0.2,
        "slope": [[1], [-1.5]],
        "residuals": [0, 0],
        "residual_norm": 0,
        "slope_norms": [2.0616],
        "rates": [0.09],
        "error_factors": [2.2361],
    } | numbers
    found["claims"].append(claim)
    return resealed(found)
