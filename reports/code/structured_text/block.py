"""The target `st`: a function block in Structured Text (IEC 61131-3), and a README.

The block stores its kept values and its last outputs, and reads each input once in a cycle.  An
input that is not a number, or larger than any measurement, is replaced by its last good value;
before the first good value by one of the gain file.  If a result is not a number, kept values and
outputs do not change.  ``status`` says which of these cases occurred.

The standard has no functions on arrays of any length.  So each look-up in a table becomes a loop
over its constant arrays, before the assignment that needs it.  If two formulas need the same search
or the same weights of rules, these are written once: every name is set once in a sample, so that
the values cannot change in between.

Source of keywords and functions: IEC 61131-3:2013, tables of keywords and of standard functions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from typing import Any

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
    Spline,
    file_word,
    identifiers,
    reserved_words,
)
from takagi.reports.code.targets import REPORTED, Exported, ExportSettings, filled, shared_context

# Word of the gain file's language -> standard function.
_SAME_NAME = ("abs", "sqrt", "exp", "sin", "cos", "tan", "asin", "acos", "atan", "min", "max")
FUNCTIONS = {"log": "LN", **{name: name.upper() for name in _SAME_NAME}}

# Functions that the standard lacks, expressed by those that it has: {0} is the argument.
WRITTEN_OUT = {
    "sinh": "((EXP({0}) - EXP(-({0}))) / 2.0)",
    "cosh": "((EXP({0}) + EXP(-({0}))) / 2.0)",
    "tanh": "(1.0 - 2.0 / (EXP(2.0 * ({0})) + 1.0))",
    "asinh": "LN(({0}) + SQRT(({0}) * ({0}) + 1.0))",
    "acosh": "LN(({0}) + SQRT(({0}) * ({0}) - 1.0))",
    "atanh": "(LN((1.0 + ({0})) / (1.0 - ({0}))) / 2.0)",
}

RESERVED = reserved_words("st")


# The largest whole power that is written as a product; for all other powers EXPT is used.
LARGEST_PRODUCT = 4


def told(text: str) -> str:
    """Return a text that a comment can hold: one line, no quotes, no end of a comment."""
    plain = " ".join(text.split())
    return plain.translate({ord("'"): "`", ord('"'): "`", ord("$"): "S", ord("*"): "x"})


def real(value: Decimal) -> str:
    """Return a decimal as a literal of type LREAL: with a point, the digits unchanged."""
    text = str(value).upper()
    mantissa, mark, exponent = text.partition("E")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}{mark}{exponent}"


class Statements:
    """Lines of a function block's body, and the variables that they need.

    Parameters
    ----------
    constants : the program's, by name.
    words : each name of the program as an identifier.
    """

    def __init__(self, constants: Mapping[str, Constant], words: Mapping[str, str]) -> None:
        self.constants, self.words = constants, words
        self.lines: list[str] = []
        self.indices: list[str] = []  # INT
        self.arrays: dict[str, int] = {}  # LREAL, by their last index
        self.found: dict[tuple[object, ...], str] = {}
        self.indent = ""

    def say(self, line: str) -> None:
        """Add a line."""
        self.lines.append(f"{self.indent}{line}")

    def start(self, states: Iterable[Kept]) -> None:
        """Add the start of kept values, at the first sample alone."""
        lookups = dict(self.found)
        self.say("IF NOT started THEN")
        self.indent = "    "
        for state in states:
            self.say(f"{self.words[state.name]} := {self.text(state.start)};")
        self.indent, self.found = "", lookups
        self.say("END_IF;")

    def assign(self, assignment: Assignment) -> None:
        """Add an assignment; where it has ``near``, the formula of the place where it holds."""
        if assignment.meaning:
            self.say(f"(* {told(assignment.meaning)} *)")
        target = self.words[assignment.name]
        for k, near in enumerate(assignment.near):
            self.say(
                f"{'ELSIF' if k else 'IF'} ABS({self.text(near.of)}) <= {real(near.within)} THEN"
            )
            self.say(f"    {target} := {self.text(near.formula)};")
        if assignment.near:
            self.say("ELSE")
        # Look-ups that only this branch needs would be written inside it, and be missed later.
        outer_indent, self.indent = self.indent, self.indent + ("    " if assignment.near else "")
        lookups = dict(self.found)
        self.say(f"{target} := {self.text(assignment.formula)};")
        self.indent = outer_indent
        if assignment.near:
            self.found = lookups
            self.say("END_IF;")

    def text(self, formula: Formula) -> str:
        """Return a formula as an expression, after the statements that it needs."""
        match formula:
            case Number(value):
                return real(value)
            case Name("pi"):
                return "3.141592653589793"
            case Name(name):
                return self.words.get(name, name)
            case Operation("^", left, right):
                return self._power(self.text(left) if left is not None else "", right)
            case Operation(sign, None, right):
                return f"({sign}{self.text(right)})"
            case Operation(sign, left, right) if left is not None:
                return f"({self.text(left)} {sign} {self.text(right)})"
            case Call(function, arguments):
                return self._call(function, arguments)
        raise ModelError(f"{formula!r} cannot be written in Structured Text")

    def _power(self, base: str, exponent: Formula) -> str:
        power = exponent.value if isinstance(exponent, Number) else Decimal(0)
        if power == int(power) and 1 <= power <= LARGEST_PRODUCT:
            return "(" + " * ".join([base] * int(power)) + ")"
        return f"EXPT({base}, {self.text(exponent)})"

    def _call(self, function: str, arguments: tuple[Formula, ...]) -> str:
        if function in ("line", "slope", "hold"):
            return self._table(function, *arguments)
        if function == "mix":
            return self._mix(*arguments)
        if function == "spline":
            return self._spline(*arguments)
        if function in ("first", "last"):
            name = self._name(arguments[0])
            return f"{self.words[name]}[{0 if function == 'first' else self._last(name)}]"
        texts = [self.text(argument) for argument in arguments]
        if function == "limit":
            # The standard's LIMIT takes the lower end first; the order in which ends that cross
            # are met is not fixed there, so the two calls are written out.
            return f"MIN(MAX({texts[0]}, {texts[1]}), {texts[2]})"
        if function == "choose":
            return f"SEL({texts[0]} < 0.0, {texts[2]}, {texts[1]})"
        if function in FUNCTIONS:
            return f"{FUNCTIONS[function]}({', '.join(texts)})"
        if function in WRITTEN_OUT:
            return WRITTEN_OUT[function].format(texts[0])
        raise ModelError(
            f"function {function} is not in Structured Text; write the law with --to c, or replace "
            f"{function} in the model file by a formula of exp, log, sqrt or a table"
        )

    def _name(self, formula: Formula) -> str:
        if isinstance(formula, Name) and formula.name in self.constants:
            return formula.name
        raise ModelError(f"a table of the file is needed where {formula!r} stands")

    def _last(self, name: str) -> int:
        value = self.constants[name].value
        return len(value) - 1 if isinstance(value, tuple) else 0

    def _index(self, x: str, row: str, first: int, last: int) -> str:
        """Return the variable with the largest k from first to last with row[k] <= x, or first."""
        key = ("index", x, row, first, last)
        if key not in self.found:
            self.found[key] = index = f"k_{len(self.indices) + 1}"
            self.indices.append(index)
            self.say(f"{index} := {first};")
            self.say(f"WHILE {index} < {last} DO")
            self.say(f"    IF {row}[{index} + 1] > {x} THEN EXIT; END_IF;")
            self.say(f"    {index} := {index} + 1;")
            self.say("END_WHILE;")
        return self.found[key]

    def _table(self, function: str, x: Formula, nodes: Formula, values: Formula) -> str:
        at, X, Y = self.text(x), self.words[self._name(nodes)], self.words[self._name(values)]
        last = self._last(self._name(nodes))
        k = self._index(at, X, 0, last - 1)
        if function == "hold":
            return f"{Y}[{k}]"
        slope = f"(({Y}[{k} + 1] - {Y}[{k}]) / ({X}[{k} + 1] - {X}[{k}]))"
        if function == "slope":
            return slope
        limited = f"MIN(MAX({at}, {X}[0]), {X}[{last}])"
        return f"({Y}[{k}] + {slope} * ({limited} - {X}[{k}]))"

    def _array(self, word: str, last: int) -> str:
        name = f"{word}_{len(self.arrays) + 1}"
        self.arrays[name] = last
        return name

    def _mix(self, rules: Formula, values: Formula, *weights: Formula) -> str:
        Y = self._name(values)
        if self._last(Y) == 0:
            return f"{self.words[Y]}[0]"
        R = self._name(rules)
        texts = [self.text(weight) for weight in weights]
        key = ("weights", R, *texts)
        last = self._last(R)
        if key not in self.found:
            self.found[key] = h = self._array("h", last)
            self.say(f"FOR i := 0 TO {last} DO")
            self.say(f"    {h}[i] := 1.0;")
            for k, text in enumerate(texts):
                self.say(
                    f"    IF {self.words[R]}[i, {k}] = 1 THEN {h}[i] := {h}[i] * {text}; "
                    f"ELSE {h}[i] := {h}[i] * (1.0 - {text}); END_IF;"
                )
            self.say("END_FOR;")
        h = self.found[key]
        mixed = ("mix", h, Y)
        if mixed not in self.found:
            self.found[mixed] = m = self._array("m", 0)
            self.say(f"{m}[0] := 0.0;")
            self.say(
                f"FOR i := 0 TO {last} DO {m}[0] := {m}[0] + {h}[i] * {self.words[Y]}[i]; END_FOR;"
            )
        return f"{self.found[mixed]}[0]"

    def _spline(self, *arguments: Formula) -> str:
        name = self._name(arguments[-1])
        value = self.constants[name].value
        if not isinstance(value, Spline) or len(value.knots) != len(arguments) - 1:
            raise ModelError(f"{name} is no spline of {len(arguments) - 1} arguments")
        word = self.words[name]
        bases = [
            self._basis(self.text(x), self.words[f"{name} t{k}"], len(knots))
            for k, (x, knots) in enumerate(zip(arguments[:-1], value.knots, strict=True), start=1)
        ]
        m = self._array("m", 0)
        self.say(f"{m}[0] := 0.0;")
        if len(bases) == 1:
            ((k, b),) = bases
            self.say(
                f"FOR i := 0 TO 3 DO {m}[0] := {m}[0] + {b}[i] * {word}[{k} - 3 + i]; END_FOR;"
            )
        else:
            (k, b), (at, c) = bases
            self.say("FOR i := 0 TO 3 DO")
            self.say(
                f"    FOR j := 0 TO 3 DO {m}[0] := {m}[0] + {b}[i] * {c}[j] * "
                f"{word}[{k} - 3 + i, {at} - 3 + j]; END_FOR;"
            )
            self.say("END_FOR;")
        return f"{m}[0]"

    def _basis(self, x: str, knots: str, count: int) -> tuple[str, str]:
        """Return the interval's index and the array with the four cubic B-splines there.

        Source: de Boor, A Practical Guide to Splines (2001), chapter X, algorithm BSPLVB.
        """
        key = ("basis", x, knots)
        if key not in self.found:
            limited = self._array("x", 0)
            self.say(f"{limited}[0] := MIN(MAX({x}, {knots}[3]), {knots}[{count - 4}]);")
            k = self._index(f"{limited}[0]", knots, 3, count - 5)
            b = self._array("b", 3)
            left_distance, right_distance = self._array("dl", 3), self._array("dr", 3)
            self.say(f"{b}[0] := 1.0;")
            self.say("FOR j := 1 TO 3 DO")
            self.say(f"    {left_distance}[j] := {limited}[0] - {knots}[{k} + 1 - j];")
            self.say(f"    {right_distance}[j] := {knots}[{k} + j] - {limited}[0];")
            self.say("    saved := 0.0;")
            self.say("    FOR i := 0 TO j - 1 DO")
            self.say(
                f"        part := {b}[i] / ({right_distance}[i + 1] + {left_distance}[j - i]);"
            )
            self.say(f"        {b}[i] := saved + {right_distance}[i + 1] * part;")
            self.say(f"        saved := {left_distance}[j - i] * part;")
            self.say("    END_FOR;")
            self.say(f"    {b}[j] := saved;")
            self.say("END_FOR;")
            self.found[key] = f"{k} {b}"
        k, b = self.found[key].split()
        return k, b


LARGEST = "1.0E30"  # no measurement in SI units is larger
# Largest number of entries of an array that small controllers accept (64 KiB of LREAL).
LARGEST_ARRAY = 8192


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the function block and a README.

    Raises
    ------
    ModelError : single precision, or a law that Structured Text cannot express.
    """
    if settings.precision != "double":
        raise ModelError("--to st computes in LREAL; leave --precision out, or take --to c")
    context = _context(program, settings)
    file, block = context["file"], context["block"]
    return Exported(
        {
            f"{file}.st": filled("structured_text", "block.st", context),
            "README.md": filled("structured_text", "README.md", context),
        },
        {
            f"{file}.st": f"function block {block}: import it, call it every sample",
            "README.md": "inputs, outputs, units and status",
        },
    )


