"""Formulas of a program in C, one sample of a law as a function in C, and the helpers it needs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from decimal import Decimal
from importlib.resources import files
from typing import TypeAlias

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import (
    Assignment,
    Call,
    Constant,
    ControllerProgram,
    Formula,
    Kept,
    Name,
    Number,
    Operation,
    Row,
    Spline,
    Stage,
    calls_of,
    names_of,
    reserved_words,
)

# Keywords of C11 and C++20, names of <math.h>, macros of common compilers and systems, and names
# that the generated files use themselves.
RESERVED = reserved_words("c")
_HEADERS = reserved_words("c-headers")


def _read_helpers() -> dict[str, str]:
    text = (files("takagi.reports.code.c") / "helpers.c").read_text(encoding="utf-8")
    return {_CALLED.findall(helper)[0]: helper.strip() for helper in text.split("\n\n")}


_CALLED = re.compile(r"@(\w+)\(")
# Helper -> its text.  In a text @ means the prefix, REAL the type, and ZERO and ONE the numbers in
# that type.  A helper comes after those that it calls.
HELPERS = _read_helpers()


def helpers(used: Collection[str], prefix: str, real: str, suffix: str) -> str:
    """Return the text of the used helpers and of those that they call, in the order of C."""
    needed: set[str] = set()
    waiting = list(used)
    while waiting:
        helper = waiting.pop()
        if helper not in needed:
            needed.add(helper)
            waiting += _CALLED.findall(HELPERS[helper])
    words = {"REAL": real, "ONE": f"1.0{suffix}", "ZERO": f"0.0{suffix}"}
    text = "".join(f"\n{body}\n" for name, body in HELPERS.items() if name in needed)
    text = re.sub(r"\b(REAL|ONE|ZERO)\b", lambda match: words[match[1]], text)
    return text.replace("@", prefix)


def comment(text: str) -> str:
    """Return a text that is safe inside a comment or string of C: one line of ASCII."""
    plain = " ".join(text.split()).encode("ascii", "replace").decode("ascii")
    # First the backslashes: a slash in their place may end a comment.
    plain = plain.replace("\\", "/").replace('"', "'")
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def file_name_word(word: str) -> str:
    """Return a word W such that ``W.h`` has not the name of a standard header."""
    return f"law_{word}" if word in _HEADERS or word in RESERVED else word


# A text of C, and the precedence of its last operation: a higher number binds more strongly.
Expression: TypeAlias = tuple[str, int]

_BINDS = {"+": 1, "-": 1, "*": 2, "/": 2}
_SIGNED, _ATOM = 3, 4
_PI = Decimal("3.14159265358979323846")
# The largest and the smallest normal float (FLT_MAX, FLT_MIN), and the largest double (DBL_MAX).
_LARGEST, _SMALLEST = Decimal("3.4028234663852886E+38"), Decimal("1.1754943508222875E-38")
_LARGEST_DOUBLE = Decimal("1.7976931348623157E+308")
# Functions that gain files and <math.h> name differently.
_MATH = {"abs": "fabs"}


def literal(value: Decimal, suffix: str) -> str:
    """Return a number as C writes it: the file's digits, with a point and the type's suffix.

    Raises
    ------
    ModelError : the number is not finite, or the type cannot hold it.
    """
    if not value.is_finite():
        raise ModelError(f"{value} stands in the file where a finite number is needed")
    size = abs(value)
    if suffix and size and not _SMALLEST <= size <= _LARGEST:
        raise ModelError(
            f"the number {value} does not fit a float; give --precision double for this law"
        )
    if size > _LARGEST_DOUBLE:
        raise ModelError(f"the number {value} does not fit a double")
    text = str(value)
    return text + ("" if "." in text or "E" in text else ".0") + suffix


class Expressions:
    """Writes formulas in C; records the helpers that they need and the weights of rules.

    Attributes
    ----------
    helpers : names of the helper functions that were needed so far.
    before : lines that must stand before the next statement; ``taken_before`` returns them.
    """

    def __init__(
        self,
        names: Mapping[str, str],
        constants: Mapping[str, Constant],
        prefix: str,
        suffix: str,
        *,
        widened: bool = False,
    ) -> None:
        self.names, self.constants = names, constants
        self.prefix, self.suffix = prefix, suffix
        self._widened = widened
        self.helpers: set[str] = set()
        self.before: list[str] = []
        self._weights: dict[tuple[str, ...], str] = {}
        self._count = 0

    def text(self, formula: Formula) -> str:
        """Return a formula as C."""
        return self._written(formula)[0]

    def in_double(self, formulas: Sequence[Formula]) -> Expressions | None:
        """Return a writer that computes formulas of float names in double.

        None where a formula needs a helper function, since helpers have one type.
        """
        wide = Expressions(self.names, self.constants, self.prefix, "", widened=True)
        for formula in formulas:
            wide.text(formula)
        return None if wide.helpers else wide

    def factor(self, formula: Formula) -> str:
        """Return a formula as C that can be an operand of a comparison."""
        return self._bound(formula, 1)

    def taken_before(self) -> list[str]:
        """Return the lines that must stand before the statement, and forget them."""
        lines, self.before = self.before, []
        return lines

    def forget(self) -> None:
        """Forget the weights: the C block that declares them has ended."""
        self._weights.clear()

    def _written(self, formula: Formula) -> Expression:
        match formula:
            case Number(value):
                return literal(value, self.suffix), _ATOM
            case Name("pi"):
                return literal(_PI, self.suffix), _ATOM
            case Name(name):
                if name in self.constants and not isinstance(self.constants[name].value, Decimal):
                    raise ModelError(f"{name!r} is a row or table; a formula needs a number there")
                cast = "(double)" if self._widened else ""
                return f"{cast}{self.names[name]}", _ATOM
            case Operation("^", left, right):
                assert left is not None
                return self._power(left, right)
            case Operation(_, None, right):
                return f"-{self._bound(right, _ATOM)}", _SIGNED
            case Operation(sign, left, right):
                assert left is not None
                binds = _BINDS[sign]
                # Equal signs on the right keep their parentheses: a - (b - c).
                text = f"{self._bound(left, binds)} {sign} {self._bound(right, binds + 1)}"
                return text, binds
            case Call(function, arguments):
                return self._call(function, arguments)

    def _bound(self, formula: Formula, binding: int) -> str:
        text, binds = self._written(formula)
        return text if binds >= binding else f"({text})"

    def _power(self, base: Formula, exponent: Formula) -> Expression:
        if isinstance(exponent, Number) and exponent.value in (2, 3, 4) and not self._widened:
            return self._helped(f"power_{int(exponent.value)}", self.text(base)), _ATOM
        return f"pow{self._f}({self.text(base)}, {self.text(exponent)})", _ATOM

    @property
    def _f(self) -> str:
        return self.suffix.lower()

    def _helped(self, helper: str, *arguments: str) -> str:
        self.helpers.add(helper)
        return f"{self.prefix}{helper}({', '.join(arguments)})"

    def _call(self, function: str, arguments: tuple[Formula, ...]) -> Expression:
        if function == "choose":
            d, a, b = arguments
            zero = literal(Decimal(0), self.suffix)
            return f"({self.factor(d)} < {zero} ? {self.text(a)} : {self.text(b)})", _ATOM
        if function in ("min", "max", "limit"):
            return self._helped(function, *map(self.text, arguments)), _ATOM
        if function in ("first", "last"):
            row = self._row(arguments[0])
            index = 0 if function == "first" else len(row) - 1
            return f"{self._table(arguments[0])}[{index}]", _ATOM
        if function in ("line", "slope", "hold"):
            return self._between(function, arguments), _ATOM
        if function == "spline":
            return self._spline(arguments), _ATOM
        if function == "mix":
            return self._mix(arguments), _ATOM
        return f"{_MATH.get(function, function)}{self._f}({self.text(arguments[0])})", _ATOM

    def _between(self, function: str, arguments: tuple[Formula, ...]) -> str:
        x, nodes, values = arguments
        count, value_count = len(self._row(nodes)), len(self._row(values))
        if count < 2 or not (
            value_count == count or (function == "hold" and value_count == count - 1)
        ):
            raise ModelError(f"{function} has {count} nodes and {value_count} values")
        return self._helped(
            function, self.text(x), self._table(nodes), self._table(values), str(count)
        )

    def _spline(self, arguments: tuple[Formula, ...]) -> str:
        table = self._constant(arguments[-1])
        name = self._table(arguments[-1])
        if not isinstance(table, Spline) or len(table.knots) != len(arguments) - 1:
            raise ModelError(f"{name!r} is no spline of {len(arguments) - 1} arguments")
        rows = len(table.knots)
        sizes = (1, len(table.coefficients[0])) if rows == 1 else (
            len(table.coefficients), len(table.coefficients[0])
        )  # fmt: skip
        required = tuple(len(row) - 4 for row in table.knots)
        if min(required) < 4 or sizes[-rows:] != required:
            raise ModelError(f"{name!r} has {sizes} coefficients for its knots, not {required}")
        texts = [self.text(argument) for argument in arguments[:-1]]
        for k, knots in enumerate(table.knots, start=1):
            texts += [f"{name}_knots_{k}", str(len(knots))]
        return self._helped("spline" if rows == 1 else "spline_2", *texts, name)

    def _mix(self, arguments: tuple[Formula, ...]) -> str:
        rules, values = arguments[:2]
        count = len(self._row(values))
        if count == 1:
            return f"{self._table(values)}[0]"
        table = self._constant(rules)
        premises = len(arguments) - 2
        if not (
            isinstance(table, tuple)
            and len(table) == count
            and all(isinstance(row, tuple) and len(row) == premises for row in table)
        ):
            raise ModelError(f"mix has {count} values, and rules of another size")
        if not all(number in (0, 1) for row in table if isinstance(row, tuple) for number in row):
            raise ModelError("rules of a mix have numbers other than 0 and 1")
        return self._helped(
            "mix", self._weights_of(rules, arguments[2:], count), self._table(values), str(count)
        )

    def _weights_of(self, rules: Formula, premises: tuple[Formula, ...], count: int) -> str:
        texts = tuple(map(self.text, premises))
        key = (self._table(rules), *texts)
        if key not in self._weights:
            self._count += 1
            name, w = f"{self.prefix}weights_{self._count}", f"{self.prefix}premises_{self._count}"
            self.before += [
                f"{self.prefix}real {w}[{len(texts)}];",
                f"{self.prefix}real {name}[{count}];",
                *(f"{w}[{k}] = {text};" for k, text in enumerate(texts)),
                f"{self._helped('weigh', name, key[0], str(count), w, str(len(texts)))};",
            ]
            self._weights[key] = name
        return self._weights[key]

    def _constant(self, formula: Formula) -> object:
        if isinstance(formula, Name) and formula.name in self.constants:
            return self.constants[formula.name].value
        raise ModelError("a row or table of the file is needed in a formula, by its name")

    def _table(self, formula: Formula) -> str:
        self._constant(formula)
        assert isinstance(formula, Name)
        return self.names[formula.name]

    def _row(self, formula: Formula) -> Row:
        row = self._constant(formula)
        if isinstance(row, tuple) and row and all(isinstance(number, Decimal) for number in row):
            return row
        raise ModelError(
            f"the gain file is damaged: {self._table(formula)!r} is no row of numbers; give the "
            "gains.json that `takagi design` has written"
        )


# The value that an observer sends to a law, or that is measured in its place.
ESTIMATE = "wind_estimate"


def needed_names(program: ControllerProgram) -> frozenset[str]:
    """Return the names on which outputs and kept values depend; others are not written."""
    formulas = {assignment.name: assignment.formulas for assignment in program.assignments}
    state_formulas = {state.name: (state.start, state.next) for state in program.kept}
    needed: set[str] = set()
    waiting = [*(signal.name for signal in program.outputs), *state_formulas]
    while waiting:
        name = waiting.pop()
        if name in needed:
            continue
        needed.add(name)
        for formula in (*formulas.get(name, ()), *state_formulas.get(name, ())):
            waiting += _read(formula, program)
    return frozenset(needed)


def _read(formula: Formula, program: ControllerProgram) -> Iterator[str]:
    """Yield the names whose values matter; a mix of one rule depends on its value alone."""
    rows = {constant.name: constant.value for constant in program.constants}
    match formula:
        case Call("mix", (_, Name(name), *_)) if len(rows.get(name, ())) == 1:  # type: ignore[arg-type]
            yield name
        case Call(_, arguments):
            for argument in arguments:
                yield from _read(argument, program)
        case Operation(_, left, right):
            for operand in (left, right):
                yield from () if operand is None else _read(operand, program)
        case _:
            yield from names_of(formula)


def sample_function(
    program: ControllerProgram, word: str, needed: frozenset[str], write: Expressions
) -> str:
    """Return the static function ``W_sample``: one sample from state and inputs.

    It writes only to its two arguments for results: the outputs, and the next kept values.  It
    returns the status bits of a command at a limit and of a wind estimate that is held.
    """
    names = write.names
    lines = [f"const {word}_real {names[signal.name]} = inputs->{names[signal.name]};"
             for signal in program.inputs if signal.name in needed]  # fmt: skip
    if "sample_time" in needed:
        lines.append(f"const {word}_real {names['sample_time']} = state->sample_time;")
    lines.append("unsigned status = 0u;")
    for stage in program.stages:
        lines += ["", f"/* {comment(stage.name)} */", *_start(stage.kept, word, write)]
        for assignment in stage.assignments:
            if assignment.name in needed:
                lines += assignment_lines(assignment, word, write)
                lines += _estimate_held(assignment, stage, word, write)
    lines.append("")
    for sent in program.outputs:
        lines += _at_limit(sent.name, program, word, write)
        lines.append(f"outputs->{names[sent.name]} = {names[sent.name]};")
    for state in program.kept:
        text = write.text(state.next)
        lines += [*write.taken_before(), f"next->{names[state.name]} = {text};"]
    lines.append("return status;")
    next_parameter = f", {word}_kept *next" if program.kept else ""
    if not program.kept and "sample_time" not in needed:
        lines.insert(0, "(void)state;")
    head = (
        f"\n/* One sample: fills outputs"
        f"{' and the kept values of the next' if next_parameter else ''}. */\n"
        f"static unsigned {word}_sample(const {word}_state *state, const {word}_inputs *inputs,\n"
        f"    {word}_outputs *outputs{next_parameter})\n"
    )
    return head + "{\n" + "".join(f"    {line}\n" if line else "\n" for line in lines) + "}\n"


def _start(states: Sequence[Kept], word: str, write: Expressions) -> Iterator[str]:
    """Yield the lines that give a stage's kept values: those of the last sample, or the start."""
    for state in states:
        yield f"{word}_real {write.names[state.name]} = state->kept.{write.names[state.name]};"
    if not states:
        return
    yield "if (state->samples == 0u) {"
    for state in states:
        text = write.text(state.start)
        for line in write.taken_before():
            yield f"    {line}"
        yield f"    {write.names[state.name]} = {text};"
    write.forget()
    yield "}"


