"""What a model is derived from: equations that vanish at the origin, box, names, premises."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import sympy as sp

from takagi.models.equations.derivation_step import Step
from takagi.models.equations.equations import Equations, explicit, units_of
from takagi.models.equations.equilibrium import (
    Ball,
    balls_of,
    check_equilibrium,
    less_residuals,
    with_inputs_at_rest,
)
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, rational
from takagi.models.plant.design_settings import RESTS, Rest
from takagi.models.plant.plant import Plant, Variable
from takagi.models.ranges.expression_range import Domain


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Equations in deviations from the equilibrium, and all else that a model of them needs.

    Attributes
    ----------
    box : range of each variable that a premise may depend on, in deviations.
    domain : where bounds shall hold if that is less than the box (a band, a union of cells), in
        deviations; None for the box.
    premises : premises fixed by the user.
    names : states, inputs, outputs, disturbances.
    steps : how the equations came from the plant's, for the derivation.
    rest : the plant's variables at the equilibrium, which its deviations are taken from.
    balls : variable or parameter -> the number that it is, where that is not a decimal; the
        equations contain its symbol.
    relations : such a number -> what a linear equation at rest says it is, as R i_rest.
    """

    equations: Equations
    box: Mapping[sp.Symbol, Interval]
    domain: Domain | None
    premises: Mapping[sp.Symbol, sp.Expr]
    names: Mapping[str, Sequence[str]]
    steps: tuple[Step, ...]
    rest: Mapping[sp.Symbol, sp.Expr]
    name: str
    source: str
    balls: Mapping[sp.Symbol, Ball]
    relations: Mapping[sp.Symbol, sp.Expr]

    def related(self) -> Problem:
        """Return the same problem in as few numbers as the linear equations at rest leave."""
        equations = replace(
            self.equations, f=tuple(row.subs(self.relations) for row in self.equations.f)
        )
        return replace(self, equations=equations)

    @property
    def where(self) -> Domain:
        """The domain on which bounds are to hold."""
        return Domain.of_box(self.sides) if self.domain is None else self.domain

    @property
    def sides(self) -> dict[sp.Symbol, Interval]:
        """The box, and the balls of the numbers that are not decimals."""
        return {**self.box, **{ball.symbol: ball.side for ball in self.balls.values()}}

    @property
    def middles(self) -> dict[sp.Symbol, sp.Rational]:
        """The decimals next to these numbers."""
        return {ball.symbol: rational(ball.middle) for ball in self.balls.values()}