def function_block(program: ControllerProgram, settings: ExportSettings) -> str:
    """Return the text of the function block."""
    return filled("structured_text", "block.st", _context(program, settings))


def _context(program: ControllerProgram, settings: ExportSettings) -> dict[str, Any]:
    """Return what the templates are filled with."""
    for constant in program.constants:
        _require_room(constant)
    word, inside = _words(program)
    file = file_word(program.plant)
    return shared_context(program, settings, REPORTED) | {
        "file": file,
        "block": f"FB_{file.upper()}",
        "zero": Decimal(0),
        "word": word,
        "inside": inside,
        "LARGEST": LARGEST,
        "constants": [line for constant in program.constants for line in _constant(constant, word)],
        "statements": _statements(program, word, inside),
        "told": told,
        "note": lambda entry: told(
            f"{entry.unit}: {getattr(entry, 'words', entry.meaning)}".removesuffix(": ")
        ),
        "real": real,
    }


def _words(program: ControllerProgram) -> tuple[dict[str, str], dict[str, str]]:
    """Return the identifier of each name, and the one that formulas use."""
    inputs, outputs = program.inputs, program.outputs
    names = [signal.name for signal in (*inputs, *outputs)]
    rest = [name for name in program.names() if name not in names]
    splines = [
        f"{constant.name} t{k}"
        for constant in program.constants
        if isinstance(constant.value, Spline)
        for k in range(1, len(constant.value.knots) + 1)
    ]
    added = [f"{signal.name} seen" for signal in inputs]
    added += [f"{signal.name} now" for signal in outputs]
    added += [f"{state.name} after" for state in program.kept]
    helpers = {f"{word}_{k}" for word in ("dl", "dr", *"khmxb") for k in range(1, 100)}
    word = identifiers(
        [*names, *rest, *added, "step time", *splines],
        RESERVED | helpers | {"i", "j", "part", "saved"},
        language="Structured Text",
        ignore_case=True,
    )
    inside = {signal.name: word[f"{signal.name} seen"] for signal in inputs}
    inside |= {signal.name: word[f"{signal.name} now"] for signal in outputs}
    inside |= {name: word[name] for name in (*rest, *splines)}
    return word, inside | {"sample_time": word["step time"]}


