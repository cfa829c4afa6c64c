"""Symbolic sector nonlinearity, from its arguments to the Takagi-Sugeno model."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
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


def _factored_problem(
    f: Plant | Sequence[sp.Expr],
    states: Sequence[sp.Symbol] = (),
    inputs: Sequence[sp.Symbol] = (),
    *,
    rest: Rest = "given",
    domain: Domain | None = None,
    choice: Choice = "fewest-rules",
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    units: Mapping[sp.Symbol, str] | None = None,
    **of_expressions: Any,
) -> tuple[Problem, Factored]:
    """Return the equations about their equilibrium, and f = A x + B u + E w in premise symbols.

    The arguments are those of ``sector_model`` that are not about the bounds of premises.
    """
    if not isinstance(f, Plant):
        return _of_expressions(
            f, states, inputs, domain, choice, premises or {}, units or {}, **of_expressions
        )
    if states or inputs or any(of_expressions.values()):
        raise ModelError(
            "a Plant was given together with states, inputs, box, parameters, matrices or the "
            "like; the plant carries these itself, leave them out"
        )
    problem = problem_of_plant(f, premises, rest, domain)
    if units:
        units = {**problem.equations.units, **units}
        problem = replace(problem, equations=replace(problem.equations, units=units))
    factored = chosen_form(problem, choice)
    if problem.relations and _has_related(problem, factored):
        # Numbers that the equations at rest give from others, as i_rest - u_rest = 0, may vanish.
        related_problem = problem.related()
        related = chosen_form(related_problem, choice)
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


def _of_expressions(
    f: Sequence[sp.Expr],
    states: Sequence[sp.Symbol],
    inputs: Sequence[sp.Symbol],
    domain: Domain | None,
    choice: Choice,
    premises: Mapping[sp.Symbol, sp.Expr],
    units: Mapping[sp.Symbol, str],
    *,
    box: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    disturbances: Sequence[sp.Symbol] = (),
    outputs: Sequence[sp.Expr] = (),
    parameters: Mapping[sp.Symbol, Number] | None = None,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None = None,
    name: str = "",
    source: str = "",
) -> tuple[Problem, Factored]:
    if box is None and domain is None:
        raise ModelError("no box was given; give a range for every variable that matters")
    if len(f) != len(states):
        raise ModelError(f"f has {len(f)} rows, but there are {len(states)} states; give one each")
    values = {symbol: rational(value) for symbol, value in (parameters or {}).items()}
    equations = Equations(
        f=cleaned(f, values),
        states=tuple(states),
        inputs=tuple(inputs),
        disturbances=tuple(disturbances),
        outputs=cleaned(outputs, values),
        units=dict(units),
    )
    asked_premises = dict(zip(premises, cleaned(premises.values(), values), strict=True))
    sides = {symbol: Interval.of(*ends) for symbol, ends in (box or {}).items()}
    variables = [*equations.states, *equations.inputs, *equations.disturbances]
    over = over_box(domain, sides, variables)
    if domain is not None:
        sides |= over.sides(variables)
    bent = None if over.rectangle is not None else over
    problem = Problem(equations, sides, bent, asked_premises, name=name, source=source)
    if matrices is None:
        return problem, chosen_form(problem, choice)
    return problem, _factored_by_hand(equations, asked_premises, matrices, values)


def _factored_by_hand(
    plant: Equations,
    premises: Mapping[sp.Symbol, sp.Expr],
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]],
    values: Mapping[sp.Symbol, sp.Rational],
) -> Factored:
    if set(matrices) - set(LETTERS) or "A" not in matrices:
        raise ModelError(
            f"matrices {', '.join(sorted(matrices)) or 'none'} were given; A is needed, and of "
            "B, C, D, E those that are not zero"
        )
    n, m, p = len(plant.states), len(plant.inputs), len(plant.outputs)
    shapes = {
        "A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "E": (n, len(plant.disturbances)),
    }  # fmt: skip
    letters = {}
    for letter, shape in shapes.items():
        matrix = sp.Matrix(matrices[letter]) if letter in matrices else sp.zeros(*shape)
        if matrix.shape != shape:
            raise ModelError(f"{letter} has shape {matrix.shape}; {shape} is needed")
        letters[letter] = sp.Matrix(*shape, cleaned(list(matrix), values))
    return Factored(letters, premises)


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
    choice: Choice = "fewest-rules",
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
    choice : among exact factored forms, ``"fewest-rules"`` or ``"least-conservative"``.
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
    problem, factored = _factored_problem(
        f,
        states,
        inputs,
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
    problem, factored = _factored_problem(f, states, inputs, **options)
    share = ROUGH if tolerance is None else exact(tolerance)
    return counted(
        bounded_premises(
            problem, factored, BoundsRequest(bounds_given or {}, frozenset(sampled), share)
        )
    )