def problem_of_plant(
    plant: Plant,
    premises: Mapping[sp.Symbol, sp.Expr] | None,
    how: Rest = "given",
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
    ModelError : the rest values are not an equilibrium of the plant, an output depends on more than
        states and inputs, the mass matrix may be singular on the domain, or the domain speaks of
        symbols that are not variables.
    """
    balls = balls_of(plant)
    values = {s: value for s, value in plant.rationals.items() if s not in balls}
    f = cleaned(plant.equations, values)
    outputs = cleaned((y.expression for y in plant.outputs), values)
    premises_given = plant.premises if premises is None else premises
    wanted = dict(zip(premises_given, cleaned(premises_given.values(), values), strict=True))
    if how not in RESTS:
        raise ModelError(f"rest={how!r} was given; {' or '.join(map(repr, RESTS))} is known")
    over = over_box(domain, plant.box, [v.symbol for v in plant.variables])
    if balls and over.rectangle is None:
        raise ModelError(f"plant {plant.name!r}: on a domain it has to rest at decimals")
    rest: dict[sp.Symbol, sp.Expr] = {
        v.symbol: balls[v.symbol].symbol if v.symbol in balls else rational(v.rest)
        for v in plant.variables
    }
    steps: tuple[Step, ...] = ()
    mass = None
    if plant.mass is not None:
        mass = sp.Matrix(*plant.mass.shape, cleaned(list(plant.mass), values))
    relations: dict[sp.Symbol, sp.Expr] = {}
    if balls:
        f, relations = less_residuals(plant, f, mass, rest, balls)
    if mass is not None:
        sides = {p.symbol: balls[p.symbol].side for p in plant.parameters if p.symbol in balls}
        f, steps = explicit(mass, f, plant, over.within(sides))
    if plant.sample_time is not None:
        f = tuple(row - rest[v.symbol] for row, v in zip(f, plant.states, strict=True))
    if how == "solve inputs":
        rest, settled = with_inputs_at_rest(plant, f, rest)
        if settled is not plant:
            return problem_of_plant(settled, premises, "given", domain)
    check_equilibrium(plant, f, rest, how)
    deviation = _deviation_symbols(plant, rest, wanted)
    at_deviation = {s: rest[s] + deviation[s] for s in rest}
    offsets = [y.subs(rest) for y in outputs]
    shifts = {s: (deviation[s], value) for s, value in rest.items() if s not in balls}
    over = over.moved(shifts | {s: (deviation[s], sp.S.Zero) for s in rest if s in balls})
    if balls:
        over = _settled(over, {deviation[s]: balls[s] for s in rest if s in balls})
    equations = Equations(
        f=tuple(row.subs(at_deviation, simultaneous=True) for row in f),
        states=tuple(deviation[v.symbol] for v in plant.states),
        inputs=tuple(deviation[v.symbol] for v in plant.inputs),
        disturbances=tuple(deviation[v.symbol] for v in plant.disturbances),
        outputs=tuple(
            y.subs(at_deviation, simultaneous=True) - offset
            for y, offset in zip(outputs, offsets, strict=True)
        ),
        units={deviation[v.symbol]: v.unit for v in plant.variables}
        | {balls[v.symbol].symbol: v.unit for v in plant.variables if v.symbol in balls}
        | {p.symbol: p.unit for p in plant.parameters if p.symbol in balls}
        | units_of(plant, premises_given),
        sample_time=plant.sample_time,
        scheduling=tuple(deviation[v.symbol] for v in plant.disturbances if v.schedules),
    )
    return Problem(
        equations,
        box=over.sides(deviation.values()),
        domain=over if over.rectangle is None else None,
        premises={s: e.subs(at_deviation, simultaneous=True) for s, e in wanted.items()},
        names={
            "states": equations.named(equations.states),
            "inputs": equations.named(equations.inputs),
            "outputs": tuple(
                f"{'' if offset == 0 else 'delta_'}{y.name} [{y.unit}]"
                for y, offset in zip(plant.outputs, offsets, strict=True)
            ),
            "disturbances": equations.named(equations.disturbances),
        },
        steps=(*steps, *_rest_steps(rest, deviation), *_ball_steps(balls)),
        rest=rest,
        name=plant.name,
        source=plant.source,
        balls=balls,
        relations=relations,
    )


def _settled(over: Domain, balls: Mapping[sp.Symbol, Ball]) -> Domain:
    """Return the box of deviations that stay in the plant's from anywhere in the balls."""
    assert over.rectangle is not None
    box = {}
    for symbol, side in over.rectangle.items():
        ball = balls.get(symbol)
        if ball is not None:
            side = Interval(side.lower - ball.side.lower, side.upper - ball.side.upper)
        box[symbol] = side
    return Domain.of_box(box)


def _ball_steps(balls: Mapping[sp.Symbol, Ball]) -> tuple[Step, ...]:
    if not balls:
        return ()
    formulas = [
        rf"{sp.latex(ball.symbol)} = {float(ball.middle):.15g} \pm {float(ball.radius):.0e}"
        for ball in balls.values()
    ]
    return (Step("Numbers that are no decimals, in SI units.", r",\quad ".join(formulas)),)


def cleaned(
    expressions: Iterable[sp.Expr], values: Mapping[sp.Symbol, sp.Rational]
) -> tuple[sp.Expr, ...]:
    """Return the expressions with parameters put in and floats as rationals."""
    exact = []
    for expression in expressions:
        substituted = sp.sympify(expression).subs(values)
        floats = {number: rational(float(number)) for number in substituted.atoms(sp.Float)}
        exact.append(substituted.xreplace(floats))
    return tuple(exact)


def _deviation_symbols(
    plant: Plant, rest: Mapping[sp.Symbol, sp.Expr], wanted: Mapping[sp.Symbol, sp.Expr]
) -> dict[sp.Symbol, sp.Symbol]:
    names = {v.name for v in plant.variables} | {str(s) for s in wanted}

    def symbol(variable: Variable) -> sp.Symbol:
        if rest[variable.symbol] == 0:
            return variable.symbol
        name = f"delta_{variable.name}"
        if name in names:
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
        cell_symbols = {s for cell_value in cell.places.values() for s in cell_value.free_symbols}
        strange = [s for s in cell.box if s not in variables and s not in cell_symbols]
        strange += [s for s in cell.places if s not in variables]
        if strange:
            twin = next((v for v in variables if v.name == strange[0].name), None)
            raise ModelError(
                f"the domain has {', '.join(sorted(map(str, strange)))}; the variables are "
                + ", ".join(map(str, variables))
                + ("" if twin is None else " (symbols declared otherwise are others: real=True?)")
            )
    return domain.within(box)


def _rest_steps(
    rest: Mapping[sp.Symbol, sp.Expr], deviation: Mapping[sp.Symbol, sp.Symbol]
) -> tuple[Step, ...]:
    formulas = [
        rf"{sp.latex(deviation[s])} = {sp.latex(s)} - {sp.latex(value, fold_short_frac=True)}"
        if not value.is_Add and not value.could_extract_minus_sign()
        else rf"{sp.latex(deviation[s])} = {sp.latex(s)} - \left({sp.latex(value)}\right)"
        for s, value in rest.items()
        if value != 0
    ]
    if not formulas:
        return ()
    return (Step("Deviations from rest.", r",\quad ".join(formulas)),)


def box_in_fractions(problem: Problem) -> dict[str, tuple[Fraction, Fraction]]:
    """Return label -> (lower, upper), as a ``TSModel`` keeps its box."""
    return {
        problem.equations.named([symbol])[0]: (side.lower, side.upper)
        for symbol, side in problem.box.items()
    }
