"""A model of a plant's slopes, for gains that need no measured premise."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.ts.model import Derivation, TSModel

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.equations.problem import Problem
    from takagi.models.plant.design_settings import Rest

MOST_RULES, TOLERANCE = 1024, Fraction(1, 1000)  # of the model; of a premise's bounds


def secant_model(plant: Plant, *, rest: Rest = "given") -> TSModel:
    """Return vertices of [A B E] such that f(x, u, w) - f* is a blend of them times deviations.

    Each slope of f that varies over the box is a premise of its own (or the multiple of one), whose
    mean along the segment from rest lies in its range.  The weights move freely and no law can have
    them: certify it with one gain for all rules.  Other than a sector model it holds with the same
    vertices between any two points of the box, so also about other points of rest in it.

    ``rest`` : as of ``sector_model``.

    Raises
    ------
    ModelError : a mass matrix, an absolute value, a slope that cannot be bounded, too many rules.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 4.3 (recalled).
    """
    import sympy as sp

    from takagi.models.equations.equations import Factored
    from takagi.models.equations.problem import box_in_fractions, problem_of_plant
    from takagi.models.sector.assembly import vertex_product
    from takagi.models.sector.premise_bounds import BoundsRequest, counted_premises
    from takagi.models.ts.model import SymbolicForm

    if plant.mass is not None:
        raise ModelError(f"plant {plant.name!r} has a mass matrix; write it as x' = f(x, u, w)")
    problem = problem_of_plant(plant, {}, rest)
    slopes = _slopes(problem, plant)
    if any(entry.has(sp.Abs, sp.sign) for matrix in slopes.values() for entry in matrix):
        raise ModelError(f"plant {plant.name!r} has an absolute value, whose slope jumps")
    premises: dict[sp.Expr, sp.Symbol] = {}
    stem = _free_stem(plant, problem)
    matrices = {
        letter: sp.Matrix(*matrix.shape, [_named(entry, premises, stem) for entry in matrix])
        for letter, matrix in slopes.items()
    }
    factored = Factored(matrices, {symbol: slope for slope, symbol in premises.items()})
    request = BoundsRequest({}, frozenset(), TOLERANCE)
    members = counted_premises(problem, factored, request, MOST_RULES)
    corners = [member.corners for member in members]
    products: dict[str, Any] = {
        letter: vertex_product(matrix, list(factored.premises), corners, letter=letter)
        for letter, matrix in matrices.items()
        if letter == "A" or 0 not in matrix.shape
    }
    names: dict[str, Any] = dict(problem.names or {})
    return TSModel(
        **products,
        **names,
        premises=members,
        box=box_in_fractions(problem),
        sample_time=plant.sample_time,
        name=plant.name,
        source=plant.source,
        derivation=Derivation((), form=SymbolicForm(plant, problem, factored, "secant")),
    )


def _slopes(problem: Problem, plant: Plant) -> dict[str, sp.Matrix]:
    import sympy as sp

    equations = problem.equations
    f, y = sp.Matrix(equations.f), sp.Matrix(len(equations.outputs), 1, list(equations.outputs))

    def by(rows: sp.Matrix, symbols: tuple[sp.Symbol, ...]) -> sp.Matrix:
        return rows.jacobian(symbols) if rows and symbols else sp.zeros(rows.rows, len(symbols))

    pushed = by(f, equations.disturbances)
    for column, variable in enumerate(plant.disturbances):
        if variable.unknown and variable.schedules and pushed:
            # Such a signal does not move the rest: differences between two points at one of its
            # values are blends of slopes in states and inputs alone.
            pushed[:, column] = sp.zeros(pushed.rows, 1)
    return {
        "A": by(f, equations.states),
        "B": by(f, equations.inputs),
        "E": pushed,
        "C": by(y, equations.states),
        "D": by(y, equations.inputs),
    }


def _free_stem(plant: Plant, problem: Problem) -> str:
    """Return s, or the first of s_, s__, ... that begins no name s1, s2, ... of the plant."""
    equations = problem.equations
    symbols = {*equations.states, *equations.inputs, *equations.disturbances}
    symbols |= {variable.symbol for variable in (*plant.states, *plant.inputs, *plant.disturbances)}
    symbols |= {parameter.symbol for parameter in plant.parameters}
    names = {symbol.name for symbol in symbols} | {output.name for output in plant.outputs}
    stem = "s"
    while any(name.removeprefix(stem).isdigit() and name.startswith(stem) for name in names):
        stem += "_"
    return stem


def _named(slope: sp.Expr, premises: dict[sp.Expr, sp.Symbol], stem: str) -> sp.Expr:
    """Return a slope as number + number * premise; the premise is made if it is not known."""
    import sympy as sp

    constant, varying = sp.expand(slope).as_independent(*slope.free_symbols, as_Add=True)
    if not slope.free_symbols:
        return slope
    factor, bare = varying.as_content_primitive()
    if bare not in premises and -bare in premises:
        factor, bare = -factor, -bare
    symbol = premises.setdefault(bare, sp.Symbol(f"{stem}{len(premises) + 1}", real=True))
    return constant + factor * symbol
