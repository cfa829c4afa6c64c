"""One sample of the law as a MATLAB function, in the subset that Simulink and Octave run too.

``W_start()`` returns the state before the first sample; ``W_step(state, inputs, sample_time)``
returns outputs, the next state and a status.  The state is a struct whose fields never change,
because a MATLAB Function block can only keep such a struct.
"""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal

from takagi.reports.code.controller_program import (
    Assignment,
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
from takagi.reports.code.proof_words import proof_lines
from takagi.reports.code.sampling import longest_sample
from takagi.reports.code.status import BIT, REPORTED, reported_range, status_bits

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

FUNCTIONS = """
function y = limit(x, a, b)
y = min(max(x, a), b);
end

function y = choose(d, a, b)
if d < 0, y = a; else, y = b; end
end

function k = interval(x, X, first, last)
% The largest k from first to last with X(k) <= x, or first.
k = first;
while k < last && X(k + 1) <= x
    k = k + 1;
end
end

function y = hold(x, X, Y)
y = Y(interval(x, X, 1, numel(X) - 1));
end

function y = slope(x, X, Y)
k = interval(x, X, 1, numel(X) - 1);
y = (Y(k + 1) - Y(k))/(X(k + 1) - X(k));
end

function y = line(x, X, Y)
k = interval(x, X, 1, numel(X) - 1);
y = Y(k) + (Y(k + 1) - Y(k))/(X(k + 1) - X(k))*(limit(x, X(1), X(end)) - X(k));
end

function y = mix(R, Y, w)
% The sum of Y over the rules, weighted by products of the premises' weights w.
if numel(Y) == 1
    y = Y(1);
    return
end
y = 0;
for i = 1:numel(Y)
    h = 1;
    for k = 1:numel(w)
        if R(i, k) == 1, h = h*w(k); else, h = h*(1 - w(k)); end
    end
    y = y + h*Y(i);
end
end

function [k, b] = basis(x, t)
% The four cubic B-splines at x over the knots t (de Boor 2001, BSPLVB).
x = limit(x, t(4), t(end - 3));
k = interval(x, t, 4, numel(t) - 4);
b = [1; 0; 0; 0];
left = zeros(3, 1);
right = zeros(3, 1);
for j = 1:3
    left(j) = x - t(k + 1 - j);
    right(j) = t(k + j) - x;
    saved = 0;
    for r = 1:j
        part = b(r)/(right(r) + left(j + 1 - r));
        b(r) = saved + right(r)*part;
        saved = left(j + 1 - r)*part;
    end
    b(j + 1) = saved;
end
end

function y = spline1(x, S)
[k, b] = basis(x, S.knots1);
y = 0;
for i = 1:4, y = y + b(i)*S.coefficients(k - 4 + i); end
end

function y = spline2(x1, x2, S)
[k, b] = basis(x1, S.knots1);
[m, d] = basis(x2, S.knots2);
y = 0;
for i = 1:4
    for j = 1:4, y = y + b(i)*d(j)*S.coefficients(k - 4 + i, m - 4 + j); end
end
end
"""


def words_of(program: ControllerProgram) -> dict[str, str]:
    """Return name of the program -> identifier in MATLAB, which must not begin with ``_``."""
    stripped = {name: name.lstrip("_") or "x" for name in program.names()}
    unique = identifiers(stripped.values(), RESERVED, language="MATLAB")
    return {name: unique[word] for name, word in stripped.items()}


def start_function(program: ControllerProgram, word: str, time: Decimal) -> str:
    """Return the text of ``W_start.m``."""
    names = words_of(program)
    lines = [
        f"function state = {word}_start()",
        f"%{word.upper()}_START  State of {word}_step before the first sample.",
        "state = struct();",
        "state.started = false;",
        f"state.sample_time = {time};",
    ]
    lines += [
        f"state.inputs.{names[signal.name]} = {signal.rest or 0};" for signal in program.inputs
    ]
    lines += [f"state.outputs.{names[signal.name]} = 0;" for signal in program.outputs]
    lines += ["state.kept = struct();"]
    lines += [f"state.kept.{names[state.name]} = 0;" for state in program.kept]
    return "\n".join([*lines, "end"]) + "\n"


def step_function(program: ControllerProgram, word: str) -> str:
    """Return the text of ``W_step.m``, with the functions that it calls."""
    return "\n".join(_Writing(program, word).lines()) + "\n" + FUNCTIONS


class _Writing:
    def __init__(self, program: ControllerProgram, word: str) -> None:
        self.program, self.word = program, word
        self.names = words_of(program)
        self.constants = {constant.name for constant in program.constants}

    def lines(self) -> Iterator[str]:
        program, word = self.program, self.word
        yield f"function [outputs, state, status] = {word}_step(state, inputs, sample_time)"
        yield f"%{word.upper()}_STEP  {_line(program.name)}: one sample of the law."
        for line in proof_lines(program):
            yield f"%   {_line(line)}"
        yield f"%   SI units, angles in rad. Start from {word}_start()."
        yield "%   The numbers are those of the gain file."
        for kind, signals in (("inputs", program.inputs), ("outputs", program.outputs)):
            for signal in signals:
                signal_words = _line(f"{signal.meaning} [{signal.unit}]")
                yield f"%   {kind}.{self.names[signal.name]}: {signal_words}"
        yield "%   status is 0 or a sum of"
        for number, _, text in sorted(status_bits(program, REPORTED)):
            yield f"%     {number}  {text}"
        for constant in program.constants:
            yield from self._constant(constant)
        yield from self._read()
        for stage in program.stages:
            yield f"% {_line(stage.name)}"
            if stage.kept:
                yield from self._kept(stage.kept)
            for step in stage.assignments:
                yield from self._assignment(step)
        yield from self._after()
        yield "end"

    def _constant(self, constant: Constant) -> Iterator[str]:
        name, value = self.names[constant.name], constant.value
        note = f"  % {_line(constant.unit)}; {constant.place}"
        if isinstance(value, Spline):
            for k, knots in enumerate(value.knots, start=1):
                yield f"{name}.knots{k} = {_matrix([knots])};{note}"
            yield f"{name}.coefficients = {_matrix(value.coefficients)};"
        elif isinstance(value, Decimal):
            yield f"{name} = {value};{note}"
        else:
            rows = value if isinstance(value[0], tuple) else [value]
            yield f"{name} = {_matrix(rows)};{note}"

    def _read(self) -> Iterator[str]:
        fixed = self.program.sample_time
        good = "sample_time > 0 && isfinite(sample_time)"
        if fixed is not None:
            good = f"abs(sample_time - {fixed}) <= {fixed / 1000}"
        yield "status = 0;"
        yield f"if {good}, T = sample_time;"
        yield f"else, T = state.sample_time; status = status + {BIT['SAMPLE_TIME_REFUSED']}; end"
        yield "state.sample_time = T;"
        longest = longest_sample(self.program)
        if longest is not None:
            yield f"if T > {longest.time}, status = status + {BIT['SAMPLE_TIME_LONG']}; end"
        yield "ready = true;"
        for signal in self.program.inputs:
            name = self.names[signal.name]
            yield f"if isfinite(inputs.{name}), state.inputs.{name} = inputs.{name}; "[:-1]
            yield "else, ready = false; end"
            yield f"{name} = state.inputs.{name};"
        yield f"if ~ready, status = status + {BIT['INPUT_NOT_FINITE']}; end"
        yield "ready = true;"
        for signal in self.program.inputs:
            if signal.range is not None:
                name = self.names[signal.name]
                low, high = reported_range(signal.range)
                yield f"if {name} < {low} || {name} > {high}, ready = false; end"
        yield f"if ~ready, status = status + {BIT['INPUT_OUTSIDE']}; end"

    def _kept(self, kept: tuple[object, ...]) -> Iterator[str]:
        found = [state for state in self.program.kept if state in kept]
        yield "if state.started"
        for one in found:
            yield f"    {self.names[one.name]} = state.kept.{self.names[one.name]};"
        yield "else"
        for one in found:
            yield f"    {self.names[one.name]} = {self._text(one.start)};"
        yield "end"

    def _assignment(self, assignment: Assignment) -> Iterator[str]:
        target = self.names[assignment.name]
        if not assignment.near:
            yield f"{target} = {self._text(assignment.formula)};"
            return
        for k, near in enumerate(assignment.near):
            yield f"{'elseif' if k else 'if'} abs({self._text(near.of)}) <= {near.within}"
            yield f"    {target} = {self._text(near.formula)};"
        yield "else"
        yield f"    {target} = {self._text(assignment.formula)};"
        yield "end"

    def _after(self) -> Iterator[str]:
        program, names = self.program, self.names
        yield "% All kept values are updated together, and only if every result is finite."
        yield "ready = true;"
        yield "next = state.kept;"
        for state in program.kept:
            yield f"next.{names[state.name]} = {self._text(state.next)};"
            yield f"ready = ready && isfinite(next.{names[state.name]});"
        for signal in program.outputs:
            yield f"ready = ready && isfinite({names[signal.name]});"
        yield "if ready"
        yield "    state.kept = next;"
        yield "    state.started = true;"
        for signal in program.outputs:
            yield f"    state.outputs.{names[signal.name]} = {names[signal.name]};"
        yield "else"
        yield f"    status = status + {BIT['RESULT_NOT_FINITE']};"
        yield "end"
        yield "outputs = state.outputs;"

    def _text(self, formula: Formula) -> str:
        match formula:
            case Number(value):
                return str(value)
            case Name("sample_time"):
                return "T"
            case Name(name):
                return self.names.get(name, name)
            case Operation(sign, None, right):
                return f"({sign}{self._text(right)})"
            case Operation(sign, left, right) if left is not None:
                return f"({self._text(left)}{sign}{self._text(right)})"
            case Call("first", (row,)):
                return f"{self._text(row)}(1)"
            case Call("last", (row,)):
                return f"{self._text(row)}(end)"
            case Call("mix", (rules, values, *weights)):
                weight_texts = ", ".join(map(self._text, weights))
                return f"mix({self._text(rules)}, {self._text(values)}, [{weight_texts}])"
            case Call("spline", arguments):
                word = f"spline{len(arguments) - 1}"
                return f"{word}({', '.join(map(self._text, arguments))})"
            case Call(function, arguments):
                return f"{function}({', '.join(map(self._text, arguments))})"
        raise AssertionError(formula)


def _matrix(rows: object) -> str:
    """Return rows of numbers as a matrix, eight numbers in a line."""
    texts = []
    for row in rows:  # type: ignore[attr-defined]
        numbers = [str(number) for number in row]
        lines = [" ".join(numbers[k : k + 8]) for k in range(0, len(numbers), 8)]
        texts.append(" ...\n    ".join(lines))
    return "[" + "; ...\n    ".join(texts) + "]"


def _line(text: str) -> str:
    """Return a text on one line, for a comment."""
    return " ".join(text.split())
