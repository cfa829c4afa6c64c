"""The programs of a gain file as one value: constants, signals, kept values, steps in order.

All targets (C, MATLAB, structured text) read this value and not the file, so that they cannot
interpret the file differently.  Every name in it has one meaning: where two programs of the file
use a name for two things, the program's name is put in front, such as ``observer_v_rate``.

Formulas are trees, which every target writes in its own language.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import Any, TypeAlias

from takagi.models.errors import ModelError
from takagi.reports.output import read_words

# Function -> (least, most) number of its arguments; None means any number.
FUNCTIONS: dict[str, tuple[int, int | None]] = {
    **dict.fromkeys(
        ("abs", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan",
         "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "first", "last"),
        (1, 1),
    ),
    "min": (2, 2), "max": (2, 2), "limit": (3, 3), "choose": (3, 3),
    "line": (3, 3), "slope": (3, 3), "hold": (3, 3), "spline": (2, 3), "mix": (2, None),
}  # fmt: skip

OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "^",
}


@dataclass(frozen=True, slots=True)
class Number:
    """A number as it is written in the file."""

    value: Decimal


@dataclass(frozen=True, slots=True)
class Name:
    """The name of a constant, a kept value, a signal or a step's result; or ``pi``."""

    name: str


@dataclass(frozen=True, slots=True)
class Operation:
    """``left sign right`` with one of + - * / ^; -x has the sign - and None as ``left``."""

    sign: str
    left: Formula | None
    right: Formula


@dataclass(frozen=True, slots=True)
class Call:
    """A function of ``FUNCTIONS`` and its arguments."""

    function: str
    arguments: tuple[Formula, ...]


Formula: TypeAlias = Number | Name | Operation | Call


def parsed(text: str, tables: Collection[str] = ()) -> Formula:
    """Return the tree of a formula in the language of gain files.

    Operators have the precedence of Python, with ^ for a power: -x^2 is -(x^2), 2^3^2 is 2^(3^2).

    Parameters
    ----------
    tables : names that plant files call as functions: ``name(x)`` is ``spline(x, name)``.

    Raises
    ------
    ModelError : the text has a part that the language does not have.
    """
    try:
        source = text.replace("^", "**").strip()
        return _formula(ast.parse(source, mode="eval").body, source, text, tables)
    except (SyntaxError, RecursionError, MemoryError) as error:
        raise ModelError(f"formula {text!r} cannot be read; see `language` in the file") from error


def walked(formula: Formula) -> Iterator[Formula]:
    """Yield a formula and all parts of it, from left to right."""
    yield formula
    match formula:
        case Operation(_, left, right):
            yield from () if left is None else walked(left)
            yield from walked(right)
        case Call(_, arguments):
            for argument in arguments:
                yield from walked(argument)


def names_of(formula: Formula) -> Iterator[str]:
    """Yield the names in a formula, from left to right, without those of functions and pi."""
    names = (node.name for node in walked(formula) if isinstance(node, Name))
    yield from (name for name in names if name != "pi")


def calls_of(formula: Formula) -> Iterator[Call]:
    """Yield all calls in a formula."""
    yield from (node for node in walked(formula) if isinstance(node, Call))


