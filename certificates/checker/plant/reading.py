"""The plant of a certificate, as nodes: equations, trim, premises, entries.

    M(x) x' = f(x, u, w),   y = g(x, u),   x = x* + dx,  u = u* + du,  w = w* + dw

A variable with an equilibrium value other than 0 has a name and a ``symbol`` for its deviation.
Equations use names, premises use names and symbols, entries use only premise names.

A number that is not a decimal is given as a ball, ``{"value": c, "within": r}``.  It is a parameter
that ``equals`` an expression without variables, or the rest of a state or input, with or without
such an expression.  In the graph it is a variable with the range [c - r, c + r]; the variable for
the rest of x is called ``x_rest``, and premises may use it.  ``balls`` proves that the number lies
in its ball.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose
from takagi.certificates.checker.kernel.reader import Number, member, number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.evaluate import Evaluator
from takagi.certificates.checker.plant.expression import NAME, Scope, read_expression
from takagi.certificates.checker.plant.graph import FUNCTIONS, Graph
from takagi.certificates.checker.plant.table import Table, read_table

MOST_VARIABLES, MOST_PREMISES, MOST_NUMBERS = 64, 12, 6
LARGEST_SIDE = 10**60
LETTERS = {"A": ("n", "n"), "B": ("n", "m"), "C": ("p", "n"), "D": ("p", "m"), "E": ("n", "q")}
Rows = list[list[int]]


@dataclass(frozen=True)
class Variable:
    """A state, input or disturbance; ``side`` is the range of its deviation, None if unknown.

    ``ball`` is the ball of its rest, None for a decimal.  It is stored here because a parameter may
    be called ``x_rest`` too: a name does not tell what a ball belongs to.  ``unknown`` : a signal
    that no law knows, such as an uncertain parameter.
    """

    name: str
    symbol: str
    unit: str
    rest: int
    side: tuple[Fraction, Fraction] | None
    ball: Ball | None = None
    unknown: bool = False

    @property
    def label(self) -> str:
        return f"{self.symbol} [{self.unit}]"


@dataclass(frozen=True)
class Ball:
    """The ball of a number that is not a decimal; ``equals`` is None for a rest solved for."""

    name: str
    middle: Fraction
    radius: Fraction
    equals: int | None

    @property
    def side(self) -> tuple[Fraction, Fraction]:
        return self.middle - self.radius, self.middle + self.radius


@dataclass(frozen=True)
class Premise:
    """A premise variable: its expression and its claimed bounds."""

    name: str
    node: int
    lower: Fraction
    upper: Fraction


@dataclass
class PlantNodes:
    """All data of a certificate about its plant, as nodes of one graph.

    ``scope``, ``premise_scope`` : the names that equations may use, and premises.
    """

    graph: Graph
    tables: dict[str, Table]
    states: list[Variable]
    inputs: list[Variable]
    disturbances: list[Variable]
    sample_time: Fraction | None
    _: KW_ONLY
    f: list[int] = field(default_factory=list)
    mass: Rows | None = None
    outputs: list[int] = field(default_factory=list)
    premises: list[Premise] = field(default_factory=list)
    numbers: list[Premise] = field(default_factory=list)
    entries: dict[str, Rows] = field(default_factory=dict)
    form: str = "sector"
    balls: dict[str, Ball] = field(default_factory=dict)
    scope: Scope = field(default_factory=lambda: Scope({}))
    premise_scope: Scope = field(default_factory=lambda: Scope({}))

    @property
    def variables(self) -> list[Variable]:
        """States, inputs and disturbances."""
        return [*self.states, *self.inputs, *self.disturbances]

    def at_rest(self, node: int) -> int:
        """Return a node where all deviations are 0."""
        origin = {v.symbol: self.graph.constant(0) for v in self.variables}
        return substituted(self.graph, node, origin)

    def value_of(self, variable: Variable) -> int:
        """Return the node of a variable, its rest and its deviation."""
        return self.graph.add(variable.rest, self.graph.variable(variable.symbol))

    def times_mass(self, rates: list[int]) -> list[int]:
        """Return M times a column of nodes; the column where there is no mass matrix."""
        if self.mass is None:
            return rates
        g = self.graph
        return [
            g.total(g.multiply(m, rate) for m, rate in zip(row, rates, strict=True))
            for row in self.mass
        ]

    @property
    def evaluator(self) -> Evaluator:
        return Evaluator(self.graph, self.tables, self.sides)

    @property
    def sides(self) -> dict[str, tuple[Fraction, Fraction]]:
        """Range of the deviation of each variable that has one, and of each ball."""
        ranges = {v.symbol: v.side for v in self.variables if v.side is not None}
        return ranges | {name: ball.side for name, ball in self.balls.items()}

    @property
    def box(self) -> dict[str, Interval]:
        """The ranges of ``sides``, rounded outward to the grid of the intervals."""
        return {name: enclose(*side) for name, side in self.sides.items()}


def read_plant(model: Any, where: str) -> PlantNodes:
    """Return the plant of a certificate's ``model`` of kind ``plant``.

    Raises
    ------
    CertificateError : a part is missing, too large or has a wrong form, a name is used twice, or a
        text is not an expression; the message has the place in the file.
    """
    return _Reading(model, where).whole()


def constant_bracket(written: object, where: str = "constant") -> tuple[Fraction, Fraction]:
    """Return a bracket of a text without variables, such as ``"sqrt(2)/3"``."""
    graph = Graph()
    node = read_expression(written, graph, Scope({}), where)
    bracket = Evaluator(graph, {}).value(node, {})
    if bracket is None:
        raise CertificateError(f"{where}: {written!a} has no value")
    return Fraction(bracket[0], ONE), Fraction(bracket[1], ONE)


def constant_node(value: Any, graph: Graph, where: str) -> int:
    """Return the node of a number, or of a text without variables."""
    if isinstance(value, Number):
        return graph.constant(Fraction(value))
    return read_expression(value, graph, Scope({}), where)


def rational(value: Any, graph: Graph, where: str) -> Fraction:
    """Return a number, or the value of a text such as ``"250/9"``."""
    exact_value = graph.value(constant_node(value, graph, where))
    if exact_value is None:
        raise CertificateError(f"{where}: a rational number is needed")
    return exact_value


class _Reading:
    def __init__(self, model: Any, where: str) -> None:
        self.model, self.where = model, where
        self.graph = Graph()
        self.names: dict[str, int] = {}
        self.symbols: dict[str, int] = {}
        self.taken: set[str] = set(FUNCTIONS) | {"pi"}
        self.balls: dict[str, Ball] = {}

    def whole(self) -> PlantNodes:
        for name, value in self.object("parameters").items():
            where = f"{self.where}.parameters.{name[:60]!a}"
            if isinstance(value, dict):
                self.add(name, self.ball(name, value, where), self.names, "parameters")
                if self.balls[name].equals is None:
                    raise CertificateError(f"{where}.equals: an expression is needed")
                continue
            exact = rational(value, self.graph, where)
            self.add(name, self.graph.constant(exact), self.names, "parameters")
        tables = self.tables()
        states, inputs, disturbances = (
            self.variables(key) for key in ("states", "inputs", "disturbances")
        )
        if not states or len(states) + len(inputs) + len(disturbances) > MOST_VARIABLES:
            raise CertificateError(f"{self.where}: 1 to {MOST_VARIABLES} variables are needed")
        plant = PlantNodes(self.graph, tables, states, inputs, disturbances, self.sample_time())
        plant.balls = self.balls
        if plant.balls and "blending" in self.model:
            raise CertificateError(f"{self.where}: a blend has decimals at rest and as parameters")
        scope = Scope(self.names, {name: table.arguments for name, table in tables.items()})
        plant.scope = scope
        plant.f = self.row("equations", member(self.model, "equations", self.where), scope)
        if len(plant.f) != len(states):
            raise CertificateError(f"{self.where}.equations: one for each state is needed")
        if self.model.get("mass") is not None:
            plant.mass = self.rows("mass", self.model["mass"], scope, (len(states), len(states)))
        outputs = self.model.get("outputs", [])
        plant.outputs = self.row("outputs", outputs, scope, "expression")
        self.embedding(plant)
        return plant

    def object(self, key: str) -> dict[str, Any]:
        entries = self.model.get(key, {})
        if not isinstance(entries, dict):
            raise CertificateError(f"{self.where}.{key}: an object is needed")
        return entries

    def take(self, name: str, key: str) -> None:
        """Refuse an invalid name, and a name that is already in use."""
        if name in self.taken or not NAME.fullmatch(name):
            raise CertificateError(f"{self.where}.{key}: {name[:60]!a} is no new name")
        self.taken.add(name)

    def add(self, name: str, node: int, names: dict[str, int], key: str) -> None:
        self.take(name, key)
        names[name] = node

    def ball(self, name: str, stated: dict[str, Any], where: str) -> int:
        """Return the variable of a number that is not a decimal, and store its ball."""
        middle, radius = (
            rational(member(stated, key, where), self.graph, f"{where}.{key}")
            for key in ("value", "within")
        )
        if not 0 < radius < abs(middle) or abs(middle) > LARGEST_SIDE:
            raise CertificateError(f"{where}.within: a radius is needed that leaves 0 outside")
        equals = stated.get("equals")
        if equals is not None:
            equals = read_expression(equals, self.graph, Scope({}), f"{where}.equals")
        self.balls[name] = Ball(name, middle, radius, equals)
        return self.graph.variable(name)

    def tables(self) -> dict[str, Table]:
        stated = self.object("tables")
        for name in stated:
            self.take(name, "tables")
        return {name: read_table(stated, name, f"{self.where}.tables") for name in stated}

    def sample_time(self) -> Fraction | None:
        if member(self.model, "sample_time", self.where) is None:
            return None
        seconds = number(self.model, "sample_time", self.where)
        if seconds <= 0:
            raise CertificateError(f"{self.where}.sample_time: a positive number is needed")
        return seconds

    def variables(self, key: str) -> list[Variable]:
        listed = self.model.get(key, [])
        if not isinstance(listed, list):
            raise CertificateError(f"{self.where}.{key}: a row of variables is needed")
        return [self.variable(v, key, f"{self.where}.{key}[{k}]") for k, v in enumerate(listed)]

    def variable(self, stated: Any, key: str, where: str) -> Variable:
        name = text(stated, "name", where)
        rest, rest_range, ball = self.rest(
            name, member(stated, "rest", where), key, f"{where}.rest"
        )
        resting = self.graph.value(rest)
        symbol = name if resting == 0 else text(stated, "symbol", where)
        if resting != 0 and symbol == name:
            raise CertificateError(f"{where}.symbol: the deviation needs a name of its own")
        node = self.graph.variable(symbol)
        self.add(name, self.graph.add(rest, node), self.names, key)
        if symbol != name:
            self.add(symbol, node, self.symbols, key)
        side = None
        if stated.get("range") is not None:
            ends = stated["range"]
            if not isinstance(ends, list) or len(ends) != 2:
                raise CertificateError(f"{where}.range: two numbers are needed")
            low, high = [rational(end, self.graph, f"{where}.range") for end in ends]
            if rest_range is None:
                raise CertificateError(f"{where}.range: its rest must be a rational number")
            if (
                not low <= rest_range[0] <= rest_range[1] <= high
                or low == high
                or max(-low, high) > LARGEST_SIDE
            ):
                raise CertificateError(f"{where}.range: it must increase and contain the rest")
            # With these deviations the variable keeps its range for every rest in the ball.
            side = (low - rest_range[0], high - rest_range[1])
        unknown = stated.get("unknown", False)
        if unknown not in (True, False) or (unknown and (key != "disturbances" or side is None)):
            raise CertificateError(f"{where}.unknown: true for a signal with a range, or left out")
        unit = text(stated, "unit", where)
        return Variable(name, symbol, unit, rest, side, ball, unknown is True)

    def rest(
        self, name: str, value: Any, key: str, where: str
    ) -> tuple[int, tuple[Fraction, Fraction] | None, Ball | None]:
        """Return the node of a rest, the interval that contains it (or None), and its ball."""
        if not isinstance(value, dict):
            node = constant_node(value, self.graph, where)
            exact = self.graph.value(node)
            return node, None if exact is None else (exact, exact), None
        if key == "disturbances":
            raise CertificateError(f"{where}: a number is needed")
        rest_symbol = f"{name[:60]}_rest"
        self.add(rest_symbol, self.ball(rest_symbol, value, where), self.symbols, key)
        return self.symbols[rest_symbol], self.balls[rest_symbol].side, self.balls[rest_symbol]

    def row(self, key: str, listed: Any, scope: Scope, inner: str = "") -> list[int]:
        if not isinstance(listed, list) or len(listed) > MOST_VARIABLES:
            raise CertificateError(f"{self.where}.{key}: a row of expressions is needed")
        nodes = []
        for k, written in enumerate(listed):
            where = f"{self.where}.{key}[{k}]"
            expression = member(written, inner, where) if inner else written
            nodes.append(read_expression(expression, self.graph, scope, where))
        return nodes

    def rows(self, key: str, listed: Any, scope: Scope, shape: tuple[int, int]) -> Rows:
        if not isinstance(listed, list) or len(listed) != shape[0]:
            raise CertificateError(f"{self.where}.{key}: {shape[0]} rows are needed")
        rows = [self.row(f"{key}[{k}]", row, scope) for k, row in enumerate(listed)]
        if any(len(row) != shape[1] for row in rows):
            raise CertificateError(f"{self.where}.{key}: rows of {shape[1]} are needed")
        return rows

    def embedding(self, plant: PlantNodes) -> None:
        stated, where = member(self.model, "embedding", self.where), f"{self.where}.embedding"
        scope = plant.premise_scope = Scope({**self.names, **self.symbols}, plant.scope.tables)
        listed = member(stated, "premises", where)
        plant.form = text(stated, "form", where) if "form" in stated else "sector"
        plant.premises = self.premises(listed, f"{where}.premises", scope, MOST_PREMISES)
        listed_numbers = stated.get("numbers", [])
        plant.numbers = self.premises(listed_numbers, f"{where}.numbers", scope, MOST_NUMBERS)
        if plant.numbers and plant.form != "sector":
            raise CertificateError(f"{where}.numbers: only of the form 'sector'")
        for constant in plant.numbers:
            # One value, though it is not known exactly: nothing that moves may stand in it.
            if not self.graph.variables(constant.node) <= self.balls.keys():
                raise CertificateError(f"{where}.numbers: {constant.name} depends on a variable")
        names: dict[str, int] = {}
        for p in (*plant.premises, *plant.numbers):
            self.add(p.name, self.graph.variable(p.name), self.symbols, "embedding.premises")
            names[p.name] = self.graph.variable(p.name)
        sizes = {"n": len(plant.states), "m": len(plant.inputs)}
        sizes |= {"p": len(plant.outputs), "q": len(plant.disturbances)}
        for letter, (rows, columns) in LETTERS.items():
            shape = sizes[rows], sizes[columns]
            if 0 not in shape:
                entries = member(stated, letter, where)
                plant.entries[letter] = self.rows(
                    f"embedding.{letter}", entries, Scope(names), shape
                )

    def premises(self, listed: Any, where: str, scope: Scope, largest_count: int) -> list[Premise]:
        """Return expressions with their names and stated bounds."""
        if not isinstance(listed, list) or len(listed) > largest_count:
            raise CertificateError(f"{where}: a row of up to {largest_count} is needed")
        premises = []
        for k, premise in enumerate(listed):
            premise_place = f"{where}[{k}]"
            written = member(premise, "expression", premise_place)
            node = read_expression(written, self.graph, scope, f"{premise_place}.expression")
            low, high = (
                rational(member(premise, end, premise_place), self.graph, f"{premise_place}.{end}")
                for end in ("lower", "upper")
            )
            if low > high:
                raise CertificateError(f"{premise_place}: its lower bound exceeds its upper one")
            premises.append(Premise(text(premise, "name", premise_place), node, low, high))
        return premises
