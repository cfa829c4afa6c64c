"""The secant embedding: a family of matrices for each cell, computed from plant and law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, get_args

from takagi.models.equations.problem import cleaned
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact, rational
from takagi.models.loops.secant.closed_loop import ClosedLoop, close_loop
from takagi.models.loops.secant.entries import Entry, Form, entries_of, split
from takagi.models.loops.secant.feedback import Feedback
from takagi.models.loops.secant.matrices import SecantCell, SecantEmbedding, SecantFactor
from takagi.models.plant.plant import Plant
from takagi.models.plant.variables import Variable
from takagi.models.ranges.expression_range import expression_range
from takagi.models.ts.premise import round_outward

if TYPE_CHECKING:
    import sympy as sp


@dataclass(frozen=True, slots=True, eq=False)
class SecantRegion:
    """A cell: a box, and the reference point x* in it for the differences x - x*.

    Attributes
    ----------
    name : e.g. ``"12-13 m/s"``.
    box : variable -> (lower, upper) or ``Interval``; the default is the plant's range.
    reference : variable -> x*, a number, or an expression in exogenous variables (a trim curve);
        the default is the plant's rest.
    """

    name: str = "whole"
    box: Mapping[sp.Symbol, Interval | tuple[Number, Number]] = field(default_factory=dict)
    reference: Mapping[sp.Symbol, sp.Expr | Number] = field(default_factory=dict)

    def __post_init__(self) -> None:
        box = {
            symbol: side if isinstance(side, Interval) else Interval.of(*side)
            for symbol, side in self.box.items()
        }
        object.__setattr__(self, "box", MappingProxyType(box))
        object.__setattr__(self, "reference", MappingProxyType(dict(self.reference)))


def secant_embedding(
    plant: Plant,
    law: Feedback | None = None,
    cells: Sequence[SecantRegion] = (),
    *,
    exogenous: Sequence[sp.Symbol] = (),
    form: Form = "slope",
    tolerance: Number = "1e-3",
) -> SecantEmbedding:
    """Return, for each cell, [A, E] = constant + sum_m theta_m D_m with bounded theta_m, such that
    f(x, u(x, w), w) - f(x*, u(x*, w*), w*) = A (x - x*) + E (w - w*) for all x, w of the cell.

    Parameters
    ----------
    law : u = v(x, w), limited or not; None for a plant without inputs.  The states of a dynamic
        law must be added to the plant.
    cells : boxes within the plant's ranges; the default is one cell with the plant's ranges.
    exogenous : disturbances with the same value at x and at x*.  They have no column in E, and
        references may depend on them.
    form : "slope", "derivative" (both coordinate by coordinate, states in their order, then
        disturbances: valid on the box) or "jacobian" (valid on every convex set inside the box).
        Slopes give the tightest bounds and take the longest time.  If ball arithmetic cannot
        evaluate a slope at 0/0, the derivative is used; the factor's evidence names it.
    tolerance : allowed overestimation at each end, as a share of the range's width.

    f(x, u(x, w), w) must be continuous.  Abs, Max and Min may have kinks: the bounds contain the
    slopes on both sides.  In discrete time f is x(t + T).  The embedding does not show that the
    cells cover a given set, or that a solution stays in its cell.  The theta_m may vary arbitrarily
    in time.  A property of all these matrices therefore holds for the loop while it is in the cell.

    Raises
    ------
    ModelError : an input without command, an unknown symbol, a cell outside the plant's ranges, a
        reference outside its cell, a jump, or an entry that cannot be bounded.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 4.3 (global linearization); the
    forms are derived in ``takagi.models.loops.secant.entries``.
    """
    if form not in get_args(Form):
        raise ModelError(f"form is {form!r}; one of {', '.join(get_args(Form))} is needed")
    loop = _Loop.of(plant, law or Feedback({}), tuple(exogenous))
    used = tuple(cells) or (SecantRegion(),)
    return SecantEmbedding(
        states=tuple(v.label for v in plant.states),
        disturbances=tuple(v.label for v in loop.driving),
        exogenous=tuple(v.label for v in loop.exogenous),
        cells=tuple(loop.enclosed(cell, form, exact(tolerance)) for cell in used),
        sample_time=plant.sample_time,
        form=form,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Loop:
    """The plant's explicit equations and the law, with parameter values, and their variables."""

    plant: Plant
    rows: tuple[sp.Expr, ...]
    law: Feedback
    driving: tuple[Variable, ...]
    exogenous: tuple[Variable, ...]

    @classmethod
    def of(cls, plant: Plant, law: Feedback, exogenous: tuple[sp.Symbol, ...]) -> _Loop:
        import sympy as sp

        if any(v.within for v in plant.variables) or any(p.within for p in plant.parameters):
            raise ModelError(
                f"plant {plant.name!r} has numbers that are no decimals, which secants of a given "
                "law do not take; give its rests and parameters as decimals"
            )
        values = {symbol: rational(value) for symbol, value in plant.values.items()}
        rows = cleaned(plant.equations, values)
        if plant.mass is not None:
            from takagi.models.equations.mass_matrix import explicit

            mass = sp.Matrix(*plant.mass.shape, cleaned(list(plant.mass), values))
            rows, _ = explicit(mass, rows, plant)
        commands = dict(zip(law.commands, cleaned(law.commands.values(), values), strict=True))
        _check_law(plant, commands)
        unknown = set(exogenous) - {v.symbol for v in plant.disturbances}
        if unknown:
            raise ModelError(
                f"exogenous {', '.join(sorted(map(str, unknown)))} is no disturbance of plant "
                f"{plant.name!r}; its disturbances are "
                f"{', '.join(v.name for v in plant.disturbances) or 'none'}"
            )
        return cls(
            plant,
            rows,
            Feedback(commands, law.limits),
            tuple(v for v in plant.disturbances if v.symbol not in exogenous),
            tuple(v for v in plant.disturbances if v.symbol in exogenous),
        )

    @property
    def moving(self) -> tuple[Variable, ...]:
        """Return the variables with a column: states, then disturbances."""
        return (*self.plant.states, *self.driving)

    def enclosed(self, cell: SecantRegion, form: Form, tolerance: Fraction) -> SecantCell:
        box = _sides(self, cell)
        reference = _reference(self, cell, box)
        closed = close_loop(self.rows, self.law, reference, box)
        _check_continuous(self.plant, closed, cell)
        columns = [v.symbol for v in self.moving]
        entries = entries_of(closed.rows, columns, reference, closed.box, form)
        constant, factors = _collected(
            entries, (len(self.rows), len(columns)), form == "jacobian", tolerance, cell.name
        )
        return SecantCell(
            name=cell.name,
            box={str(symbol): side for symbol, side in box.items()},
            reference={str(symbol): str(value) for symbol, value in reference.items()},
            constant=constant,
            factors=factors,
            residual=tuple(self._residual(closed, reference, tolerance)),
            reference_rate=self._reference_rate(reference, closed.box, tolerance),
        )

    def _residual(
        self, closed: ClosedLoop, reference: Mapping[sp.Symbol, sp.Expr], tolerance: Fraction
    ) -> list[Interval]:
        discrete = self.plant.sample_time is not None
        return [
            _bounds(row - reference[v.symbol] if discrete else row, closed.box, tolerance)
            for v, row in zip(self.plant.states, closed.at_reference, strict=True)
        ]

    def _reference_rate(
        self,
        reference: Mapping[sp.Symbol, sp.Expr],
        box: Mapping[sp.Symbol, Interval],
        tolerance: Fraction,
    ) -> tuple[tuple[Interval, ...], ...]:
        if self.plant.sample_time is not None:
            return ()
        return tuple(
            tuple(
                _bounds(reference[v.symbol].diff(p.symbol), box, tolerance) for p in self.exogenous
            )
            for v in self.plant.states
        )


