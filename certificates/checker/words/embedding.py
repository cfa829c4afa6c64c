"""The sentence of a claim that a model, or its slopes, contain the plant."""

from __future__ import annotations

from collections.abc import Collection
from fractions import Fraction

from takagi.certificates.checker.plant.reading import PlantNodes
from takagi.certificates.checker.plant.vertices import corners_of
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly


def embedding_in_words(plant: PlantNodes, removable: Collection[str], off: Fraction) -> str:
    """Return the sentence.

    Parameters
    ----------
    removable : where a quotient means its limit.
    off : how far the law's trim is from the plant's rest.
    """
    count = len(corners_of(plant.premises))
    sentence = "the plant is linear and equals the model exactly"
    if count > 1 and plant.form == "secant":
        sentence = f"differences of the plant from rest are blends of the {count} vertices"
    elif count > 1:
        sentence = f"the plant equals the model of {count} rules exactly"
    sentence += _where(plant)
    if premises := len(plant.premises):
        premise_bounds = (
            "bounds of its premise are"
            if premises == 1
            else f"bounds of its {premises} premises are"
        )
        sentence += f"; the {premise_bounds} proved"
    if plant.mass is not None:
        sentence += "; the mass matrix has no zero determinant there"
    if removable:
        names = ", ".join(sorted(removable))
        sentence += f"; at {names} = 0 a quotient is taken as its limit"
    return sentence + _uncertain(plant) + _balls(plant) + _trim(off)


def _uncertain(plant: PlantNodes) -> str:
    """Return the clause about parameters that are known within a range only."""
    names = [v.name for v in plant.disturbances if v.unknown]
    if not names:
        return ""
    if any(
        plant.graph.value(row[k]) != 0
        for k, v in enumerate(plant.disturbances)
        if v.unknown
        for row in plant.entries.get("E", [])
    ):
        return f"; {', '.join(names)}, unknown to the law, moves the rest and is a disturbance here"
    predicate = "is an uncertain parameter" if len(names) == 1 else "are uncertain parameters"
    return (
        f"; {', '.join(names)} {predicate}, constant or moving in any way in the range, and "
        "unknown to the law"
    )


def _balls(plant: PlantNodes) -> str:
    """Return the clauses about numbers that are not decimals."""
    rests = {v.ball.name: v.name for v in (*plant.states, *plant.inputs) if v.ball}

    def intervals(names: list[str]) -> str:
        balls = [(rests.get(name, name), plant.balls[name]) for name in names]
        return ", ".join(f"{n} = {exactly(b.middle)} +- {exactly(b.radius)}" for n, b in balls)

    solved = list(rests)
    parameters = [name for name in plant.balls if name not in rests]
    clause = f"; its own rest is proved to lie in {intervals(solved)}" if solved else ""
    return clause + (f"; with {intervals(parameters)}" if parameters else "")


def _where(plant: PlantNodes) -> str:
    """Return the box, rounded inward, so that the sentence claims no more than was proved."""
    box = ", ".join(
        f"{v.label} in [{at_most(v.side[0], 15)}, {at_least(v.side[1], 15)}]"
        for v in (*plant.states, *plant.inputs, *plant.disturbances)
        if v.side is not None
    )
    return f" where {box}" if box else " everywhere"


def _trim(off: Fraction) -> str:
    if not off:
        return ""
    return f"; the claims are about the exact trim, which the law has to {at_most(off, 2)}"
