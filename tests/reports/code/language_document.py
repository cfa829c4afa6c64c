"""A document like a gain file whose program has every function of the language."""

from __future__ import annotations

from decimal import Decimal
from typing import Any


def every_function() -> dict[str, Any]:
    """Return a document like a gain file, with a formula for every function of the language."""
    x, half = "(x/3)", "(x/3)^2"
    formulas = {
        "f_math": "abs(x) + sqrt(abs(x)) + exp(x) + log(x^2 + 1) + sin(x) + cos(x) + tan(x/4)",
        "f_arcs": f"asin({x}) + acos({x}) + atan(x) + atanh(x/4) + asinh(x) + acosh(1 + x^2)",
        "f_more": "sinh(x) + cosh(x) + tanh(x) + erf(x)",
        "f_power": "x^2 + x^3 - x^4 + x^5 + 2^x + -x^2 + 2^3^2 + abs(x)^0.3 + (x^2 + 1)^-2",
        "f_signs": "x - (y - 2) - y/(x^2 + 1)/2 - -x + (x - y)*-2 + 1/(2/(y^2 + 3)) - 1e-7",
        "f_choice": "choose(x - y, min(x, y), max(x, 2)) + limit(y, -1, 1) + choose(x, 1, 2)*y",
        "f_rows": "first(nodes) + last(values) + line(x, nodes, values) + slope(y, nodes, values)",
        "f_hold": "hold(x, nodes, values) + hold(y, nodes, steps) + pi*scale",
        "f_spline": "spline(x, curve) + spline(x, y, surface)",
        "f_mix": f"mix(rules, gains, {half}, {half}/2) + mix(one_rule, one_gain, x)",
    }
    row = [Decimal(str(k)) for k in (-2, -1, 0, 1, 2)]
    values = [Decimal(text) for text in ("0.1", "-2.5", "1e-3", "7", "-0.25")]
    knots = [Decimal(k) for k in (-2, -2, -2, -2, 0, 2, 2, 2, 2)]
    places = ("nodes", "values", "steps", "curve", "surface", "rules", "gains", "one_rule",
              "one_gain", "scale")  # fmt: skip
    return {
        "format": "takagi-gains",
        "version": Decimal(3),
        "name": "Own law of every function",
        "plant": "own law",
        "law": {"sample_time": None},
        "nodes": row,
        "values": values,
        "steps": values[:-1],
        "curve": {"knots": [knots], "coefficients": values},
        "surface": {
            "knots": [knots, knots],
            "coefficients": [[v * k for v in values] for k in (1, 2, -1, 3, 5)],
        },
        "rules": [[Decimal(0), Decimal(0)], [Decimal(0), Decimal(1)], [Decimal(1), Decimal(0)],
                  [Decimal(1), Decimal(1)]],
        "gains": values[:4],
        "one_rule": [[Decimal(1)]],
        "one_gain": [Decimal("3.5")],
        "scale": "pi/6",
        "one": Decimal("2.5"),
        "states": [],
        "certificate": {"verdict": "PROVED", "sha256": {"gains": "0"}},
        "programs": [
            {
                "name": "law",
                "names": {name: {"value": name, "unit": "-"} for name in places},
                "read": [
                    {"name": name, "unit": "-", "meaning": "measured"} for name in ("x", "y")
                ],
                "keep": [
                    {"name": "sum", "unit": "-", "meaning": "", "start": "mix(rules, gains, x, y)",
                     "next": "sum + sample_time*f_near"}
                ],
                "steps": [
                    *(
                        {"set": name, "unit": "-", "meaning": "", "formula": formula}
                        for name, formula in formulas.items()
                    ),
                    {"set": "f_near", "unit": "-", "meaning": "",
                     "formula": "sin(x)/x + sin(y - 1)/(y - 1)",
                     "near": [
                         {"of": "x", "within": Decimal("1e-4"), "formula": "2 - x^2/6"},
                         {"of": "y - 1", "within": Decimal(0), "formula": "3"},
                     ]},
                ],
                "send": [
                    *(
                        {"name": f"out_{name}", "unit": "-", "meaning": "", "formula": name}
                        for name in (*formulas, "f_near")
                    ),
                    {"name": "out_sum", "unit": "-", "meaning": "", "formula": "sum"},
                ],
            }
        ],
    }  # fmt: skip
