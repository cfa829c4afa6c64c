"""Symbolic sector nonlinearity: from equations of motion to a Takagi-Sugeno model."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from takagi.models.equations.problem import box_in_fractions
from takagi.models.intervals.interval import Number, exact
from takagi.models.plant.plant import Plant
from takagi.models.sector.arguments import GivenEquations, factored_problem
from takagi.models.sector.assembly import assemble, domain_steps
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
    import sympy as sp

    from takagi.models.plant.design_settings import Choice, Rest
    from takagi.models.ranges.domain import Domain

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
