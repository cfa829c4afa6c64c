"""Loops for the pinned claims: matrices without any symmetry, so that no order can be mistaken."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.replay.model_loop import read_model_loop

__all__ = ["loop", "read"]

STATES = ["x1 [-]", "x2 [m]"]
A = [[[-3, 1], [-0.5, -4]], [[-4, 0.5], [-1, -3]]]
B = [[[0.1], [0.2]], [[0.3], [-0.1]]]
WIDE = [[[0.1, 0.3], [0.2, -0.1]], [[0.3, 0], [-0.1, 0.2]]]
C = [[[1, 0.5]], [[0.8, -0.3]]]
D = [[[0.1]], [[0.25]]]
E = [[[1, 0.2], [0.3, -0.5]], [[0.7, 0], [0.1, 0.4]]]
K = [[[0.5, -0.3]], [[-0.2, 0.4]]]
TALL = [[[0.5, -0.3], [0.1, 0.2]], [[-0.2, 0.4], [0.3, 0]]]
CORNERS = [[0, 0], [0, 1], [1, 0], [1, 1]]
FOUR = [*A, [[-3.5, 0.2], [0.4, -5]], [[-5, -1], [0.3, -4]]]
BOX = {"x1 [-]": [-2, 3], "x2 [m]": [-4, 1.5], "u1": [-1, 2], "w1": [-0.5, 0.7], "r": [0, 1]}
NAMES = {"input_names": ["u1"], "disturbance_names": ["w1", "w2"]}
OUT = {"C": C, "D": D, "E": E}
PREMISES = [{"name": "z", "lower": 0, "upper": 1}]

MODELS: dict[str, dict[str, Any]] = {
    "alone": {"A": A[:1], "E": E[:1], "C": C[:1]},
    "free": {"A": A, **OUT, "B": B},
    "two": {"A": A, "B": B, **OUT},
    "affine": {"A": A, "B": B[:1], "C": C[:1], "E": E[:1]},
    "one gain": {"A": A, "B": B, **OUT},
    "own": {"A": A, "B": B, **OUT, "premises": PREMISES},
    "wide": {"A": A, "B": WIDE, "C": [[[1, 0.5], [0, 1]], [[0.8, -0.3], [1, 0.2]]], "E": E},
    "square": {"A": FOUR, "B": [*B, *B], "rules": CORNERS},
    "square alone": {"A": FOUR, "rules": CORNERS},
    "three": {"A": FOUR[:3], "B": [*B, B[0]]},
    "boxed": {"A": A, "B": B, **OUT, "box": BOX, **NAMES},
    "boxed alone": {"A": A, "B": B, **OUT, "box": BOX, **NAMES},
    "off centre": {"A": A, "B": B, "box": {"x1 [-]": [0.1, 2]}, **NAMES, "E": E},
}
LAWS: dict[str, Any] = {
    "two": K,
    "affine": K,
    "one gain": K[:1],
    "own": K,
    "wide": TALL,
    "square": [*K, *TALL[0], *K][:2] + [[[0.1, 0.1]], [[0.6, -0.2]]],
    "three": [*K, [[0.3, 0.3]]],
    "boxed": K,
    "off centre": K,
}


@cache
def loop(name: str, sample_time: float | None = None) -> PolytopicLoop:
    """Return a loop; in discrete time x+ = (I + A / 10) x + B u + E w."""
    model: dict[str, Any] = {"kind": "takagi-sugeno", "sample_time": sample_time}
    model |= {"state_names": STATES, **MODELS[name]}
    if sample_time is not None:
        model["A"] = [[[round((i == j) + a / 10, 9) for j, a in enumerate(row)]
                       for i, row in enumerate(matrix)] for matrix in model["A"]]  # fmt: skip
    gains = None
    if name in LAWS:
        gains = {"sample_time": sample_time, "state_names": STATES, "K": LAWS[name]}
        if "rules" in model:
            gains["rules"] = model["rules"]
    found = read(json.dumps({"model": model, "gains": gains}))
    return read_model_loop(found["model"], found["gains"])


def read(written: str) -> dict[str, Any]:
    """Return an object as the reader of files has it."""
    return read_text(written, "text")
