"""A Takagi-Sugeno model and its law as a certificate states them: decimals as they are emitted."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel
    from takagi.models.ts.premise import Premise


def ts_model_data(model: TSModel) -> dict[str, Any]:
    """Return the model of kind ``takagi-sugeno``: vertices, names, premises, rules, box.

    A matrix that is the same in all rules is written once; one without columns or rows is left
    out.  Every float is written as its shortest decimal, and proofs are about this decimal.
    """
    stacks = {
        letter: _stack(getattr(model, letter))
        for letter in ("A", "B", "C", "D", "E")
        if getattr(model, letter).size
    }
    data: dict[str, Any] = {
        "kind": "takagi-sugeno",
        "name": model.name,
        "sample_time": model.sample_time,
        "state_names": list(model.states),
        "input_names": list(model.inputs),
        "output_names": list(model.outputs),
        "disturbance_names": list(model.disturbances),
        **stacks,
        "box": {
            name: [inner_decimal(low, 1), inner_decimal(high, -1)]
            for name, (low, high) in model.box.items()
            # The model need not hold on the whole box around a band or a union of cells.
            if model.domain is None
        },
    }
    return data | _weights(model.premises, model.rules)


def pdc_law_data(model: TSModel, K: Floats) -> dict[str, Any]:
    """Return u = -sum_j h_j K_j x with the weights of the model, as in gain file and certificate.

    Parameters
    ----------
    K : (r, m, n), or (m, n) for one gain in all rules.
    """
    n, m = model.A.shape[1], model.B.shape[2]
    return {
        "name": "pdc",
        "sample_time": model.sample_time,
        "state_names": list(model.states),
        "input_names": list(model.inputs),
        **_weights(model.premises, model.rules),
        "K": _stack(K.reshape(-1, m, n)),
        "trim": {"state": [0.0] * n, "input": [0.0] * m},
    }


def inner_decimal(end: Fraction, direction: int) -> float:
    """Return a float whose shortest decimal is not below the end (1), or not above it (-1)."""
    inner = float(end)
    while direction * (Fraction(repr(inner)) - end) < 0:
        inner = float(np.nextafter(inner, direction * np.inf))
    return inner


def _stack(matrices: Floats) -> list[list[list[float]]]:
    same = bool((matrices == matrices[0]).all())
    return (matrices[:1] if same else matrices).tolist()  # type: ignore[no-any-return]


def _weights(premises: Sequence[Premise], rules: Sequence[tuple[int, ...]]) -> dict[str, Any]:
    if not premises:
        return {}
    return {
        "premises": [
            {
                "name": premise.name,
                "lower": float(premise.lower),
                "upper": float(premise.upper),
                "unit": premise.unit,
            }
            for premise in premises
        ],
        "rules": [list(rule) for rule in rules],
    }