def _check_law(plant: Plant, commands: Mapping[sp.Symbol, sp.Expr]) -> None:
    wanted = {v.symbol for v in plant.inputs}
    if set(commands) != wanted:
        raise ModelError(
            f"the law commands {', '.join(sorted(map(str, commands))) or 'nothing'}; plant "
            f"{plant.name!r} has the inputs {', '.join(sorted(map(str, wanted))) or 'none'}, each "
            "needs one command"
        )
    measured = {v.symbol for v in (*plant.states, *plant.disturbances)}
    for symbol, command in commands.items():
        strange = sorted(map(str, command.free_symbols - measured))
        if strange:
            raise ModelError(
                f"the command of {symbol} depends on {', '.join(strange)}, which is no state, "
                f"disturbance or parameter of plant {plant.name!r}; put the law's own states into "
                "the plant"
            )


def _sides(loop: _Loop, cell: SecantRegion) -> dict[sp.Symbol, Interval]:
    """Return the range of every state and disturbance."""
    variables = (*loop.plant.states, *loop.plant.disturbances)
    unknown = set(cell.box) - {v.symbol for v in variables}
    if unknown:
        raise ModelError(
            f"cell {cell.name}: {', '.join(sorted(map(str, unknown)))} is no state or disturbance "
            f"of plant {loop.plant.name!r}; correct the name"
        )
    found = {}
    for variable in variables:
        side = cell.box.get(variable.symbol, variable.range)
        if side is None:
            raise ModelError(
                f"cell {cell.name}: {variable.label} has no range in the cell nor in plant "
                f"{loop.plant.name!r}; give it one"
            )
        if not isinstance(side, Interval):  # narrows the declared type; Region makes intervals
            side = Interval.of(*side)
        if variable.range is not None and not variable.range.contains(side):
            raise ModelError(
                f"cell {cell.name}: {variable.label} in {side} leaves the plant's range "
                f"{variable.range}; shrink the cell or widen the plant's range"
            )
        found[variable.symbol] = side
    return found