def assignment_lines(assignment: Assignment, word: str, write: Expressions) -> Iterator[str]:
    """Yield the statements that give a local variable of type ``{word}_real`` its value."""
    name = write.names[assignment.name]
    note = comment(
        " ".join(
            note_text for note_text in (f"[{assignment.unit}]", assignment.meaning) if note_text
        )
    )
    if not assignment.near:
        text = write.text(assignment.formula)
        yield from write.taken_before()
        yield f"const {word}_real {name} = {text}; /* {note} */"
        return
    # Near a quotient 0/0 the gain file's ``within`` is so small that a float cannot resolve it:
    # the step is computed in double.
    wide = write.in_double(assignment.formulas) if write.suffix else None
    by, cast = (wide, f"({word}_real)") if wide else (write, "")

    def value(formula: Formula) -> str:
        return f"{cast}({by.text(formula)})" if cast else by.text(formula)

    formula_text = value(assignment.formula)
    branches = [
        (
            f"{by.text(Call('abs', (near.of,)))} <= {literal(near.within, by.suffix)}",
            value(near.formula),
        )
        for near in assignment.near
    ]
    yield from by.taken_before()
    yield f"{word}_real {name}; /* {note} */"
    for k, (condition, formula) in enumerate(branches):
        yield f"{'} else ' if k else ''}if ({condition}) {{"
        yield f"    {name} = {formula};"
    yield "} else {"
    yield f"    {name} = {formula_text};"
    yield "}"


