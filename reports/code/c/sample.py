"""One sample of a law as a function in C: what is computed from what, in the file's order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from takagi.reports.code.c.expressions import Expressions, literal
from takagi.reports.code.c.words import comment
from takagi.reports.code.controller_program import (
    Assignment,
    ControllerProgram,
    Kept,
    Near,
    Spline,
    Stage,
)
from takagi.reports.code.formula import Call, Formula, Name, Operation, names_of

# The value that an observer sends to a law, or that is measured in its place.
ESTIMATE = "wind_estimate"


def needed_names(program: ControllerProgram) -> frozenset[str]:
    """Return the names on which outputs and kept values depend; others are not written."""
    made = {one.name: _formulas(one) for one in program.assignments}
    kept = {one.name: (one.start, one.next) for one in program.kept}
    needed: set[str] = set()
    waiting = [*(one.name for one in program.outputs), *kept]
    while waiting:
        name = waiting.pop()
        if name in needed:
            continue
        needed.add(name)
        for formula in (*made.get(name, ()), *kept.get(name, ())):
            waiting += _read(formula, program)
    return frozenset(needed)


def _read(formula: Formula, program: ControllerProgram) -> Iterator[str]:
    """Yield the names whose values matter; a mix of one rule depends on its value alone."""
    if isinstance(formula, Call) and formula.function == "mix":
        values = formula.arguments[1]
        assert isinstance(values, Name)
        for constant in program.constants:
            if constant.name == values.name and len(constant.value) == 1:  # type: ignore[arg-type]
                yield values.name
                return
    if isinstance(formula, Call):
        for argument in formula.arguments:
            yield from _read(argument, program)
    elif isinstance(formula, Operation):
        for part in (formula.left, formula.right):
            if part is not None:
                yield from _read(part, program)
    else:
        yield from names_of(formula)


def _formulas(one: Assignment) -> tuple[Formula, ...]:
    inside = (formula for place in one.near for formula in (place.of, place.formula))
    return (one.formula, *inside)


def sample_function(
    program: ControllerProgram, word: str, needed: frozenset[str], write: Expressions
) -> str:
    """Return the static function ``W_sample``: one sample from state and inputs.

    It writes only to its two arguments for results: the outputs, and the next kept values.  It
    returns the status bits of a command at a limit and of a wind estimate that is held.
    """
    names = write.names
    lines = [f"const {word}_real {names[one.name]} = inputs->{names[one.name]};"
             for one in program.inputs if one.name in needed]  # fmt: skip
    if "sample_time" in needed:
        lines.append(f"const {word}_real {names['sample_time']} = state->sample_time;")
    lines.append("unsigned status = 0u;")
    for stage in program.stages:
        lines += ["", f"/* {comment(stage.name)} */", *_start(stage.kept, word, write)]
        for one in stage.assignments:
            if one.name in needed:
                lines += assignment_lines(one, word, write)
                lines += _estimate_held(one, stage, word, write)
    lines.append("")
    for sent in program.outputs:
        lines += _at_limit(sent.name, program, word, write)
        lines.append(f"outputs->{names[sent.name]} = {names[sent.name]};")
    lines += _next(program.kept, write)
    lines.append("return status;")
    kept = f", {word}_kept *next" if program.kept else ""
    if not program.kept and "sample_time" not in needed:
        lines.insert(0, "(void)state;")
    head = (
        f"\n/* One sample: fills outputs{' and the kept values of the next' if kept else ''}. */\n"
        f"static unsigned {word}_sample(const {word}_state *state, const {word}_inputs *inputs,\n"
        f"    {word}_outputs *outputs{kept})\n"
    )
    return head + "{\n" + "".join(f"    {one}\n" if one else "\n" for one in lines) + "}\n"


def _start(kept: Sequence[Kept], word: str, write: Expressions) -> Iterator[str]:
    """Yield the lines that give a stage's kept values: those of the last sample, or the start."""
    for one in kept:
        yield f"{word}_real {write.names[one.name]} = state->kept.{write.names[one.name]};"
    if not kept:
        return
    yield "if (state->samples == 0u) {"
    for one in kept:
        text = write.text(one.start)
        for line in write.taken_before():
            yield f"    {line}"
        yield f"    {write.names[one.name]} = {text};"
    write.forget()
    yield "}"