def _constant(constant: Constant, words: Mapping[str, str]) -> Iterator[str]:
    word, value = words[constant.name], constant.value
    # In a path such as K.*.0 some tools would read the end of a comment.
    note = f"(* {told(constant.unit)}; {constant.path.replace('*', 'i')} *)"
    if isinstance(value, Decimal):
        yield f"    {word} : LREAL := {real(value)}; {note}"
    elif isinstance(value, Spline):
        for k, knots in enumerate(value.knots, start=1):
            yield from _array(words[f"{constant.name} t{k}"], [knots], "LREAL", note)
        yield from _array(word, value.coefficients, "LREAL", note, flat=len(value.knots) == 1)
    elif isinstance(value[0], tuple):
        yield from _array(word, value, "INT", note, flat=False)
    else:
        yield from _array(word, [value], "LREAL", note)


def _statements(
    program: ControllerProgram, word: Mapping[str, str], inside: Mapping[str, str]
) -> Statements:
    """Return the steps of all stages, then the values that are kept until the next sample."""
    constants = {constant.name: constant for constant in program.constants}
    statements = Statements(constants, inside)
    for stage in program.stages:
        statements.say("")
        statements.say(f"(* {told(stage.name)} *)")
        if stage.kept:
            statements.start(stage.kept)
        for step in stage.assignments:
            statements.assign(step)
    statements.say("")
    statements.say("(* values that are kept until the next sample; all are updated together *)")
    for kept in program.kept:
        statements.say(f"{word[f'{kept.name} after']} := {statements.text(kept.next)};")
    return statements


