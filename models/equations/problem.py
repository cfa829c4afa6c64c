"""What a model is derived from: equations that vanish at the origin, box, names, premises."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.equations.equations import Equations
from takagi.models.equations.equilibrium import (
    RESTS,
    EquilibriumOption,
    check_equilibrium,
    inputs_at_equilibrium,
)
from takagi.models.equations.premise_units import units_of
from takagi.models.equations.step import Step
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.plant.plant import Plant
from takagi.models.plant.variables import Variable
from takagi.models.ranges.domain import Domain

if TYPE_CHECKING:
    import sympy as sp


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Equations in deviations from the equilibrium, and all that a model of them needs besides.

    Attributes
    ----------
    box : range of each variable that a premise may depend on, in deviations.
    domain : where bounds shall hold if that is less than the box (a band, a union of cells), in
        deviations; None for the box.
    wanted : premises fixed by the user.
    names : states, inputs, outputs, disturbances; None names them by symbol and unit.
    steps : how the equations came from the plant's, for the derivation.
    rest : the plant's variables at the equilibrium, which its deviations are taken from.
    """

    equations: Equations
    box: Mapping[sp.Symbol, Interval]
    domain: Domain | None = None
    wanted: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    names: Mapping[str, Sequence[str]] | None = None
    steps: tuple[Step, ...] = ()
    rest: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    name: str = ""
    source: str = ""

    @property
    def where(self) -> Domain:
        """Where bounds shall hold."""
        return Domain.of_box(self.box) if self.domain is None else self.domain


def problem_of_plant(
    plant: Plant,
    premises: Mapping[sp.Symbol, sp.Expr] | None,
    how: EquilibriumOption = "given",
    domain: Domain | None = None,
) -> Problem:
    """Return the plant with its parameters' values, explicit in x', in deviations from its rest.

    A variable that rests at 0 keeps its symbol; another one, x, is replaced by x* + delta_x.

    Parameters
    ----------
    premises : in the plant's own variables; None takes those of the plant.
    how : ``"given"`` takes the rest values of the plant; ``"solve inputs"`` those of states and
        disturbances, and solves for the inputs.
    domain : in the plant's own variables; those that it does not name keep their ranges.

    Raises
    ------
    ModelError : the rest values are no equilibrium of the plant, an output depends on more than
        states and inputs, the mass matrix may be singular on the domain, or the domain speaks of
        symbols that are no variables.
    """
    import sympy as sp

    values = {symbol: rational(value) for symbol, value in plant.values.items()}
    f = cleaned(plant.equations, values)
    seen = cleaned((y.expression for y in plant.outputs), values)
    given = plant.premises if premises is None else premises
    wanted = dict(zip(given, cleaned(given.values(), values), strict=True))
    over = over_box(domain, plant.box, [v.symbol for v in plant.variables])
    if plant.mass is None:
        steps: tuple[Step, ...] = ()
    else:
        from takagi.models.equations.mass_matrix import explicit

        mass = sp.Matrix(*plant.mass.shape, cleaned(list(plant.mass), values))
        f, steps = explicit(mass, f, plant, over)
    if how not in RESTS:
        raise ModelError(f"rest={how!r} was given; {' or '.join(map(repr, RESTS))} is known")
    rest: dict[sp.Symbol, sp.Expr] = {v.symbol: rational(v.rest) for v in plant.variables}
    if plant.sample_time is not None:
        f = tuple(row - rest[v.symbol] for row, v in zip(f, plant.states, strict=True))
    if how == "solve inputs":
        rest |= inputs_at_equilibrium(plant, f, rest)
    check_equilibrium(plant, f, rest, how)
    deviation = _deviation_symbols(plant, rest, wanted)
    moved = {s: rest[s] + deviation[s] for s in rest}
    offsets = [y.subs(rest) for y in seen]
    over = over.moved({s: (deviation[s], rest[s]) for s in rest})
    equations = Equations(
        f=tuple(row.subs(moved, simultaneous=True) for row in f),
        states=tuple(deviation[v.symbol] for v in plant.states),
        inputs=tuple(deviation[v.symbol] for v in plant.inputs),
        disturbances=tuple(deviation[v.symbol] for v in plant.disturbances),
        outputs=tuple(
            y.subs(moved, simultaneous=True) - offset
            for y, offset in zip(seen, offsets, strict=True)
        ),
        units={deviation[v.symbol]: v.unit for v in plant.variables} | units_of(plant, given),
        sample_time=plant.sample_time,
        scheduling=tuple(deviation[v.symbol] for v in plant.disturbances if v.schedules),
    )
    return Problem(
        equations,
        box=over.sides(deviation.values()),
        domain=over if over.rectangle is None else None,
        wanted={s: e.subs(moved, simultaneous=True) for s, e in wanted.items()},
        names={
            "states": equations.named(equations.states),
            "inputs": equations.named(equations.inputs),
            "outputs": tuple(
                _output_label(y.name, y.unit, offset)
                for y, offset in zip(plant.outputs, offsets, strict=True)
            ),
            "disturbances": equations.named(equations.disturbances),
        },
        steps=(*steps, *_rest_steps(rest, deviation)),
        rest=rest,
        name=plant.name,
        source=plant.source,
    )


