r"""A plant and its embedding, as trees; and the exact vertices of the embedding.

    M(x) x' = f(x, u, w),    y = g(x, u),    x = x* + dx, u = u* + du, w = w* + dw

Each entry of A, B, C, D, E is a polynomial that has at most degree one in each premise, so that it
is the blend of its values at the corners of the premises' bounds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any

from flint import Ordering, fmpq, fmpq_mat, fmpq_mpoly, fmpq_mpoly_ctx

from takagi.certificates.cross_check.kernel.reading import (
    NotReplayed,
    Refusal,
    entry,
    line,
    rational,
)
from takagi.certificates.cross_check.loop.loop import (
    Side,
    VertexLoop,
    close,
    same_weights,
    vertices,
)
from takagi.certificates.cross_check.plant.algebra import power_of, product_of
from takagi.certificates.cross_check.plant.expression import (
    Tree,
    names_in,
    number,
    parsed,
    plus,
    put,
    value_of,
)

MOST_VARIABLES, MOST_PREMISES, MOST_CONSTANTS, MOST_ENTRIES = 64, 12, 6, 1 << 20
MATRIX_SIZES = {"A": ("n", "n"), "B": ("n", "m"), "C": ("p", "n"), "D": ("p", "m"), "E": ("n", "q")}
FUNCTIONS = set(
    "sin cos tan asin acos atan exp log sqrt sinh cosh tanh asinh acosh atanh abs erf sign".split()
)


@dataclass(frozen=True, slots=True)
class Variable:
    """A state, input or disturbance.

    ``symbol`` names its deviation from ``rest``; ``side`` is the range of the deviation.  A law
    does not know a signal that is ``unknown``.
    """

    name: str
    symbol: str
    unit: str
    rest: Tree
    side: Side | None
    unknown: bool = False

    @property
    def label(self) -> str:
        return f"{self.symbol} [{self.unit}]"


@dataclass(frozen=True, slots=True)
class Premise:
    """A premise with its bounds; the names in ``tree`` are symbols of variables."""

    name: str
    tree: Tree
    lower: fmpq
    upper: fmpq


@dataclass(frozen=True, slots=True)
class TreePlant:
    """A plant and its embedding.

    ``f``, ``mass``, ``outputs`` : trees in the symbols of variables, with values of parameters.
    ``entries`` : trees in the names of premises, by the letter of the matrix.
    ``balls`` : names of numbers that are not decimals, each known by a middle and a radius.
    ``numbers`` : constants in entries that are no fractions, with bounds as a premise has.
    """

    states: list[Variable]
    inputs: list[Variable]
    pushes: list[Variable]
    step: fmpq | None
    f: list[Tree]
    mass: list[list[Tree]] | None
    outputs: list[Tree]
    premises: list[Premise]
    entries: dict[str, list[list[Tree]]]
    tables: tuple[str, ...]
    form: str = "sector"
    balls: tuple[str, ...] = ()
    numbers: tuple[Premise, ...] = ()

    @property
    def variables(self) -> list[Variable]:
        return [*self.states, *self.inputs, *self.pushes]


def read_plant(model: Any) -> TreePlant:
    """Return the plant of a model of kind ``plant``.

    Raises
    ------
    Refusal : a part is missing or does not fit, or a name has two meanings.
    """
    meaning: dict[str, Tree] = {}
    tables, parameters = (model.get(key, {}) for key in ("tables", "parameters"))
    if not isinstance(tables, dict) or not isinstance(parameters, dict):
        raise Refusal("tables and parameters are objects")
    taken = {*FUNCTIONS, "pi", *tables}
    balls: list[str] = []
    for name, value in parameters.items():
        if isinstance(value, dict):
            _ball(value)
            entry(value, "equals")
            meaning[_new(name, taken)] = ("name", name)
            balls.append(name)
        else:
            meaning[_new(name, taken)] = number(constant(value))
    groups = []
    for key in ("states", "inputs", "disturbances"):
        listed = model.get(key, [])
        if not isinstance(listed, list):
            raise Refusal(f"{key}: a list is needed")
        groups.append([_variable(one, taken, meaning, balls) for one in listed])
    states, inputs, pushes = groups
    if any(v.unknown for v in [*states, *inputs]):
        raise Refusal("unknown: a state or an input is not")
    count = len(states) + len(inputs) + len(pushes)
    if not states or count > MOST_VARIABLES:
        raise Refusal(f"1 to {MOST_VARIABLES} variables are needed")
    step = None if entry(model, "sample_time") is None else rational(model, "sample_time")
    if step is not None and step <= 0:
        raise Refusal("sample_time: a positive number is needed")
    n = len(states)
    known = {v.symbol for group in groups for v in group}
    own = set(meaning) - {v.symbol for group in groups for v in group if v.symbol != v.name}
    own -= set(balls) - set(parameters)

    def read(written: Any, names: set[str] = own) -> Tree:
        tree = parsed(written, {name: t for name, t in meaning.items() if t[0] == "number"})
        _understood(tree, names, tables)
        return put(tree, meaning)

    f = [read(one) for one in _rows(entry(model, "equations"), n)]
    mass = None
    if model.get("mass") is not None:
        mass = [[read(one) for one in _rows(row, n)] for row in _rows(model["mass"], n)]
    outputs = [read(entry(one, "expression")) for one in _rows(model.get("outputs", []))]
    embedding = entry(model, "embedding")

    def bounded(key: str, names: set[str], most: int) -> list[Premise]:
        listed = _rows(embedding.get(key, []))
        if len(listed) > most:
            raise Refusal(f"at most {most} {key}")
        found = []
        for one in listed:
            lower, upper = constant(entry(one, "lower")), constant(entry(one, "upper"))
            if lower > upper:
                raise Refusal("a premise with its lower bound above the upper one")
            tree = read(entry(one, "expression"), names)
            found.append(Premise(line(one, "name"), tree, lower, upper))
        return found

    entry(embedding, "premises")
    premises = bounded("premises", set(meaning) | known, MOST_PREMISES)
    # What is constant has no variable, but may have a number that is no decimal.
    numbers = bounded("numbers", set(balls), MOST_CONSTANTS)
    for premise in (*premises, *numbers):
        _new(premise.name, taken)
    size = {"n": n, "m": len(inputs), "p": len(outputs), "q": len(pushes)}
    entries = {}
    for letter, (rows, columns) in MATRIX_SIZES.items():
        if size[rows] and size[columns]:
            given = _rows(entry(embedding, letter), size[rows])
            entries[letter] = [[parsed(one) for one in _rows(row, size[columns])] for row in given]
    form = line(embedding, "form") if "form" in embedding else "sector"
    if form not in ("sector", "secant"):
        raise Refusal(f"embedding.form: {form[:40]!a} is not 'sector' or 'secant'")
    if numbers and form == "secant":
        raise Refusal("numbers in an embedding by secants")
    return TreePlant(
        states=states,
        inputs=inputs,
        pushes=pushes,
        step=step,
        f=f,
        mass=mass,
        outputs=outputs,
        premises=premises,
        entries=entries,
        tables=tuple(tables),
        form=form,
        balls=tuple(balls),
        numbers=tuple(numbers),
    )


def _rows(value: Any, count: int | None = None) -> list[Any]:
    if not isinstance(value, list) or count not in (None, len(value)):
        raise Refusal(f"a list of {count or 'some'} entries is needed")
    return value


def _new(name: str, taken: set[str]) -> str:
    if name in taken or not name.isidentifier() or not name.isascii():
        raise Refusal(f"{name[:40]!a} is no new name")
    taken.add(name)
    return name


def constant(value: Any) -> fmpq:
    found = value_of(parsed(value))
    if found is None:
        raise NotReplayed("a number that is not written as a quotient")
    return found


def plant_of_form(model: Any, form: str) -> TreePlant:
    """Return the plant of a claim about its embedding, which has to be of this form.

    Raises
    ------
    Refusal : as ``plant_loop``; or no plant, or another form.
    NotReplayed : as ``require_decimals``.
    """
    if entry(model, "kind") != "plant":
        raise Refusal("a claim about a plant, and the model is none")
    plant = read_plant(model)
    plant_loop(model)
    require_decimals(plant)
    if plant.form != form:
        raise Refusal(f"embedding.form is {plant.form!a}, not {form!a}")
    return plant


def require_decimals(plant: TreePlant) -> None:
    """Raise NotReplayed where a rest or a parameter is a ball: this checker cannot prove a ball."""
    if plant.balls:
        raise NotReplayed("a plant with numbers that are no decimals")


def _understood(tree: Tree, names: set[str], tables: dict[str, Any]) -> None:
    for name in names_in(tree):
        if name not in names and name != "pi":
            raise Refusal(f"the name {name[:40]!a} is not known")
    for called in _calls(tree):
        if called not in FUNCTIONS and called not in tables:
            raise Refusal(f"the function {called[:40]!a} is not known")


def _calls(tree: Tree) -> list[str]:
    parts = tree[2] if tree[0] == "call" else [p for p in tree[1:] if isinstance(p, tuple)]
    found = [tree[1]] if tree[0] == "call" else []
    return found + [name for part in parts for name in _calls(part)]


def _ball(written: dict[str, Any]) -> Side:
    """Return the ends of the interval in which a number that is not a decimal lies."""
    middle, radius = constant(entry(written, "value")), constant(entry(written, "within"))
    if not 0 < radius < abs(middle):
        raise Refusal("a number that is no decimal needs a radius that leaves 0 outside")
    if written.get("equals") is not None:
        _understood(parsed(written["equals"]), set(), {})
    return middle - radius, middle + radius


def _variable(given: Any, taken: set[str], meaning: dict[str, Tree], balls: list[str]) -> Variable:
    name, written = line(given, "name"), entry(given, "rest")
    if isinstance(written, dict):
        own = f"{name}_rest"
        rest, lies = ("name", _new(own, taken)), _ball(written)
        meaning[own] = rest
        balls.append(own)
    else:
        rest = parsed(written)
        if list(names_in(rest)) not in ([], ["pi"]):
            raise Refusal("rest: a number is needed")
        lies = None
    resting = value_of(rest)
    symbol = name if resting == 0 else line(given, "symbol")
    _new(name, taken)
    if symbol != name:
        _new(symbol, taken)
        meaning[symbol] = ("name", symbol)
    elif resting != 0:
        raise Refusal("symbol: the deviation needs a name of its own")
    meaning[name] = plus(rest, ("name", symbol))
    side = None
    if given.get("range") is not None:
        low, high = (constant(end) for end in _rows(given["range"], 2))
        if resting is not None:
            lies = (resting, resting)
        if lies is None:
            raise Refusal("range: its rest must be a rational number")
        if not low <= lies[0] <= lies[1] <= high or low == high:
            raise Refusal("range: it must increase, and contain the rest")
        # These deviations keep the variable in its range for every rest in the interval.
        side = (low - lies[0], high - lies[1])
    hidden = given.get("unknown", False)
    if not isinstance(hidden, bool) or (hidden and side is None):
        raise Refusal("unknown: true or false, and true only with a range")
    return Variable(name, symbol, line(given, "unit"), rest, side, hidden)


def plant_loop(model: Any) -> VertexLoop:
    """Return the vertices, at the corners of the premises' bounds; the last premise changes first.

    Raises
    ------
    Refusal : as ``read_plant``; or an entry that is not of degree one at most in each premise.
    """
    plant = read_plant(model)
    bounds = [(p.lower,) if p.lower == p.upper else (p.lower, p.upper) for p in plant.premises]
    picks = list(product(*(range(len(ends)) for ends in bounds)))
    values = [[ends[k] for ends, k in zip(bounds, chosen, strict=True)] for chosen in picks]
    first, *further = [
        _stacks(plant, values, list(ends))
        for ends in product(*((p.lower, p.upper) for p in plant.numbers))
    ]
    for letter, matrices in first.items():
        for there in further:
            pairs = zip(matrices, there[letter], strict=True)
            if not all(_alike(*pair, strictly=letter in ("C", "D")) for pair in pairs):
                raise Refusal(f"numbers: an entry of {letter} vanishes, or is 1, at one end alone")
    loop = _with_vertices(model, plant, picks, first)
    return replace(loop, extremes=tuple(replace(loop, **some) for some in further))


def _alike(one: fmpq_mat, two: fmpq_mat, *, strictly: bool) -> bool:
    """Whether zeros stand at the same places; strictly: signs and ones too.

    Then it is so between the ends, where an entry is a mean of its values at them.
    """
    for p, q in zip(one.entries(), two.entries(), strict=True):
        if (p == 0) is not (q == 0):
            return False
        if strictly and ((p < 0) is not (q < 0) or (p == 1) is not (q == 1)):
            return False
    return True


def _stacks(plant: TreePlant, values: list[list[fmpq]], constants: list[fmpq]) -> dict[str, Any]:
    """Return the matrices at all corners, with these values of the numbers."""
    names = [p.name for p in (*plant.premises, *plant.numbers)]
    context = fmpq_mpoly_ctx.get(names or ["_"], Ordering.lex)
    count = len(plant.premises)
    stacks: dict[str, Any] = {}
    for letter, rows in plant.entries.items():
        found = [[_affine(one, context, plant.form) for one in row] for row in rows]
        varies = any(any(sum(e[:count]) for e in one.monoms()) for row in found for one in row)
        places = values if varies else values[:1]
        if len(places) * len(rows) * len(rows[0]) > MOST_ENTRIES:
            raise Refusal("too many vertices")
        stacks[letter] = [
            fmpq_mat([[_at(one, [*place, *constants]) for one in row] for row in found])
            for place in places
        ]
    return stacks


def _with_vertices(
    model: Any, plant: TreePlant, picks: list[tuple[int, ...]], stacks: dict[str, Any]
) -> VertexLoop:
    """Return the loop of these matrices."""
    moving = [p for p in plant.premises if p.lower < p.upper]
    used = {name for p in moving for name in names_in(p.tree)}
    others = [*plant.inputs, *plant.pushes]
    return VertexLoop(
        **stacks,
        step=plant.step,
        states=tuple(v.label for v in plant.states),
        inputs=tuple(v.label for v in plant.inputs),
        pushes=tuple(v.label for v in plant.pushes),
        sides=tuple(v.side for v in plant.states),
        other_sides={v.label: v.side for v in others if v.side is not None},
        corners=tuple(picks),
        premises=same_weights(model["embedding"]["premises"], tuple(picks)),
        seen_by=tuple(v.label for v in plant.variables if v.symbol in used),
        # Counted here: a claim may put aside the only matrices that differ between the rules.
        stated=max(map(len, stacks.values())),
        averages=plant.form == "secant",
        of_plant=True,
    )


def _affine(tree: Tree, context: fmpq_mpoly_ctx, form: str) -> fmpq_mpoly:
    found = _polynomial(tree, context)
    if form == "secant" and any(sum(powers) > 1 for powers in found.monoms()):
        raise Refusal("an entry with a product of premises: its mean is no product of means")
    if any(power > 1 for powers in found.monoms() for power in powers):
        raise Refusal("an entry with a premise to a power above one")
    return found


def _polynomial(tree: Tree, context: fmpq_mpoly_ctx) -> fmpq_mpoly:
    if tree[0] == "number":
        return context.constant(tree[1])
    if tree[0] == "name" and tree[1] in context.names():
        return context.gen(context.names().index(tree[1]))
    if tree[0] in ("+", "*"):
        a, b = (_polynomial(part, context) for part in tree[1:])
        return a + b if tree[0] == "+" else product_of(a, b)
    if tree[0] == "/":
        a, b = (_polynomial(part, context) for part in tree[1:])
        if not b.is_constant() or b.is_zero():
            raise Refusal("an entry that is divided by more than a number")
        return a * (1 / b.leading_coefficient())
    if tree[0] == "^" and tree[2].q == 1 and tree[2] >= 0:
        return power_of(_polynomial(tree[1], context), int(tree[2].p))
    if tree[0] == "^" and tree[2].q == 1:
        found = _polynomial(("/", number(1), tree[1]), context)
        return power_of(found, -int(tree[2].p))
    if tree[0] == "name":
        raise Refusal(f"the premise {tree[1][:40]!a} is not known")
    raise NotReplayed("an entry that is not written as a polynomial in premises")


def _at(polynomial: fmpq_mpoly, place: list[fmpq]) -> fmpq:
    total = fmpq(0)
    for powers, factor in polynomial.terms():
        used = (value for value, power in zip(place, powers, strict=False) if power)
        total += fmpq(factor) * prod(used, start=fmpq(1))
    return total


def read_loop(model: Any, gains: Any) -> VertexLoop:
    """Return the loop of a certificate's model and gains.

    Raises
    ------
    Refusal : another kind of model, shapes or names that do not fit.
    """
    kind = entry(model, "kind")
    if kind == "takagi-sugeno":
        loop = vertices(model)
    elif kind == "plant":
        loop = plant_loop(model)
    else:
        raise Refusal(f"a model of kind {kind!a} has no vertices")
    if gains is None:
        return loop
    closed = _closed(loop, model, gains)
    return replace(closed, extremes=tuple(_closed(one, model, gains) for one in loop.extremes))


def _closed(loop: VertexLoop, model: Any, gains: Any) -> VertexLoop:
    kind = entry(model, "kind")
    closed = close(loop, gains)
    if "observer" not in gains:
        return closed
    from takagi.certificates.cross_check.loop.observing import with_observer

    # The slopes are written as the embedding is, with premises of their own.
    slopes = plant_loop(with_slopes(model)) if kind == "plant" and "slopes" in model else None
    return with_observer(closed, model, gains, slopes)


def with_slopes(model: Any) -> Any:
    """Return the model with its slopes in the place of its embedding.

    Raises
    ------
    Refusal : they are no object.
    """
    slopes = entry(model, "slopes")
    if not isinstance(slopes, dict):
        raise Refusal("slopes: an object is needed")
    return {**model, "embedding": {**slopes, "form": "secant"}}
