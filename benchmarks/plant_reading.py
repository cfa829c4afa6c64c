"""Whether a plant leaves its Takagi-Sugeno model somewhere in its box, by balls at points."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import flint
from second_reading import Data, evaluated, rational

POINTS, BITS = 150, 200
REACH = (Fraction(-1), Fraction(-1, 2), Fraction(1, 10**6), Fraction(1, 2), Fraction(1))


def ball(value: Any) -> Any:
    """Return a ball around an exact number, or around a constant such as "sqrt(2)/3"."""
    if isinstance(value, str):
        try:
            value = rational(value)
        except (ValueError, AttributeError, TypeError):
            return evaluated(value, {}, ball)
    if isinstance(value, Fraction):
        value = flint.fmpq(value.numerator, value.denominator)
    return flint.arb(value)


def why_not_the_plant(document: Data, rng: random.Random) -> str:
    """Return where a premise leaves its bounds or an equation differs; empty if nowhere seen."""
    before, flint.ctx.prec = flint.ctx.prec, BITS
    try:
        model = document["model"]
        why = _wrong_trim(document)
        return why or next(filter(None, (_at_a_point(model, rng) for _ in range(POINTS))), "")
    finally:
        flint.ctx.prec = before


def _wrong_trim(document: Data) -> str:
    law, model = document.get("gains"), document["model"]
    if law is None:
        return ""
    for key, variables in (("state", model["states"]), ("input", model["inputs"])):
        for variable, stated in zip(variables, law["trim"][key], strict=False):
            off = abs(ball(variable["rest"]) - ball(stated))
            if off > ball("1e-11") * (1 + abs(ball(stated))):
                return f"the law rests elsewhere in {variable['name']}"
    return ""


def _at_a_point(model: Data, rng: random.Random) -> str:
    names: dict[str, Any] = {key: ball(value) for key, value in model["parameters"].items()}
    moved: dict[str, list[Any]] = {}
    for key in ("states", "inputs", "disturbances"):
        moved[key] = []
        for variable in model.get(key, []):
            rest, off = ball(variable["rest"]), _drawn(variable, rng)
            moved[key].append(off)
            names[variable["name"]] = rest + off
            if "symbol" in variable and variable["symbol"] != variable["name"]:
                names[variable["symbol"]] = off
    embedding = model["embedding"]
    values: dict[str, Any] = {}
    for premise in embedding["premises"]:
        found = evaluated(premise["expression"], names, ball)
        if not found.is_finite():
            return ""
        if found < ball(premise["lower"]) or found > ball(premise["upper"]):
            return f"premise {premise['name']} is {found}"
        values[premise["name"]] = found
    rates = [_row(embedding, "ABE", i, moved, values) for i in range(len(model["states"]))]
    if model["sample_time"] is not None:
        rests = [ball(v["rest"]) for v in model["states"]]
        rates = [rest + rate for rest, rate in zip(rests, rates, strict=True)]
    if model.get("mass"):
        mass = [[evaluated(entry, names, ball) for entry in row] for row in model["mass"]]
        rates = [sum((m * r for m, r in zip(row, rates, strict=True)), ball(0)) for row in mass]
    for k, (rate, text) in enumerate(zip(rates, model["equations"], strict=True)):
        if not rate.overlaps(evaluated(text, names, ball)):
            return f"equation {k + 1} differs"
    return _outputs_differ(model, names, moved, values)


def _outputs_differ(model: Data, names: Data, moved: Data, values: Data) -> str:
    resting = dict(names)
    for key in moved:
        for variable in model.get(key, []):
            resting[variable["name"]] = ball(variable["rest"])
            if "symbol" in variable:
                resting[variable["symbol"]] = ball(0)
            if ball(variable["rest"]) == 0:
                resting[variable["name"]] = ball(0)
    for k, output in enumerate(model.get("outputs", [])):
        seen = _row(model["embedding"], "CD", k, moved, values)
        there = evaluated(output["expression"], names, ball)
        here = evaluated(output["expression"], resting, ball)
        if here.is_finite() and not seen.overlaps(there - here):
            return f"output {k + 1} differs"
    return ""


def _row(embedding: Data, letters: str, i: int, moved: Data, values: Data) -> Any:
    total = ball(0)
    for letter in letters:
        if letter not in embedding:
            continue
        key = {"A": "states", "C": "states", "E": "disturbances"}.get(letter, "inputs")
        for entry, off in zip(embedding[letter][i], moved[key], strict=True):
            total += evaluated(entry, values, ball) * off
    return total


def _drawn(variable: Data, rng: random.Random) -> Any:
    """Return a deviation from rest: an end, a middle or any point of the range."""
    share = rng.choice((*REACH, Fraction(rng.randrange(-1000, 1001), 1000)))
    if variable.get("range") is None:
        return ball(share * 7)
    low, high = (ball(end) - ball(variable["rest"]) for end in variable["range"])
    return high * ball(share) if share > 0 else low * ball(-share)
