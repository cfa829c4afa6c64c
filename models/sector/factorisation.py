"""Writing f(x, u, w) with f(0, 0, 0) = 0 as A(x) x + B(x) u + E(x) w."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.equations.equations import Equations


def factor(plant: Equations) -> dict[str, sp.Matrix]:
    """Return A, B, C, D, E in the plant's own variables with f = A x + B u + E w, y = C x + D u.

    Inputs and disturbances must enter linearly.  Of what is left each term goes to one state: to
    the last one that it has as a factor (x_2^2 sin(x_1) becomes x_2 sin(x_1) times x_2), else to
    the first one whose vanishing makes it vanish (sin(x_1) becomes sin(x_1)/x_1 times x_1, a
    removable singularity).  Another choice gives another exact model; to choose, factor by hand.

    Raises
    ------
    ModelError : an input that enters nonlinearly, or a term that does not vanish with any state.
    """
    import sympy as sp

    exogenous = (*plant.inputs, *plant.disturbances)
    A, by_input = _rows(plant.f, plant, exogenous)
    C, by_output = _rows(plant.outputs, plant, exogenous)
    split = len(plant.inputs)
    if any(entry != 0 for entry in by_output[:, split:]):
        raise ModelError("an output depends on a disturbance; y = C x + D u has no such term")
    return {
        "A": A,
        "B": by_input[:, :split],
        "E": by_input[:, split:],
        "C": C,
        "D": sp.Matrix(by_output[:, :split]),
    }


def _rows(
    expressions: tuple[sp.Expr, ...], plant: Equations, exogenous: tuple[sp.Symbol, ...]
) -> tuple[sp.Matrix, sp.Matrix]:
    import sympy as sp

    by_state = sp.zeros(len(expressions), len(plant.states))
    by_exogenous = sp.zeros(len(expressions), len(exogenous))
    nothing = dict.fromkeys(exogenous, 0)
    for row, expression in enumerate(expressions):
        for column, symbol in enumerate(exogenous):
            slope = sp.simplify(expression.diff(symbol))
            if slope.has(*exogenous):
                raise ModelError(
                    f"row {row + 1}: {symbol} enters nonlinearly (its coefficient is {slope}); "
                    "give A, B and E factored by hand"
                )
            by_exogenous[row, column] = slope
        for term in sp.Add.make_args(sp.expand(expression.subs(nothing))):
            column, coefficient = _assigned(term, plant.states, row)
            by_state[row, column] += coefficient
    return by_state, by_exogenous


def _assigned(term: sp.Expr, states: tuple[sp.Symbol, ...], row: int) -> tuple[int, sp.Expr]:
    """Return the state that a term goes to, and its coefficient."""
    if term == 0:
        return 0, term
    powers = term.as_powers_dict()
    for column in reversed(range(len(states))):
        exponent = powers.get(states[column], 0)
        if exponent.is_Integer and exponent >= 1 if exponent else False:
            return column, term / states[column]
    for column, state in enumerate(states):
        if term.has(state) and term.limit(state, 0) == 0:
            return column, term / state
    raise ModelError(
        f"row {row + 1}: the term {term} does not vanish with any state, so it cannot be written "
        "as a coefficient times a state; move the equilibrium to the origin (x - x*), or give A "
        "factored by hand"
    )
