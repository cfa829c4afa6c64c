r"""A plant whose outputs follow references: one integral state for each.

    x' = f(x, u, w),   xi_j' = h_j(x) - r_j

The references r_j are signals from outside, known to the law; the xi_j are states of the law.
At an equilibrium with constant r, xi' = 0 means h_j(x) = r_j: there is no steady-state error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.plant.variables import Reference, Variable

if TYPE_CHECKING:
    import sympy as sp


def following_plant(
    plant: Plant, references: Sequence[tuple[Reference, Variable, Variable, sp.Expr]]
) -> Plant:
    """Return the plant with the integral states among its states, the references as signals.

    Parameters
    ----------
    references : reference, its signal r with a range, its integral xi, and h(x) that follows.

    Raises
    ------
    ModelError : discrete time, a mass matrix, a blend, more references than inputs, a followed
        expression with an input or a disturbance.
    """
    name = plant.name
    if plant.sample_time is not None:
        raise ModelError(f"plant {name!r} is of discrete time; references are for x' = f(x, u, w)")
    if plant.mass is not None:
        raise ModelError(
            f"plant {name!r} has a mass matrix; to follow a reference write it as x' = f(x, u, w)"
        )
    if plant.blending is not None:
        raise ModelError(f"plant {name!r} is behind a blend; it follows no reference")
    if len(references) > len(plant.inputs):
        raise ModelError(
            f"plant {name!r}: {len(references)} references and {len(plant.inputs)} inputs; each "
            "reference needs an input of its own"
        )
    states = {v.symbol for v in plant.states}
    allowed = states | {p.symbol for p in plant.parameters}
    for reference, _, _, followed in references:
        strange = sorted(str(s) for s in followed.free_symbols - allowed)
        if strange or not followed.free_symbols & states:
            what = f"depends on {', '.join(strange)}" if strange else "depends on no state"
            raise ModelError(
                f"{reference.follows} {what}; what follows a reference is an expression of states "
                "and known parameters"
            )
    moved = [followed - signal.symbol for _, signal, _, followed in references]
    return replace(
        plant,
        equations=(*plant.equations, *moved),
        states=(*plant.states, *(integral for _, _, integral, _ in references)),
        disturbances=(
            *(_as_it_rests(plant, v) for v in plant.disturbances),
            *(signal for _, signal, _, _ in references),
        ),
        references=tuple(reference for reference, _, _, _ in references),
    )


def _as_it_rests(plant: Plant, variable: Variable) -> Variable:
    """Return an uncertain parameter that moves the rest as one that pushes the state."""
    import sympy as sp

    if not variable.unknown:
        return variable
    at_rest = {
        v.symbol: sp.Rational(*v.rest.as_integer_ratio())
        for v in plant.variables
        if v.symbol != variable.symbol
    }
    at_rest |= {s: sp.Rational(*value.as_integer_ratio()) for s, value in plant.values.items()}
    left = [sp.sympify(row).subs(at_rest) for row in plant.equations]
    moves = any(sp.simplify(row.diff(variable.symbol)) != 0 for row in left)
    return replace(variable, schedules=not moves)