def _formula(tree: ast.expr, source: str, text: str, tables: Collection[str]) -> Formula:
    def formula(part: ast.expr) -> Formula:
        return _formula(part, source, text, tables)

    match tree:
        case ast.Constant(value=int() | float()):
            # The decimals as they are written, not those of the nearest float.
            return Number(Decimal(str(ast.get_source_segment(source, tree)).replace("_", "")))
        case ast.Name(id=name):
            return Name(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return Operation("-", None, formula(operand))
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return formula(operand)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in OPERATORS:
            return Operation(OPERATORS[type(operator)], formula(left), formula(right))
        case ast.Call(func=ast.Name(id=function), args=arguments, keywords=[]):
            parts = tuple(map(formula, arguments))
            if function in tables:
                return _call("spline", (*parts, Name(function)), text)
            return _call(function, parts, text)
    raise ModelError(
        f"formula {text!r}: {ast.unparse(tree)!r} is not in the language of gain files"
    )


def _call(function: str, arguments: tuple[Formula, ...], text: str) -> Call:
    if function not in FUNCTIONS:
        raise ModelError(f"formula {text!r}: function {function!r} is not known")
    fewest, largest_count = FUNCTIONS[function]
    if len(arguments) < fewest or (largest_count is not None and len(arguments) > largest_count):
        raise ModelError(
            f"formula {text!r}: {function} has {len(arguments)} arguments; it takes "
            f"{fewest if largest_count == fewest else f'{fewest} or more'}"
        )
    return Call(function, arguments)


Row: TypeAlias = tuple[Decimal, ...]
Value: TypeAlias = "Decimal | Row | tuple[Row, ...] | Spline"


@dataclass(frozen=True, slots=True)
class Spline:
    """A cubic spline of one or two arguments.

    Attributes
    ----------
    knots : for each argument all knots, those at the ends repeated.
    coefficients : one row for a spline of one argument; for two arguments, one row for each basis
        function of the first.
    """

    knots: tuple[Row, ...]
    coefficients: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Constant:
    """A number, row, matrix or spline of the file; ``path`` is where in the file."""

    name: str
    unit: str
    path: str
    value: Value


@dataclass(frozen=True, slots=True)
class Signal:
    """A value that is read or sent at every sample.

    Attributes
    ----------
    rest : value in SI that is used before the first finite measurement.
    range : interval in SI in which the model holds; None where the file states none.
    optional : whether an input may be left unconnected, which is then at rest; a set-point.
    """

    name: str
    unit: str
    meaning: str
    rest: Decimal | None = None
    range: tuple[Decimal, Decimal] | None = None
    optional: bool = False

    @property
    def words(self) -> str:
        """The meaning, of a set-point with its range."""
        if not self.optional or self.range is None:
            return self.meaning
        return f"{self.meaning}; {self.range[0]} to {self.range[1]}"


@dataclass(frozen=True, slots=True)
class Near:
    """Where |of| <= within, ``formula`` replaces the step's own formula.

    It serves a quotient near a point where numerator and denominator vanish.
    """

    of: Formula
    within: Decimal
    formula: Formula


@dataclass(frozen=True, slots=True)
class Assignment:
    """One step of a program, or a value that it sends: ``name = formula``."""

    name: str
    unit: str
    meaning: str
    formula: Formula
    near: tuple[Near, ...] = ()

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """The formula, and those of the places where another replaces it."""
        inside = (formula for near in self.near for formula in (near.of, near.formula))
        return (self.formula, *inside)


@dataclass(frozen=True, slots=True)
class Kept:
    """A value that is kept from sample to sample: ``start`` at the first one, then ``next``."""

    name: str
    unit: str
    meaning: str
    start: Formula
    next: Formula


@dataclass(frozen=True, slots=True)
class Stage:
    """One program of the file: its kept values, its steps in order, and what it then sends."""

    name: str
    kept: tuple[Kept, ...]
    steps: tuple[Assignment, ...]
    sends: tuple[Assignment, ...]

    @property
    def assignments(self) -> tuple[Assignment, ...]:
        """Steps and sends in the order in which they are computed."""
        return self.steps + self.sends


@dataclass(frozen=True, slots=True)
class ControllerProgram:
    """One sample of a controller.

    The stages run in order.  At the first sample the kept values of a stage take their ``start``;
    then its steps are computed, then the values that it sends.  After the last stage all kept
    values take their ``next`` at once.  ``sample_time`` [s] is a name in formulas.

    Attributes
    ----------
    name : the file's title.
    plant : the name of the plant or turbine.
    kind : "turbine" or "plant".
    sample_time : T [s] of a law in discrete time; None where the user chooses it.
    constants, inputs, outputs : each name once; outputs are all values that the stages send.
    verdict : the verdict of the certificate, as the gain file states it.
    hashes : SHA-256 of the certificate's members, as the gain file states them.
    document : the gain file as plain data, numbers as Decimals.
    """

    name: str
    plant: str
    kind: str
    sample_time: Decimal | None
    constants: tuple[Constant, ...]
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    stages: tuple[Stage, ...]
    verdict: str
    hashes: Mapping[str, str]
    document: Mapping[str, Any]

    @property
    def kept(self) -> tuple[Kept, ...]:
        """The kept values of all stages."""
        return tuple(state for stage in self.stages for state in stage.kept)

    @property
    def assignments(self) -> tuple[Assignment, ...]:
        """The steps and sent values of all stages, in the order in which they are computed."""
        return tuple(assignment for stage in self.stages for assignment in stage.assignments)

    def formulas(self) -> Iterator[Formula]:
        """Yield the formulas of all kept values, steps and sent values."""
        yield from (formula for state in self.kept for formula in (state.start, state.next))
        yield from (formula for assignment in self.assignments for formula in assignment.formulas)

    def names(self) -> Iterator[str]:
        """Yield every name: constants, inputs, kept values, steps and outputs."""
        for named in (self.constants, self.inputs, self.kept, self.assignments):
            yield from (entry.name for entry in named)


@cache
def reserved_words(language: str) -> frozenset[str]:
    """Return the words of a language that names must not be; ``reserved_words.toml`` has them."""
    return frozenset(read_words("code/reserved_words.toml")[language].split())


LONGEST = 63  # characters that C99 promises to tell apart


def identifiers(
    names: Iterable[str], reserved: Collection[str], *, language: str, ignore_case: bool = False
) -> dict[str, str]:
    """Return a valid identifier for each name: the name itself, with ``_`` added if it is in use.

    Parameters
    ----------
    reserved : keywords and functions of the language, in lower case if case is ignored.
    language : its name, for the message.
    ignore_case : whether ``K`` and ``k`` are the same name in the language.

    Raises
    ------
    ModelError : a name that is too long for the language.
    """
    words: dict[str, str] = {}
    used_words = {word.lower() if ignore_case else word for word in reserved}
    for name in dict.fromkeys(names):
        word = re.sub(r"\W", "_", name, flags=re.ASCII)
        while (word.lower() if ignore_case else word) in used_words:
            word += "_"
        if len(word) > LONGEST:
            raise ModelError(
                f"name {name!r} has {len(word)} characters; {language} holds {LONGEST}: shorten it "
                "in the model file and design again"
            )
        used_words.add(word.lower() if ignore_case else word)
        words[name] = word
    return words


def file_word(name: str) -> str:
    """Return a model's name as one word for files and identifiers: ``NREL 5-MW`` is nrel_5_mw."""
    word = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    if not word:
        return "controller"
    return f"law_{word}" if word[0].isdigit() else word