def assignment_lines(one: Assignment, word: str, write: Expressions) -> Iterator[str]:
    """Yield the statements that give a local variable of type ``{word}_real`` its value."""
    name = write.names[one.name]
    note = comment(" ".join(part for part in (f"[{one.unit}]", one.meaning) if part))
    if not one.near:
        text = write.text(one.formula)
        yield from write.taken_before()
        yield f"const {word}_real {name} = {text}; /* {note} */"
        return
    # Near a quotient 0/0 the gain file's ``within`` is so small that a float cannot resolve it:
    # the step is computed in double.
    wide = write.in_double(_formulas(one)) if write.suffix else None
    by, cast = (wide, f"({word}_real)") if wide else (write, "")

    def value(formula: Formula) -> str:
        return f"{cast}({by.text(formula)})" if cast else by.text(formula)

    own = value(one.formula)
    branches = [(_is_near(place, by), value(place.formula)) for place in one.near]
    yield from by.taken_before()
    yield f"{word}_real {name}; /* {note} */"
    for k, (condition, formula) in enumerate(branches):
        yield f"{'} else ' if k else ''}if ({condition}) {{"
        yield f"    {name} = {formula};"
    yield "} else {"
    yield f"    {name} = {own};"
    yield "}"


def _is_near(place: Near, write: Expressions) -> str:
    distance = write.text(Call("abs", (place.of,)))
    return f"{distance} <= {literal(place.within, write.suffix)}"


def _estimate_held(one: Assignment, stage: Stage, word: str, write: Expressions) -> Iterator[str]:
    """Yield the lines that set the status bit where a wind estimate is held.

    It is held within the observer's limits and within the winds of the law's tables; and the
    observer's own tables end, for example where the rotor stands.
    """
    conditions = []
    formula = one.formula
    if any(sent.name == ESTIMATE for sent in stage.sends):
        for call in _calls(formula):
            conditions += list(_beyond(call, write))
    if isinstance(formula, Call) and formula.function == "limit":
        x, low, high = formula.arguments
        held = write.names[one.name]
        if x == Name(ESTIMATE):
            wanted = write.factor(x)
            conditions.append(f"{wanted} < {held} || {wanted} > {held}")
        elif any(sent.formula == Name(one.name) for sent in stage.sends if sent.name == ESTIMATE):
            # The observer stops at its limit, so that reaching it is enough.
            ends = write.factor(low), write.factor(high)
            conditions.append(f"{held} <= {ends[0]} || {held} >= {ends[1]}")
    yield from write.taken_before()
    if conditions:
        yield f"if ({' || '.join(conditions)}) {{"
        yield f"    status |= {word.upper()}_ESTIMATE_HELD;"
        yield "}"


def _calls(formula: Formula) -> Iterator[Call]:
    """Yield all calls in a formula."""
    if isinstance(formula, Call):
        yield formula
        for argument in formula.arguments:
            yield from _calls(argument)
    elif isinstance(formula, Operation):
        for part in (formula.left, formula.right):
            if part is not None:
                yield from _calls(part)


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
    made = {one.name: one for one in program.assignments}
    found = made[name]
    while isinstance(found.formula, Name) and found.formula.name in made and not found.near:
        found = made[found.formula.name]
    formula = found.formula
    if found.near or not (isinstance(formula, Call) and formula.function == "limit"):
        return
    wanted, held = write.factor(formula.arguments[0]), write.names[name]
    yield from write.taken_before()
    yield f"if ({wanted} < {held} || {wanted} > {held}) {{"
    yield f"    status |= {word.upper()}_AT_LIMIT;"
    yield "}"


def _next(kept: Sequence[Kept], write: Expressions) -> Iterator[str]:
    for one in kept:
        text = write.text(one.next)
        yield from write.taken_before()
        yield f"next->{write.names[one.name]} = {text};"