def rational(value: Number) -> sp.Rational:
    """Return the number as sympy's rational, floats by their shortest decimal."""
    import sympy as sp

    return sp.Rational(*exact(value).as_integer_ratio())


def cleaned(
    expressions: Iterable[sp.Expr], values: Mapping[sp.Symbol, sp.Rational]
) -> tuple[sp.Expr, ...]:
    """Return the expressions with parameters put in and floats as rationals."""
    import sympy as sp

    found = []
    for expression in expressions:
        whole = sp.sympify(expression).subs(values)
        floats = {number: rational(float(number)) for number in whole.atoms(sp.Float)}
        found.append(whole.xreplace(floats))
    return tuple(found)


def _deviation_symbols(
    plant: Plant, rest: Mapping[sp.Symbol, sp.Expr], wanted: Mapping[sp.Symbol, sp.Expr]
) -> dict[sp.Symbol, sp.Symbol]:
    import sympy as sp

    taken = {v.name for v in plant.variables} | {str(s) for s in wanted}

    def symbol(variable: Variable) -> sp.Symbol:
        if rest[variable.symbol] == 0:
            return variable.symbol
        name = f"delta_{variable.name}"
        if name in taken:
            raise ModelError(
                f"plant {plant.name!r}: the deviation of {variable.name} from its rest is called "
                f"{name}, which is another name of the plant; rename that one"
            )
        return sp.Symbol(name, real=True)

    return {v.symbol: symbol(v) for v in plant.variables}


def over_box(
    domain: Domain | None, box: Mapping[sp.Symbol, Interval], variables: Sequence[sp.Symbol]
) -> Domain:
    """Return the domain, with the box for the variables that it does not name.

    Raises
    ------
    ModelError : a symbol of the domain that is neither a variable nor used by a place.
    """
    if domain is None:
        return Domain.of_box(box)
    for cell in domain.cells:
        used = {s for place in cell.places.values() for s in place.free_symbols}
        strange = [s for s in cell.box if s not in variables and s not in used]
        strange += [s for s in cell.places if s not in variables]
        if strange:
            twin = next((v for v in variables if v.name == strange[0].name), None)
            raise ModelError(
                f"the domain speaks of {', '.join(sorted(map(str, strange)))}; the variables are "
                + ", ".join(map(str, variables))
                + ("" if twin is None else " (symbols declared otherwise are others: real=True?)")
            )
    return domain.within(box)


def _rest_steps(
    rest: Mapping[sp.Symbol, sp.Expr], deviation: Mapping[sp.Symbol, sp.Symbol]
) -> tuple[Step, ...]:
    import sympy as sp

    moved = [
        rf"{sp.latex(deviation[s])} = {sp.latex(s)} - {sp.latex(value, fold_short_frac=True)}"
        if not value.is_Add and not value.could_extract_minus_sign()
        else rf"{sp.latex(deviation[s])} = {sp.latex(s)} - \left({sp.latex(value)}\right)"
        for s, value in rest.items()
        if value != 0
    ]
    if not moved:
        return ()
    return (Step("Deviations from rest.", r",\quad ".join(moved)),)


def _output_label(name: str, unit: str, offset: sp.Expr) -> str:
    return f"{name} [{unit}]" if offset == 0 else f"delta_{name} [{unit}]"


def box_in_fractions(problem: Problem) -> dict[str, tuple[Fraction, Fraction]]:
    """Return label -> (lower, upper), as a ``TSModel`` keeps its box."""
    return {
        problem.equations.named([symbol])[0]: (side.lower, side.upper)
        for symbol, side in problem.box.items()
    }