def _estimate_held(
    assignment: Assignment, stage: Stage, word: str, write: Expressions
) -> Iterator[str]:
    """Yield the lines that set the bit of a wind estimate at a limit, or at the end of a table."""
    conditions = []
    formula = assignment.formula
    if any(sent.name == ESTIMATE for sent in stage.sends):
        for call in calls_of(formula):
            conditions += list(_beyond(call, write))
    if isinstance(formula, Call) and formula.function == "limit":
        x, low, high = formula.arguments
        limited = write.names[assignment.name]
        if x == Name(ESTIMATE):
            unlimited = write.factor(x)
            conditions.append(f"{unlimited} < {limited} || {unlimited} > {limited}")
        elif any(
            sent.formula == Name(assignment.name) for sent in stage.sends if sent.name == ESTIMATE
        ):
            # The observer stops at its limit, so that reaching it is enough.
            ends = write.factor(low), write.factor(high)
            conditions.append(f"{limited} <= {ends[0]} || {limited} >= {ends[1]}")
    yield from write.taken_before()
    if conditions:
        yield f"if ({' || '.join(conditions)}) {{"
        yield f"    status |= {word.upper()}_ESTIMATE_HELD;"
        yield "}"


def _beyond(call: Call, write: Expressions) -> Iterator[str]:
    """Yield the conditions under which an argument of a spline lies beyond its knots."""
    if call.function != "spline":
        return
    table = call.arguments[-1]
    assert isinstance(table, Name)
    value = write.constants[table.name].value
    assert isinstance(value, Spline)
    for argument, knots in zip(call.arguments[:-1], value.knots, strict=True):
        low, high = (literal(end, write.suffix) for end in (knots[0], knots[-1]))
        x = write.factor(argument)
        yield f"{x} < {low} || {x} > {high}"


def _at_limit(
    name: str, program: ControllerProgram, word: str, write: Expressions
) -> Iterator[str]:
    """Yield the lines that set the status bit where an output was held at a limit."""
    # An output is often only another name of a step: follow the names to the step with ``limit``.
    if name == ESTIMATE:  # It has a status bit of its own.
        return
    by_name = {assignment.name: assignment for assignment in program.assignments}
    limiting = by_name[name]
    while (
        isinstance(limiting.formula, Name)
        and limiting.formula.name in by_name
        and not limiting.near
    ):
        limiting = by_name[limiting.formula.name]
    formula = limiting.formula
    if limiting.near or not (isinstance(formula, Call) and formula.function == "limit"):
        return
    unlimited, limited = write.factor(formula.arguments[0]), write.names[name]
    yield from write.taken_before()
    yield f"if ({unlimited} < {limited} || {unlimited} > {limited}) {{"
    yield f"    status |= {word.upper()}_AT_LIMIT;"
    yield "}"
