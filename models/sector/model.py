"""Symbolic sector nonlinearity, from a plant to the Takagi-Sugeno model."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import sympy as sp

from takagi.models.equations.equations import Factored
from takagi.models.equations.problem import Problem, box_in_fractions, problem_of_plant
from takagi.models.intervals.interval import Number, exact
from takagi.models.plant.plant import Plant
from takagi.models.sector.assembly import assemble, domain_steps
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
    from takagi.models.ranges.expression_range import Domain


def _factored_problem(
    plant: Plant,
    *,
    rest: Rest = "given",
    domain: Domain | None = None,
    choice: Choice = "fewest-rules",
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    units: Mapping[sp.Symbol, str] | None = None,
) -> tuple[Problem, Factored]:
    """Return the equations about their equilibrium, and f = A x + B u + E w in premise symbols."""
    problem = problem_of_plant(plant, premises, rest, domain)
    if units:
        units = {**problem.equations.units, **units}
        problem = replace(problem, equations=replace(problem.equations, units=units))
    factored = chosen_form(problem, choice)
    numbers = [*factored.premises.values(), *(n.expression for n in factored.numbers.values())]
    if any(not number.free_symbols.isdisjoint(problem.relations) for number in numbers):
        # Numbers that the equations at rest give from others, as i_rest - u_rest = 0, may vanish.
        related_problem = problem.related()
        related = chosen_form(related_problem, choice)
        if _cost(related) < _cost(factored):
            return related_problem, related
    return problem, factored


def _cost(factored: Factored) -> tuple[int, int]:
    return len(factored.premises), len(factored.numbers)


MOST_RULES = 1024
TOLERANCE = "1e-3"  # excess of a bound, as a share of the premise's range


def sector_model(
    plant: Plant,
    *,
    rest: Rest = "given",
    domain: Domain | None = None,
    choice: Choice = "fewest-rules",
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    bounds: Mapping[sp.Symbol, StatedBounds] | None = None,
    sampled_bounds: Collection[sp.Symbol] = (),
    units: Mapping[sp.Symbol, str] | None = None,
    tolerance: Number = TOLERANCE,
    most_rules: int = MOST_RULES,
) -> TSModel:
    """Return xdot = f(x, u, w) as sum_i h_i(z) (A_i x + B_i u + E_i w), equal to f on the box.

    Each premise z_k is an expression whose range over the box is enclosed rigorously and rounded
    outward to decimals; the rules are the corners of those ranges.  ``model.derivation.exactness``
    says how the factored form was checked to equal f.

    Parameters
    ----------
    plant : its equilibrium is moved to the origin, so that the model is in deviations (``delta_x``
        for a variable x whose equilibrium is not 0), and x(t + T) replaces xdot where it has a
        sample time.  Floats in its equations are read as the decimals they print as.
    rest : ``"given"`` refuses rest values at which a row does not vanish exactly;
        ``"solve inputs"`` takes those of states and disturbances and solves for the inputs.
    domain : a band around a trim curve or a union of cells, in the plant's variables; those that it
        does not name keep their ranges.  The model then equals f on the domain, not on the
        whole box: ``model.domain`` keeps it, and ``model.box`` is only drawn around it.
    choice : among exact factored forms, ``"fewest-rules"`` or ``"least-conservative"``.
    premises : symbol -> expression in states, inputs and disturbances; looked for in the entries
        before others are chosen.
    bounds : exact bounds of some premises, e.g. (0, 1), or what ``enclosure.sampled_bounds`` found.
        A bound that an attained value contradicts is refused; the evidence says that it was given,
        and by how much it misses a proof, if it does.
    sampled_bounds : premises that are bounded by 10 000 samples, widened by a hundredth of their
        width, and NOT PROVED; for functions that cannot be enclosed.  ``model.sampled`` names
        them, and ``certify`` refuses the model.
    units : by symbol, of given premises.
    tolerance : excess of a bound, as a share of the premise's range.
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
    problem, factored = _factored_problem(
        plant, rest=rest, domain=domain, choice=choice, premises=premises, units=units
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
        form=SymbolicForm(plant, problem, factored),
        name=problem.name,
        source=problem.source,
    )


def rule_count(plant: Plant, **options: Any) -> RuleCount:
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
    problem, factored = _factored_problem(plant, **options)
    share = ROUGH if tolerance is None else exact(tolerance)
    return counted(
        bounded_premises(
            problem, factored, BoundsRequest(bounds_given or {}, frozenset(sampled), share)
        )
    )
