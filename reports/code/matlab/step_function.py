"""One sample of the law as a MATLAB function, in the subset that Simulink and Octave run too.

``W_start()`` returns the state before the first sample; ``W_step(state, inputs, sample_time)``
returns outputs, the next state and a status.  The state is a struct whose fields never change,
because a MATLAB Function block can only keep such a struct.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal

from takagi.reports.code.controller_program import (
    Call,
    Constant,
    ControllerProgram,
    Formula,
    Name,
    Number,
    Operation,
    Spline,
    identifiers,
)
from takagi.reports.code.sampling import BIT, REPORTED, longest_sample, reported_range, status_bits
from takagi.reports.code.target_text import as_list, filled, proof_lines

# Keywords and functions that a name must not replace.
RESERVED = frozenset(
    """
    break case catch classdef continue do else elseif end end_try_catch end_unwind_protect endfor
    endfunction endif endswitch endwhile for function global if otherwise parfor persistent return
    spmd switch try until unwind_protect unwind_protect_cleanup while
    abs sqrt exp log sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf min max pi
    i j e eps inf nan Inf NaN ans isempty isfinite struct numel prod sum true false single double
    limit choose line slope hold mix spline1 spline2 basis interval first last
    state inputs outputs status sample_time T kept next c
    """.split()
)


def words_of(program: ControllerProgram) -> dict[str, str]:
    """Return name of the program -> identifier in MATLAB, which must not begin with ``_``."""
    stripped = {name: name.lstrip("_") or "x" for name in program.names()}
    unique = identifiers(stripped.values(), RESERVED, language="MATLAB")
    return {name: unique[word] for name, word in stripped.items()}


def texts(program: ControllerProgram, word: str, time: Decimal) -> dict[str, str]:
    """Return ``W_step.m`` with the functions that it calls, ``W_start.m`` and ``README.md``."""
    names = words_of(program)
    context = {
        "program": program,
        "word": word,
        "time": time,
        "names": names,
        "proof": proof_lines(program),
        "status": status_bits(program, REPORTED),
        "BIT": BIT,
        "longest": longest_sample(program),
        "constants": [
            line
            for constant in program.constants
            for line in _definition(constant, names[constant.name])
        ],
        "text": lambda formula: _text(formula, names),
        "line": _line,
        "as_list": as_list,
        "reported_range": reported_range,
    }
    templates = {f"{word}_step.m": "step.m", f"{word}_start.m": "start.m", "README.md": "README.md"}
    return {name: filled("matlab", template, context) for name, template in templates.items()}


def _definition(constant: Constant, name: str) -> Iterator[str]:
    value = constant.value
    note = f"  % {_line(constant.unit)}; {constant.path}"
    if isinstance(value, Spline):
        for k, knots in enumerate(value.knots, start=1):
            yield f"{name}.knots{k} = {_matrix([knots])};{note}"
        yield f"{name}.coefficients = {_matrix(value.coefficients)};"
    elif isinstance(value, Decimal):
        yield f"{name} = {value};{note}"
    else:
        rows = value if isinstance(value[0], tuple) else [value]
        yield f"{name} = {_matrix(rows)};{note}"


def _text(formula: Formula, names: Mapping[str, str]) -> str:
    def text(part: Formula) -> str:
        return _text(part, names)

    match formula:
        case Number(value):
            return str(value)
        case Name("sample_time"):
            return "T"
        case Name(name):
            return names.get(name, name)
        case Operation(sign, None, right):
            return f"({sign}{text(right)})"
        case Operation(sign, left, right) if left is not None:
            return f"({text(left)}{sign}{text(right)})"
        case Call("first", (row,)):
            return f"{text(row)}(1)"
        case Call("last", (row,)):
            return f"{text(row)}(end)"
        case Call("mix", (rules, values, *weights)):
            weight_texts = ", ".join(map(text, weights))
            return f"mix({text(rules)}, {text(values)}, [{weight_texts}])"
        case Call("spline", arguments):
            word = f"spline{len(arguments) - 1}"
            return f"{word}({', '.join(map(text, arguments))})"
        case Call(function, arguments):
            return f"{function}({', '.join(map(text, arguments))})"
    raise AssertionError(formula)


def _matrix(rows: Iterable[Iterable[object]]) -> str:
    """Return rows of numbers as a matrix, eight numbers in a line."""
    texts = []
    for row in rows:
        numbers = [str(number) for number in row]
        lines = [" ".join(numbers[k : k + 8]) for k in range(0, len(numbers), 8)]
        texts.append(" ...\n    ".join(lines))
    return "[" + "; ...\n    ".join(texts) + "]"


def _line(text: str) -> str:
    """Return a text on one line, for a comment."""
    return " ".join(text.split())