def _reference(
    loop: _Loop, cell: SecantRegion, box: dict[sp.Symbol, Interval]
) -> dict[sp.Symbol, sp.Expr]:
    """Return x*, w*; widen the box by the overestimation of their enclosures."""
    unknown = set(cell.reference) - {v.symbol for v in loop.moving}
    if unknown:
        raise ModelError(
            f"cell {cell.name}: a reference of {', '.join(sorted(map(str, unknown)))} was given; "
            "references are of states and of disturbances that are not exogenous"
        )
    values = {symbol: rational(value) for symbol, value in loop.plant.values.items()}
    allowed = {v.symbol for v in loop.exogenous}
    found = {}
    for variable in loop.moving:
        given = cell.reference.get(variable.symbol, variable.rest)
        numeric = isinstance(given, (int, float, str, Fraction))
        value = rational(given) if numeric else cleaned([given], values)[0]
        if value.free_symbols - allowed:
            names = ", ".join(sorted(map(str, value.free_symbols - allowed)))
            raise ModelError(
                f"cell {cell.name}: the reference of {variable.name} depends on {names}, which is "
                "not exogenous; name it in exogenous, or give a number"
            )
        reached = expression_range(value, box)
        side = box[variable.symbol]
        if not side.contains(reached.inner):
            raise ModelError(
                f"cell {cell.name}: the reference of {variable.label} reaches {reached.inner}, "
                f"outside its range {side}; move the reference or widen the cell"
            )
        box[variable.symbol] = side.hull(reached.outer)
        found[variable.symbol] = value
    return found


def _check_continuous(plant: Plant, closed: ClosedLoop, cell: SecantRegion) -> None:
    """Raise ModelError unless each row is continuous and finite; derivatives ignore jumps."""
    import sympy as sp

    for variable, row in zip(plant.states, closed.rows, strict=True):
        jumping = row.atoms(sp.sign, sp.Heaviside, sp.floor, sp.ceiling)
        if jumping:
            raise ModelError(
                f"cell {cell.name}, equation of {variable.name}: {', '.join(map(str, jumping))} "
                "jumps, and a jump has no secant bound; take a continuous function (Abs, Max and "
                "Min may have kinks)"
            )
        try:
            expression_range(row, closed.box, tolerance=Fraction(1))
        except ModelError as error:
            raise ModelError(
                f"cell {cell.name}, equation of {variable.name}: the closed loop cannot be "
                f"bounded on the cell: {error}"
            ) from error


def _collected(
    entries: Iterable[Entry], shape: tuple[int, int], shared: bool, tolerance: Fraction, name: str
) -> tuple[tuple[tuple[Fraction, ...], ...], tuple[SecantFactor, ...]]:
    """Return the constant part and one factor for each function that entries share."""
    constant = [[Fraction(0)] * shape[1] for _ in range(shape[0])]
    groups: dict[object, list[tuple[Entry, Fraction, sp.Expr]]] = {}
    for entry in entries:
        fixed, coefficient, core = split(entry.expression)
        constant[entry.row][entry.column] += fixed
        if core != 0:
            # Slopes and derivatives are different means, and each column has its own segment.  Only
            # entries with the same kind of mean over the same segment may share one number.
            key = (core, entry.how, None if shared else entry.column)
            groups.setdefault(key, []).append((entry, coefficient, core))
    factors = []
    for members in groups.values():
        first, _, core = members[0]
        places = {(entry.row, entry.column): d for entry, d, _ in members}
        try:
            found = expression_range(core, first.box, tolerance=tolerance)
        except ModelError as error:
            raise ModelError(
                f"cell {name}, entry {min(places)} of [A, E]: the {first.how} cannot be bounded: "
                f"{error}"
            ) from error
        evidence = (
            f"range of the {first.how}, {found.evidence.words if found.evidence else 'enclosed'}, "
            "rounded outward"
        )
        bounds = round_outward(found.outer)
        if bounds.width == 0:
            for (row, column), d in places.items():
                constant[row][column] += d * bounds.lower
        else:
            factors.append(SecantFactor(str(core), bounds, MappingProxyType(places), evidence))
    return tuple(tuple(row) for row in constant), tuple(factors)


def _bounds(
    expression: sp.Expr, box: Mapping[sp.Symbol, Interval], tolerance: Fraction
) -> Interval:
    """Return an enclosure of the range, rounded outward; a point if it is a constant."""
    import sympy as sp

    plain = sp.simplify(expression)
    if plain.is_Rational:
        value = Fraction(int(plain.p), int(plain.q))
        return Interval(value, value)
    return round_outward(expression_range(expression, box, tolerance=tolerance).outer)
