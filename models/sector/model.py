"""Symbolic sector nonlinearity, from its arguments to the Takagi-Sugeno model."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import sympy as sp

from takagi.models.equations.equations import Equations, Factored
from takagi.models.equations.problem import (
    Problem,
    box_in_fractions,
    cleaned,
    over_box,
    problem_of_plant,
)
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact, rational
from takagi.models.plant.plant import Plant
from takagi.models.sector.assembly import LETTERS, assemble, domain_steps
from takagi.models.sector.choice import chosen_form
from takagi.models.sector.premise_bounds import (
    ROUGH,
    BoundsRequest,
    RuleCount,
    StatedBounds,
    bounded_premises,
    counted,
    counted_premises,
)
from takagi.models.ts.model import SymbolicForm, TSModel

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import Choice, Rest
    from takagi.models.ranges.domain import Domain


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GivenEquations:
    """The arguments of ``sector_model`` about the equations, not about the bounds of premises."""

    f: Plant | Sequence[sp.Expr]
    states: Sequence[sp.Symbol] = ()
    inputs: Sequence[sp.Symbol] = ()
    rest: Rest = "given"
    box: Mapping[sp.Symbol, tuple[Number, Number]] | None = None
    domain: Domain | None = None
    disturbances: Sequence[sp.Symbol] = ()
    outputs: Sequence[sp.Expr] = ()
    parameters: Mapping[sp.Symbol, Number] | None = None
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None = None
    choice: Choice | None = None
    premises: Mapping[sp.Symbol, sp.Expr] | None = None
    units: Mapping[sp.Symbol, str] | None = None
    name: str = ""
    source: str = ""


# The members of ``GivenEquations`` that a ``Plant`` has itself.
OF_PLANT = (
    "states",
    "inputs",
    "box",
    "disturbances",
    "outputs",
    "parameters",
    "matrices",
    "name",
    "source",
)


def factored_problem(arguments: GivenEquations) -> tuple[Problem, Factored]:
    """Return the equations about their equilibrium, and f = A x + B u + E w in premise symbols.

    Raises
    ------
    ModelError : as ``sector_model``.
    """
    if isinstance(arguments.f, Plant):
        return _of_plant(arguments.f, arguments)
    return _of_expressions(arguments.f, arguments)


def _of_plant(plant: Plant, arguments: GivenEquations) -> tuple[Problem, Factored]:
    if any(bool(getattr(arguments, name)) for name in OF_PLANT):
        raise ModelError(
            "a Plant was given together with states, inputs, box, parameters, matrices or the "
            "like; the plant carries these itself, leave them out"
        )
    problem = problem_of_plant(plant, arguments.premises, arguments.rest, arguments.domain)
    if arguments.units:
        units = {**problem.equations.units, **arguments.units}
        problem = replace(problem, equations=replace(problem.equations, units=units))
    choice = arguments.choice or "fewest-rules"
    factored = _factored(problem, None, {}, choice)
    if problem.relations and _has_related(problem, factored):
        # Numbers that the equations at rest give from others, as i_rest - u_rest = 0, may vanish.
        related_problem = problem.related()
        related = _factored(related_problem, None, {}, choice)
        if _cost(related) < _cost(factored):
            return related_problem, related
    return problem, factored


def _has_related(problem: Problem, factored: Factored) -> bool:
    """Return whether a number that others give stands in the form."""
    expressions = [*factored.premises.values(), *(n.expression for n in factored.numbers.values())]
    return any(
        not expression.free_symbols.isdisjoint(problem.relations) for expression in expressions
    )


def _cost(factored: Factored) -> tuple[int, int]:
    return len(factored.premises), len(factored.numbers)


def _of_expressions(f: Sequence[sp.Expr], arguments: GivenEquations) -> tuple[Problem, Factored]:
    values = {symbol: rational(value) for symbol, value in (arguments.parameters or {}).items()}
    if arguments.box is None and arguments.domain is None:
        raise ModelError("no box was given; give a range for every variable that matters")
    equations = Equations(
        f=cleaned(f, values),
        states=tuple(arguments.states),
        inputs=tuple(arguments.inputs),
        disturbances=tuple(arguments.disturbances),
        outputs=cleaned(arguments.outputs, values),
        units=dict(arguments.units or {}),
    )
    if len(equations.f) != len(equations.states):
        raise ModelError(
            f"f has {len(equations.f)} rows, but there are {len(equations.states)} states; "
            "give one each"
        )
    premises = arguments.premises or {}
    asked_premises = dict(zip(premises, cleaned(premises.values(), values), strict=True))
    sides = {symbol: Interval.of(*ends) for symbol, ends in (arguments.box or {}).items()}
    variables = [*equations.states, *equations.inputs, *equations.disturbances]
    over = over_box(arguments.domain, sides, variables)
    if arguments.domain is not None:
        sides |= over.sides(variables)
    bent = None if over.rectangle is not None else over
    problem = Problem(
        equations, sides, bent, asked_premises, name=arguments.name, source=arguments.source
    )
    return problem, _factored(problem, arguments.matrices, values, arguments.choice)


def _factored(
    problem: Problem,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None,
    values: Mapping[sp.Symbol, sp.Rational],
    choice: Choice | None,
) -> Factored:
    plant, premises = problem.equations, dict(problem.premises)
    if matrices is None and choice is not None:
        return chosen_form(problem, choice)
    if matrices is None:
        return _with_premises(factor(plant), premises)
    unknown = set(matrices) - set(LETTERS)
    if unknown or "A" not in matrices:
        raise ModelError(
            f"matrices {', '.join(sorted(matrices)) or 'none'} were given; A is needed, and of "
            "B, C, D, E those that are not zero"
        )
    letters = {}
    for letter, shape in _shapes(plant).items():
        matrix = sp.Matrix(matrices[letter]) if letter in matrices else sp.zeros(*shape)
        if matrix.shape != shape:
            raise ModelError(f"{letter} has shape {matrix.shape}; {shape} is needed")
        letters[letter] = sp.Matrix(*shape, cleaned(list(matrix), values))
    return Factored(letters, premises)


def _shapes(plant: Equations) -> dict[str, tuple[int, int]]:
    n, m, p = len(plant.states), len(plant.inputs), len(plant.outputs)
    return {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "E": (n, len(plant.disturbances))}


def _with_premises(
    matrices: Mapping[str, sp.Matrix], asked_premises: dict[sp.Symbol, sp.Expr]
) -> Factored:
    """Replace the wanted expressions, then make every entry that is still nonlinear a premise."""
    symbols: dict[sp.Expr, sp.Symbol] = {}
    names = {symbol.name for symbol in asked_premises}
    fresh = (s for s in sp.numbered_symbols("z", start=1) if s.name not in names)

    def entry(expression: sp.Expr) -> sp.Expr:
        written = expression.subs({e: s for s, e in asked_premises.items()})
        if not written.free_symbols - set(asked_premises):
            return written
        simplified = sp.simplify(expression)
        if simplified not in symbols:
            symbols[simplified] = next(fresh)
        return symbols[simplified]

    written_matrices = {letter: matrix.applyfunc(entry) for letter, matrix in matrices.items()}
    symbols_used = {s for matrix in written_matrices.values() for s in matrix.free_symbols}
    unused = [str(symbol) for symbol in asked_premises if symbol not in symbols_used]
    if unused:
        raise ModelError(
            f"premise {', '.join(unused)} was not found in the factored entries; give the "
            "matrices factored by hand"
        )
    return Factored(
        written_matrices, {**asked_premises, **{symbol: e for e, symbol in symbols.items()}}
    )


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


MOST_RULES = 1024


def sector_model(
    f: Plant | Sequence[sp.Expr],
    states: Sequence[sp.Symbol] = (),
    inputs: Sequence[sp.Symbol] = (),
    *,
    rest: Rest = "given",
    box: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    domain: Domain | None = None,
    disturbances: Sequence[sp.Symbol] = (),
    outputs: Sequence[sp.Expr] = (),
    parameters: Mapping[sp.Symbol, Number] | None = None,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None = None,
    choice: Choice | None = None,
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    bounds: Mapping[sp.Symbol, StatedBounds] | None = None,
    sampled_bounds: Collection[sp.Symbol] = (),
    units: Mapping[sp.Symbol, str] | None = None,
    tolerance: Number | None = None,
    most_rules: int = MOST_RULES,
    name: str = "",
    source: str = "",
) -> TSModel:
    """Return xdot = f(x, u, w) as sum_i h_i(z) (A_i x + B_i u + E_i w), equal to f on the box.

    Each premise z_k is an expression whose range over the box is enclosed rigorously and rounded
    outward to decimals; the rules are the corners of those ranges.  ``model.derivation.exactness``
    says how the factored form was checked to equal f.

    Parameters
    ----------
    f : a ``Plant``, which replaces the arguments up to ``parameters``, and ``name`` and
        ``source``; its equilibrium is moved to the origin, so that the model is in deviations
        (``delta_x`` for a variable x whose equilibrium is not 0), and x(t + T) replaces xdot where
        it has a sample time.  Or n expressions; floats in them are read as the decimals they print
        as.
    rest : of a plant: ``"given"`` refuses rest values at which a row does not vanish exactly;
        ``"solve inputs"`` takes those of states and disturbances and solves for the inputs.
    box : a range for every variable that a premise depends on.
    domain : a band around a trim curve or a union of cells, in the variables of f; those that it
        does not name keep their ranges.  The model then equals f on the domain, not on the
        whole box: ``model.domain`` keeps it, and ``model.box`` is only drawn around it.
    outputs : p expressions in x and u.
    parameters : values put in first.
    matrices : ``{"A": ..., "B": ..., "E": ...}`` (and "C", "D" with outputs) factored by hand,
        with entries in constants and the symbols of ``premises``.
    choice : None takes the one factored form that is found without a search;
        ``"fewest-rules"`` and ``"least-conservative"`` compare several.
    premises : symbol -> expression in states, inputs and disturbances; looked for in the entries
        before others are chosen.
    bounds : exact bounds of some premises, e.g. (0, 1), or what ``enclosure.sampled_bounds`` found.
        A bound that an attained value contradicts is refused; the evidence says that it was given,
        and by how much it misses a proof, if it does.
    sampled_bounds : premises that are bounded by 10 000 samples, widened by a hundredth of their
        width, and NOT PROVED; for functions that cannot be enclosed.  ``model.sampled`` names
        them, and ``certify`` refuses the model.
    units : by symbol, also for premises; of a ``Plant`` those of given premises.
    tolerance : excess of a bound, as a share of the premise's range; None takes 1e-3 for a plant
        and 1e-6 for expressions.
    most_rules : more are refused, with the premises ranked by what they cost, before any vertex
        is computed; ``rule_count`` gives their number.

    Returns
    -------
    The model; its ``derivation`` tells plant, factored form, premises and bounds in LaTeX, and
    ``premise_values(**point)`` takes the variables by name.

    Raises
    ------
    ModelError : the form is not exact, an entry is not multilinear in the premises, a premise
        cannot be bounded, a variable has no range, the rest values are not an equilibrium of the
        plant, or there are too many rules.

    Source: Tanaka and Wang (2001), Fuzzy Control Systems Design and Analysis, section 2.2.
    """
    if tolerance is None:
        tolerance = "1e-3" if isinstance(f, Plant) else "1e-6"
    arguments = GivenEquations(
        f=f,
        states=states,
        inputs=inputs,
        rest=rest,
        box=box,
        domain=domain,
        disturbances=disturbances,
        outputs=outputs,
        parameters=parameters,
        matrices=matrices,
        choice=choice,
        premises=premises,
        units=units,
        name=name,
        source=source,
    )
    problem, factored = factored_problem(arguments)
    bounds_request = BoundsRequest(bounds or {}, frozenset(sampled_bounds), exact(tolerance))
    members = counted_premises(problem, factored, bounds_request, most_rules)
    return assemble(
        problem.equations,
        factored,
        members,
        steps=(*problem.steps, *domain_steps(problem.domain)),
        names=problem.names,
        box=box_in_fractions(problem),
        sides=problem.sides,
        form=SymbolicForm(f if isinstance(f, Plant) else None, problem, factored),
        tell_rules=True,
        name=problem.name,
        source=problem.source,
    )


def rule_count(
    f: Plant | Sequence[sp.Expr],
    states: Sequence[sp.Symbol] = (),
    inputs: Sequence[sp.Symbol] = (),
    **options: Any,
) -> RuleCount:
    """Return how many rules ``sector_model`` would make of the same arguments, and why.

    No vertex is computed; bounds are proved, but looser than the model's: each end exceeds the
    premise's range by up to a fiftieth of its width.

    Parameters
    ----------
    options : any of ``sector_model`` but ``most_rules``.

    Raises
    ------
    ModelError : as ``sector_model``, but not for too many rules.
    """
    bounds_given, sampled = options.pop("bounds", None), options.pop("sampled_bounds", ())
    tolerance = options.pop("tolerance", None)
    problem, factored = factored_problem(
        GivenEquations(f=f, states=states, inputs=inputs, **options)
    )
    share = ROUGH if tolerance is None else exact(tolerance)
    return counted(
        bounded_premises(
            problem, factored, BoundsRequest(bounds_given or {}, frozenset(sampled), share)
        )
    )
