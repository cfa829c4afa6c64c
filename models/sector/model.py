"""The front door of symbolic sector nonlinearity: equations of motion in, TSModel out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, overload

from takagi.models.enclosure.interval import Interval, Number, exact
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant
from takagi.models.premise import Premise
from takagi.models.sector.assemble import LETTERS, Equations, Factored, assemble
from takagi.models.sector.bounding import bounded_premise, check_rule_count
from takagi.models.sector.problem import (
    Problem,
    box_in_fractions,
    cleaned,
    problem_of_plant,
    rational,
)
from takagi.models.ts_model import TSModel

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.sector.choice import Choice
    from takagi.models.sector.rest import Rest

__all__ = ["sector_model"]

MOST_RULES = 1024
ROUGH = Fraction(1, 50)  # excess of bounds that only rank premises


@overload
def sector_model(
    f: Plant,
    *,
    rest: Rest = "given",
    choice: Choice = "fewest-rules",
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    bounds: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    tolerance: Number | None = None,
    most_rules: int = MOST_RULES,
) -> TSModel: ...


@overload
def sector_model(
    f: Sequence[sp.Expr],
    states: Sequence[sp.Symbol],
    inputs: Sequence[sp.Symbol] = (),
    *,
    box: Mapping[sp.Symbol, tuple[Number, Number]],
    disturbances: Sequence[sp.Symbol] = (),
    outputs: Sequence[sp.Expr] = (),
    parameters: Mapping[sp.Symbol, Number] | None = None,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None = None,
    choice: Choice | None = None,
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    bounds: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    units: Mapping[sp.Symbol, str] | None = None,
    tolerance: Number | None = None,
    most_rules: int = MOST_RULES,
    name: str = "",
    source: str = "",
) -> TSModel: ...


def sector_model(
    f: Plant | Sequence[sp.Expr],
    states: Sequence[sp.Symbol] = (),
    inputs: Sequence[sp.Symbol] = (),
    *,
    rest: Rest = "given",
    box: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    disturbances: Sequence[sp.Symbol] = (),
    outputs: Sequence[sp.Expr] = (),
    parameters: Mapping[sp.Symbol, Number] | None = None,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None = None,
    choice: Choice | None = None,
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    bounds: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    units: Mapping[sp.Symbol, str] | None = None,
    tolerance: Number | None = None,
    most_rules: int = MOST_RULES,
    name: str = "",
    source: str = "",
) -> TSModel:
    """Return xdot = f(x, u, w) as sum_i h_i(z) (A_i x + B_i u + E_i w), equal to f on the box.

    Each premise z_k is an expression whose range over the box is enclosed rigorously and rounded
    outward to decimals; the rules are the corners of those ranges.  How the factored form was
    checked to be f is said in ``model.derivation.exactness``.

    Parameters
    ----------
    f : a ``Plant``, which carries all that the arguments up to ``parameters`` and ``units``,
        ``name`` and ``source`` say; its rest values are moved to the origin, so that the model is
        in deviations (``delta_x`` for a variable x that does not rest at 0), and x(t + T) stands
        in the place of xdot where it has a sample time.  Or n expressions; floats in them are
        read as the decimals they print as.
    rest : of a plant: ``"given"`` refuses rest values at which a row does not vanish exactly;
        ``"solve inputs"`` takes those of states and disturbances and solves for the inputs.
    box : a range for every variable that a premise depends on.
    outputs : p expressions in x and u.
    parameters : values put in first.
    matrices : ``{"A": ..., "B": ..., "E": ...}`` (and "C", "D" with outputs) factored by hand,
        with entries in constants and the symbols of ``premises``.
    choice : None takes the one factored form that is found without a search;
        ``"fewest-rules"`` and ``"least-conservative"`` compare several.
    premises : symbol -> expression in states, inputs and disturbances; looked for in the entries
        before others are chosen.
    bounds : exact bounds of some premises, e.g. (0, 1); a bound that an attained value contradicts
        is refused, and the evidence says that the bound was given.
    units : by symbol, also for premises.
    tolerance : excess of a bound, as a share of the premise's range; None takes 1e-3 for a plant
        and 1e-6 for expressions.
    most_rules : more are refused, with the premises ranked by what they cost, before any vertex
        is computed.

    Returns
    -------
    The model; its ``derivation`` tells plant, factored form, premises and bounds in LaTeX, and
    ``premise_values(**point)`` takes the variables by name.

    Raises
    ------
    ModelError : the form is not exact, an entry is not multilinear in the premises, a premise
        cannot be bounded, a variable has no range, the plant does not rest at its rest values, or
        there are too many rules.

    Source: Tanaka and Wang (2001), Fuzzy Control Systems Design and Analysis, section 2.2.
    """
    if tolerance is None:
        tolerance = "1e-3" if isinstance(f, Plant) else "1e-6"
    if isinstance(f, Plant):
        _check_only_plant(
            states, inputs, box, disturbances, outputs, parameters, matrices, units, name, source
        )
        problem = problem_of_plant(f, premises, rest)
        factored = _factored(problem, None, {}, choice or "fewest-rules")
    else:
        values = {symbol: rational(value) for symbol, value in (parameters or {}).items()}
        if box is None:
            raise ModelError("no box was given; give a range for every variable that matters")
        equations = Equations(
            f=cleaned(f, values),
            states=tuple(states),
            inputs=tuple(inputs),
            disturbances=tuple(disturbances),
            outputs=cleaned(outputs, values),
            units=dict(units or {}),
        )
        if len(equations.f) != len(equations.states):
            raise ModelError(
                f"f has {len(equations.f)} rows, but there are {len(equations.states)} states; "
                "give one each"
            )
        wanted = dict(zip(premises or {}, cleaned((premises or {}).values(), values), strict=True))
        sides = {symbol: Interval.of(*ends) for symbol, ends in box.items()}
        problem = Problem(equations, sides, wanted, name=name, source=source)
        factored = _factored(problem, matrices, values, choice)
    return _built(problem, factored, bounds or {}, exact(tolerance), most_rules)


def _check_only_plant(*others: object) -> None:
    if any(bool(other) for other in others):
        raise ModelError(
            "a Plant was given together with states, inputs, box, parameters, matrices or the "
            "like; the plant carries these itself, leave them out"
        )


def _built(
    problem: Problem,
    factored: Factored,
    bounds: Mapping[sp.Symbol, tuple[Number, Number]],
    tolerance: Fraction,
    most_rules: int,
) -> TSModel:
    unknown = sorted(str(symbol) for symbol in bounds if symbol not in factored.premises)
    if unknown:
        known = ", ".join(map(str, factored.premises)) or "none"
        raise ModelError(f"bounds of {', '.join(unknown)} were given; the premises are {known}")

    def members_within(share: Fraction) -> list[Premise]:
        return [
            bounded_premise(symbol, expression, problem, bounds.get(symbol), share)
            for symbol, expression in factored.premises.items()
        ]

    if 2 ** len(factored.premises) > most_rules:
        # Rough bounds tell which premises are constant and rank the others.
        check_rule_count(members_within(max(tolerance, ROUGH)), most_rules)
    members = members_within(tolerance)
    check_rule_count(members, most_rules)
    return assemble(
        problem.equations,
        factored,
        members,
        steps=problem.steps,
        names=problem.names,
        box=box_in_fractions(problem),
        sides=problem.box,
        tell_rules=True,
        name=problem.name,
        source=problem.source,
    )


def _factored(
    problem: Problem,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None,
    values: Mapping[sp.Symbol, sp.Rational],
    choice: Choice | None,
) -> Factored:
    import sympy as sp

    plant, premises = problem.equations, dict(problem.wanted)
    if matrices is None and choice is not None:
        from takagi.models.sector.choice import chosen_form

        return chosen_form(problem, choice)
    if matrices is None:
        from takagi.models.sector.factor import factor

        return _with_premises(factor(plant), premises)
    unknown = set(matrices) - set(LETTERS)
    if unknown or "A" not in matrices:
        raise ModelError(
            f"matrices {', '.join(sorted(matrices)) or 'none'} were given; A is needed, and of "
            "B, C, D, E those that are not zero"
        )
    found = {}
    for letter, shape in _shapes(plant).items():
        matrix = sp.Matrix(matrices[letter]) if letter in matrices else sp.zeros(*shape)
        if matrix.shape != shape:
            raise ModelError(f"{letter} has shape {matrix.shape}; {shape} is needed")
        found[letter] = sp.Matrix(*shape, cleaned(list(matrix), values))
    return Factored(found, premises)


def _shapes(plant: Equations) -> dict[str, tuple[int, int]]:
    n, m, p = len(plant.states), len(plant.inputs), len(plant.outputs)
    return {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "E": (n, len(plant.disturbances))}


def _with_premises(matrices: Mapping[str, sp.Matrix], wanted: dict[sp.Symbol, sp.Expr]) -> Factored:
    """Replace the wanted expressions, then make every entry that is still nonlinear a premise."""
    import sympy as sp

    symbols: dict[sp.Expr, sp.Symbol] = {}
    taken = {symbol.name for symbol in wanted}
    fresh = (s for s in sp.numbered_symbols("z", start=1) if s.name not in taken)

    def entry(expression: sp.Expr) -> sp.Expr:
        written = expression.subs({e: s for s, e in wanted.items()})
        if not written.free_symbols - set(wanted):
            return written
        simplified = sp.simplify(expression)
        if simplified not in symbols:
            symbols[simplified] = next(fresh)
        return symbols[simplified]

    found = {letter: matrix.applyfunc(entry) for letter, matrix in matrices.items()}
    used = {s for matrix in found.values() for s in matrix.free_symbols}
    unused = [str(symbol) for symbol in wanted if symbol not in used]
    if unused:
        raise ModelError(
            f"premise {', '.join(unused)} was not found in the factored entries; give the "
            "matrices factored by hand"
        )
    return Factored(found, {**wanted, **{symbol: e for e, symbol in symbols.items()}})