def _array(
    word: str, rows: Iterable[Iterable[Decimal]], kind: str, note: str, *, flat: bool = True
) -> Iterator[str]:
    """Yield the declaration of an array, eight numbers in a line."""
    table = [list(row) for row in rows]
    numbers = [str(int(value)) if kind == "INT" else real(value) for row in table for value in row]
    size = f"0..{len(numbers) - 1}" if flat else f"0..{len(table) - 1}, 0..{len(table[0]) - 1}"
    yield f"    {word} : ARRAY[{size}] OF {kind} := [ {note}"
    for k in range(0, len(numbers), 8):
        tail = "" if k + 8 >= len(numbers) else ","
        yield "        " + ", ".join(numbers[k : k + 8]) + tail
    yield "    ];"


def _require_room(constant: Constant) -> None:
    value = constant.value
    rows = value.coefficients if isinstance(value, Spline) else value
    if isinstance(rows, tuple):
        count = sum(len(row) if isinstance(row, tuple) else 1 for row in rows)
        if count > LARGEST_ARRAY:
            raise ModelError(
                f"{constant.name} ({constant.path}) has {count} numbers; a function block holds "
                f"{LARGEST_ARRAY}: design with fewer rules (fewer premises, or product bounds), or "
                "write the law with --to c"
            )
