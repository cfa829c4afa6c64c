"""Plant files: TOML with expressions as text -> ``Plant``.

Checks of a plant file: its entries in words, and the ranges of its tables.

The arguments of every table must stay inside it on the whole box.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import sympy as sp
from pydantic import ValidationError

from takagi.models.equations.solved_rest import solve_rest
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.expressions.lost_parts import LostPart, check_lost
from takagi.models.expressions.parser import RESERVED, Scope, expression_error, parsed_with_losses
from takagi.models.files.library import Document, decimal_of, read_document, resolve_model
from takagi.models.files.units import behind
from takagi.models.intervals.interval import Interval
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.entries import PlantEntry, VariableEntry
from takagi.models.plant.plant import Output, Parameter, Plant, Variable
from takagi.models.plant_files.derived_numbers import DerivedNumbers, check_divisors
from takagi.models.plant_files.reference_section import with_references
from takagi.models.plant_files.sections import (
    behind_blend,
    read_table,
    seconds,
    settings_of,
    table_path,
    with_measured,
)
from takagi.models.ranges.expression_range import expression_range

if TYPE_CHECKING:
    from pydantic import BaseModel

    from takagi.models.plant.plant import Plant

VARIABLE = '{ unit = "m", range = [-1, 1] }'
EXAMPLES = {
    "states": VARIABLE,
    "inputs": VARIABLE,
    "disturbances": VARIABLE,
    "scheduling": VARIABLE,
    "parameters": '{ value = 9.81, unit = "m/s^2", source = "..." }',
    "outputs": '{ expression = "x", unit = "m" }',
    "tables": '{ file = "table.csv", unit = "N", arguments = [{ name = "x", unit = "m" }] }',
    "mass": '{ x = "m*l^2" }',
    "reference": '{ follow = "x", range = [-1, 1] }',
}


def problem_of(error: Mapping[str, Any], field: str) -> str:
    """Return the message for one validation error of pydantic, and its field."""
    from takagi.models.plant import entries as e

    kind, message = error["type"], error["msg"]
    section, _, key = field.rpartition(".")
    if kind == "extra_forbidden":
        inner = (e.VariableEntry, e.ParameterEntry, e.OutputEntry, e.TableEntry, e.ReferenceEntry)
        special: dict[str, tuple[type[BaseModel], ...]]
        special = {"": (e.PlantEntry,), "design": (e.DesignEntry,)}
        entry_types = special.get(section, inner)
        fields = {name: None for entry in entry_types for name in entry.model_fields}
        return f"is not known{did_you_mean(key, fields)}; correct its name, or remove it"
    if kind == "missing" and section.endswith(".range"):
        return "a range has two numbers; write range = [low, high]"
    if field == "format":
        found = "is missing" if kind == "missing" else f"{error['input']!r} was given"
        return f"{found}; this takagi reads format = 1: write it so, or use a newer takagi"
    if kind == "missing":
        return "is missing; add it"
    if kind == "literal_error" and field.startswith("reference.") and key == "integral":
        return (
            f"{error['input']} was given; without an integral an error stays that no gain can say, "
            "so references are followed with one: leave the field out"
        )
    if kind == "string_pattern_mismatch":
        return "a name starts with a letter and has letters a-z, A-Z, digits and _; rename it"
    if kind in ("model_type", "dict_type"):
        return _fields_wanted(error["input"], field)
    if kind == "string_type":
        return f"{error['input']} was given; a text in quotes is needed"
    if kind in ("tuple_type", "too_long") and key == "range":
        return "a range has two numbers; write range = [low, high]"
    return str(message).removeprefix("Value error, ")


def _fields_wanted(value: object, field: str) -> str:
    """Return what to write if fields in braces, or a section, were expected."""
    section, _, name = field.partition(".")
    value_text = f'"{value}"' if isinstance(value, str) else str(value)
    if section in EXAMPLES and name:
        return f"{value_text} was given; fields are needed, such as {name} = {EXAMPLES[section]}"
    return f"{value_text} was given; a section is needed: a line [{field}], and its fields below"


TOLERANCE = Fraction(1, 10**6)


def check_coverage(plant: Plant) -> None:
    """Raise ModelError unless each argument of each table provably stays inside it on the box.

    The range of an argument is enclosed rigorously; one that only touches the edge of its table
    may be refused, because its enclosure is wider by a millionth of its width.  In f(g(x)) the
    argument of g is examined first, because a range of g(x) is defined only inside g.
    """
    from takagi.models.splines.table_function import TableFunction, table_ranges

    checked_calls: set[Any] = set()
    for owner, expression in plant.expressions:
        calls = expression.atoms(TableFunction)
        for call in sorted(calls, key=lambda c: (len(c.atoms(TableFunction)), str(c))):
            if call in checked_calls:
                continue
            checked_calls.add(call)
            pairs = zip(call.args, table_ranges(call.table), strict=True)
            for number, (argument, covered) in enumerate(pairs, start=1):
                _check(plant, f"{owner}: argument {number} of {call}", argument, covered)


def _check(plant: Plant, owner: str, argument: sp.Expr, covered: Interval) -> None:
    attained = _range(plant, owner, argument.subs(plant.rationals))
    if covered.contains(attained):
        return
    named = sorted(str(symbol) for symbol in argument.free_symbols)
    sides = ", ".join(
        f"{variable.name} in {variable.range}"
        for variable in plant.variables
        if variable.name in named and variable.range is not None
    )
    raise ModelError(
        f"{owner}, {argument}, takes values in {attained} on the box "
        f"({sides or 'a number'}), but the "
        f"table covers {covered}; shrink the ranges or extend the table"
    )


def _range(plant: Plant, owner: str, argument: sp.Expr) -> Interval:
    ranges = {variable.symbol: variable.range for variable in plant.variables}
    missing = sorted(str(s) for s in argument.free_symbols if ranges[s] is None)
    if missing:
        raise ModelError(
            f"{owner}, {argument}, depends on {', '.join(missing)}, which has no range; give one"
        )
    if argument.is_Symbol:
        return plant.box[argument]
    try:
        return expression_range(argument, plant.box, tolerance=TOLERANCE).outer
    except ModelError as error:
        raise ModelError(f"{owner}: its range cannot be enclosed: {error}") from error


# The sections whose names must differ from each other.
SECTIONS = (
    "states",
    "inputs",
    "disturbances",
    "scheduling",
    "parameters",
    "tables",
    "premises",
    "reference",
)


def load_plant(name_or_path: str | Path) -> Plant:
    """Return the plant of a built-in name or of a TOML file.

    Numbers are the decimals that the file has, converted to SI exactly (by a factor with pi: to
    12 decimals).  Units are checked unless the file says ``units = "unchecked"``, and the
    arguments of tables are proved to stay inside them on the box.

    Raises
    ------
    ModelError : with file, line and field: a field that is missing, unknown or of the wrong type,
        an expression or unit that cannot be read, units that do not fit, a table that does not
        cover the box.
    """
    return PlantFile.of(name_or_path).model


@dataclass(frozen=True, eq=False)
class PlantFile:
    """A plant's file, read once; the plant and the settings are made on demand.

    Every property raises ``ModelError`` where the file does not allow it.

    Attributes
    ----------
    name : the built-in name or the path, as it was given.
    document : its numbers as decimals.
    """

    kind: ClassVar[Literal["plant"]] = "plant"
    name: str | Path
    document: Document

    @classmethod
    def of(cls, name_or_path: str | Path) -> PlantFile:
        """Read the file of a built-in name or path."""
        path = resolve_model(name_or_path)
        return cls(name_or_path, read_document(path, parse_float=decimal_of))

    @cached_property
    def entry(self) -> PlantEntry:
        """The content with its shape checked."""
        try:
            return PlantEntry.model_validate(self.document.data)
        except ValidationError as error:
            # One error alone, a misspelt name first: the others are often its consequences.
            first = min(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden")
            field = ".".join(str(key) for key in first["loc"] if key != "[key]")
            raise self.document.error(field, problem_of(first, field)) from error

    @cached_property
    def model(self) -> Plant:
        """The plant, as ``load_plant`` returns it."""
        return _Reader(self.document, self.entry).plant()

    @property
    def files(self) -> list[Path]:
        """The file, then its tables: all files that ``load_plant`` reads."""
        table_entries = self.entry.tables.items()
        tables = [table_path(self.document, name, table.file) for name, table in table_entries]
        return [self.document.path, *dict.fromkeys(tables)]

    @property
    def settings(self) -> PlantSettings:
        """What the section ``[design]`` asks for."""
        return settings_of(self.document, self.entry)


class _Reader:
    """From the entries of one file to a plant."""

    def __init__(self, document: Document, entry: PlantEntry) -> None:
        self.document = document
        self.entry = entry
        self.lost: list[tuple[str, str, LostPart]] = []
        self.numbers = DerivedNumbers(document, entry, self.expression)
        self.solved: dict[str, Fraction | None] = {}

    def plant(self) -> Plant:
        entry, document = self.entry, self.document
        self.check_names()
        parameters = self.numbers.parameters()
        states = self.variables("states", entry.states)
        inputs = self.variables("inputs", entry.inputs)
        disturbances = (
            *self.variables("disturbances", entry.disturbances),
            *self.scheduling(),
            *self.numbers.uncertain.values(),
        )
        self.check_uncertain_allowed()
        scope = self.scope((*states, *inputs, *disturbances), parameters)
        self.check_rows("equations", entry.equations, needed=True)
        self.check_rows("mass", entry.mass, needed=False)
        with document.at(_field_of):
            plant = Plant(
                equations=tuple(
                    self.expression(f"equations.{v.name}", entry.equations[v.name], scope)
                    for v in states
                ),
                states=states,
                inputs=inputs,
                disturbances=disturbances,
                mass=self.mass(scope),
                outputs=tuple(
                    Output(
                        name,
                        self.expression(f"outputs.{name}.expression", output.expression, scope),
                        document.si_unit(f"outputs.{name}.unit", output.unit),
                    )
                    for name, output in entry.outputs.items()
                ),
                parameters=parameters,
                premises={
                    _symbol(name): self.expression(f"premises.{name}", text, scope)
                    for name, text in entry.premises.items()
                },
                sample_time=None
                if entry.sample_time is None
                else float(seconds(document, "sample_time", entry.sample_time)),
                units=entry.units,
                name=entry.name or document.path.stem,
                description=entry.description,
                source=entry.source,
            )
        check_divisors(document, plant)
        read = partial(self.expression, scope=scope)
        if entry.measured is not None:
            with document.at("measured"):
                plant = with_measured(document, entry, plant, read)
        if self.solved:
            starts = {_symbol(field.split(".")[1]): start for field, start in self.solved.items()}
            with document.at(f"{next(iter(self.solved))}.rest"):
                plant = solve_rest(plant, starts)
        with document.at(_field_of):
            check_coverage(plant)
        self.check_lost(plant)
        if entry.reference:
            return with_references(document, entry, plant)
        if entry.blending is None:
            return plant
        return behind_blend(document, entry, plant, self.variable, read)

    def check_uncertain_allowed(self) -> None:
        """Refuse uncertain parameters of a plant behind a blend."""
        if self.numbers.uncertain and self.entry.blending is not None:
            name = next(iter(self.numbers.uncertain))
            raise self.document.error(
                f"parameters.{name}",
                f"{name} has a range, but the actuators of a plant with [blending] are shared by "
                "known numbers; give it a value, and put the uncertainty into an actuator's error",
            )

    def check_names(self) -> None:
        entry = self.entry
        section_of: dict[str, str] = {}
        for section in SECTIONS:
            for name in getattr(entry, section):
                field = f"{section}.{name}"
                if name in RESERVED:
                    raise self.document.error(field, f"{name} is a function or constant; rename it")
                if name in section_of:
                    raise self.document.error(
                        field,
                        f"{name} is in [{section_of[name]}] already; give each a name of its own",
                    )
                section_of[name] = section

    def variables(self, section: str, entries: Mapping[str, VariableEntry]) -> tuple[Variable, ...]:
        return tuple(self.variable(f"{section}.{name}", name, v) for name, v in entries.items())

    def scheduling(self) -> tuple[Variable, ...]:
        for name, entry in self.entry.scheduling.items():
            if entry.range is None:
                raise self.document.error(
                    f"scheduling.{name}",
                    f"{name} has no range; vertices are made from it: add range = [low, high]",
                )
        listed = {name: _in_its_range(entry) for name, entry in self.entry.scheduling.items()}
        variables = self.variables("scheduling", listed)
        return tuple(replace(variable, schedules=True) for variable in variables)

    def variable(self, field: str, name: str, entry: VariableEntry) -> Variable:
        unit = self.document.unit(f"{field}.unit", entry.unit)
        side = None
        if entry.range is not None:
            self.check_range(field, name, entry)
            side = Interval(*(unit.to_si(Fraction(end)) for end in entry.range))
        variable = Variable(
            _symbol(name), unit.si, side, Fraction(0), entry.description, written=entry.unit
        )
        if isinstance(entry.rest, str) and entry.rest != "solve":
            rest, within, equals = self.numbers.rest(f"{field}.rest", entry.rest, unit)
            self.check_exact(field, within)
            return replace(variable, rest=rest, within=within, equals=equals)
        if not isinstance(entry.rest, Decimal):
            self.check_solvable(field, name)
            near_value = isinstance(entry.rest, str)
            self.solved[field] = None if near_value else unit.to_si(Fraction(entry.start))
        return replace(variable, rest=unit.to_si(Fraction(entry.start)))

    def check_solvable(self, field: str, name: str) -> None:
        if field.split(".")[0] not in ("states", "inputs"):
            raise self.document.error(
                f"{field}.rest",
                f"no equation says where {name} rests, since it comes from outside; give a number",
            )
        self.check_exact(field, Fraction(1))

    def check_exact(self, field: str, within: Fraction) -> None:
        """Refuse a rest that may not be a decimal, for parts that need decimals."""
        if within and (self.entry.blending or field.split(".")[0] not in ("states", "inputs")):
            raise self.document.error(
                f"{field}.rest",
                "a rest that may be no decimal is for states and inputs of a plant without blend; "
                "give a number",
            )

    def check_range(self, field: str, name: str, entry: VariableEntry) -> None:
        """Refuse a range without its rest value, in the figures of the file."""
        assert entry.range is not None
        low, high = entry.range
        if low > high:
            raise self.document.error(
                f"{field}.range", f"[{low}, {high}] was given; give the smaller end first"
            )
        if not low <= entry.start <= high:
            unit = behind(entry.unit)
            why = "" if "rest" in entry.model_fields_set else " where no rest is given"
            raise self.document.error(
                f"{field}.rest" if not why else field,
                f"{name} rests at {entry.start}{unit}{why}, outside its range [{low}, {high}]"
                f"{unit}; give rest = ... inside it, or widen the range",
            )

    def scope(self, variables: Iterable[Variable], parameters: Iterable[Parameter]) -> Scope:
        symbols = {v.name: v.symbol for v in variables}
        symbols |= {p.symbol.name: p.symbol for p in parameters}
        symbols |= {symbol.name: symbol for symbol in self.numbers.moving}
        constants = {p.symbol: p.value for p in parameters if p.within == 0}
        tables = {
            name: read_table(self.document, name, table)
            for name, table in self.entry.tables.items()
        }
        return Scope(symbols, constants, tables)

    def check_rows(self, section: str, names_given: Iterable[str], *, needed: bool) -> None:
        states = list(self.entry.states)
        for name in names_given:
            if name not in states:
                raise self.document.error(
                    f"{section}.{name}",
                    f"{name} is not a state{did_you_mean(name, states)}; states are "
                    + ", ".join(states),
                )
        missing = [name for name in states if name not in set(names_given)]
        if needed and missing:
            raise self.document.error(
                section, f"no equation for {', '.join(missing)}; every state needs one"
            )

    def expression(self, field: str, text: str, scope: Scope) -> sp.Expr:
        with self.document.at(field):
            expression, lost = parsed_with_losses(text, scope)
        moving = self.numbers.moving
        for lost_part in lost:
            renamed = replace(
                lost_part,
                argument=lost_part.argument.xreplace(moving),
                result=lost_part.result.xreplace(moving),
            )
            self.lost.append((field, text, renamed))
        return expression.xreplace(moving)

    def check_lost(self, plant: Plant) -> None:
        """Refuse terms that sympy removed, unless they have a value on the whole box."""
        for field, text, lost_part in self.lost:
            try:
                check_lost(lost_part, plant)
            except ModelError as error:
                message = expression_error(text, lost_part.column, str(error))
                raise self.document.error(field, str(message)) from error

    def mass(self, scope: Scope) -> sp.Matrix | None:
        if not self.entry.mass:
            return None
        states = list(self.entry.states)
        matrix = sp.eye(len(states))
        for row, entries in self.entry.mass.items():
            self.check_rows(f"mass.{row}", entries, needed=False)
            matrix[states.index(row), :] = sp.zeros(1, len(states))
            for column, text in entries.items():
                entry = self.expression(f"mass.{row}.{column}", text, scope)
                matrix[states.index(row), states.index(column)] = entry
        return matrix


def _in_its_range(entry: VariableEntry) -> VariableEntry:
    """Return a signal that rests at the middle of its range, if it has no rest and 0 is outside.

    The rest only fixes what its deviation is counted from.
    """
    low, high = entry.range or (Decimal(0), Decimal(0))
    if "rest" in entry.model_fields_set or low <= 0 <= high:
        return entry
    return entry.model_copy(update={"rest": (low + high) / 2})


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)


def _field_of(message: str) -> str:
    """Return the field that a message of the whole plant is about, as far as it can be told."""
    sections = {"equation of": "equations", "output": "outputs", "premise": "premises"}
    for words, section in sections.items():
        _, label, name_and_text = message.partition(f"{words} ")
        if label and (not _ or _.endswith(": ") or _.endswith(", ")):
            return f"{section}.{name_and_text.partition(':')[0].partition(',')[0]}"
    return "mass" if message.startswith("mass") else "states"
