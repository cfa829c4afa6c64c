r"""Ties the plant of a certificate to the plant file it is said to come from.

A hash shows that a file is the one that was recorded; it does not show that the certificate's
equations are the file's.  Here the TOML file is read again, and compared with the certificate:

    parameters, ranges, rest values, sample time    in SI, exactly; expressions by exact algebra
    equations, mass matrix, outputs                 as functions, by exact algebra, and defined on
                                                    the box in every part that the file writes
    names of states, inputs, disturbances           in their order

A rest that the file leaves to be solved may be any rest that the certificate proves.
The certificate may have other equilibrium inputs if they hold the states at equilibrium. The claim
``sector-embedding`` proves that every row vanishes there. Tables have the points of their files as
knots, and nearly interpolate the values (``table_file``).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from takagi.certificates.checker.files.differences import in_words
from takagi.certificates.checker.files.model_content import OtherModel, inside_folder, read_toml
from takagi.certificates.checker.files.plant_parts import (
    FileBlend,
    FileReferences,
    compare_measured,
    integrators_in,
    other_plant,
    uncertain_in,
)
from takagi.certificates.checker.files.table_file import TABLE_TOLERANCE, compare_table, in_si
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.expression import NAME, Scope, read_expression
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, Variable, read_plant

MOST_EXPONENT = 100  # of ten, in a figure
NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*", re.ASCII)
# A time with its unit, such as "10 ms".
TIMED = re.compile(r"\s*([0-9]{0,9}\.?[0-9]{1,9}(?:[eE][-+]?[0-9]{1,2})?)\s*(.*?)\s*", re.ASCII)
MOST_ABOVE = 50  # parameters that depend on one another in a row


def compare_plant(model: Any, path: Path, gains: Any = None, *, narrower: bool = False) -> str:
    """Compare the plant of a certificate with its file; return messages for the reader.

    Parameters
    ----------
    gains : the certificate's; what its law measures is compared too, where there is a law.
    narrower : whether states may have narrower ranges in the certificate than in the file, because
        all of its claims say that they stay in these.

    Raises
    ------
    CertificateError : the file cannot be read.
    OtherModel : its content differs from the certificate.
    """
    file, plant = read_toml(path, Decimal, what="plant file"), read_plant(model, "model")
    if file.get("kind") != "plant":
        raise OtherModel(f"{path}: the certificate is about a plant, this is no plant file")
    integrators = integrators_in(file, model, gains, path)
    words = Comparison(model, plant, file, path, integrators, narrower=narrower).whole()
    compare_measured(gains, file, path, plant)
    return words


class Comparison:
    def __init__(
        self,
        model: Any,
        plant: PlantNodes,
        file: dict[str, Any],
        path: Path,
        integrators: Mapping[str, str],
        *,
        narrower: bool,
    ) -> None:
        self.may_be_narrower, self.narrower = narrower, list[str]()
        self.model, self.plant, self.file, self.path = model, plant, file, path
        self.algebra = Algebra(plant.graph, plant.tables)
        self.ranges = Ranges(plant.evaluator, self.algebra, plant.box, signs=plant.form == "sector")
        self.names: dict[str, int] = {}
        self.derived: dict[str, int] = {}
        self.unsolved: list[str] = []
        self.uncertain: dict[str, dict[str, Any]] = {}
        self.blend = FileBlend.of(file, model, path)
        self.integrators = integrators

    def whole(self) -> str:
        self.sample_time()
        self.parameters()
        scheduling = {n: _resting_inside(entry) for n, entry in self.section("scheduling").items()}
        outside = {**self.section("disturbances"), **scheduling}
        outside |= self.blend.errors | self.uncertain
        references = FileReferences.of(self.file, self.model, self.path)
        states = {**self.section("states"), **self.blend.states, **references.integrals}
        states |= {name: {} for name in self.integrators}
        outside |= references.signals(self.section("states"), self.section("outputs"), self.plant)
        resting_elsewhere = self.variables("states", states, self.plant.states)
        signals = self.blend.without_share(self.plant.disturbances)
        resting_elsewhere += self.variables("disturbances", outside, signals)
        self.same_names(
            self.uncertain, [v.name for v in signals if v.unknown], "uncertain parameters"
        )
        if resting_elsewhere:
            raise self.error(f"{', '.join(resting_elsewhere)} rests elsewhere there")
        inputs = self.blend.without_actuators(self.section("inputs"))
        inputs |= {rate: {} for rate in self.integrators.values()}
        solved = self.variables("inputs", inputs, self.plant.inputs)
        tables = self.section("tables")
        missing = sorted(set(self.plant.tables) - set(tables))
        if missing:
            raise self.error(f"the table {', '.join(missing)} is not there")
        self.compare_tables(tables)
        count = {name: len(_list(t, "arguments")) for name, t in tables.items()}
        self.expressions(count, references)
        words = []
        if solved and self.may_be_narrower:
            names = ", ".join(solved)
            words.append(f"{names} rests elsewhere in the file; no rest is claimed there")
        elif solved:
            words.append(f"{', '.join(solved)} rests where it holds the states, not as in the file")
        if self.narrower:
            ranges = ", ".join(self.narrower)
            words.append(f"states are proved to stay in narrower ranges than the file's: {ranges}")
        if self.unsolved and not self.may_be_narrower:
            names = ", ".join(self.unsolved)
            words.append(
                f"the file leaves the rest of {names} to be solved; any proved rest passes"
            )
        if self.ranges.removable:
            zeros = ", ".join(sorted(self.ranges.removable))
            words.append(f"where {zeros} = 0 a quotient there means its limit")
        if tables:
            words.append(
                f"tables pass their files' values to {float(TABLE_TOLERANCE):.0e} of their range"
            )
        return f"{self.path}: {'; '.join(words)}" if words else ""

    def compare_tables(self, entries: Mapping[str, Any]) -> None:
        for name, table in self.plant.tables.items():
            where = f"tables.{name}"
            file = inside_folder(self.path, _get(entries[name], "file"))
            quantities = [*_list(entries[name], "arguments"), entries[name]]
            try:
                compare_table(file, table, [str(_get(d, "unit", "-")) for d in quantities])
            except Refused as error:
                raise self.error(f"{where}: {error}") from error

    def error(self, problem: str) -> OtherModel:
        return other_plant(self.path, problem)

    def section(self, name: str) -> dict[str, Any]:
        entries = self.file.get(name, {})
        if not isinstance(entries, dict):
            raise self.error(f"[{name}] is no section there")
        return self.measured(entries) if name == "outputs" else entries

    def same_names(self, theirs: Iterable[str], ours: Iterable[str], subject: str) -> None:
        """Refuse names that differ; their order in a file has no meaning."""
        there, here = (sorted(map(str, names)) for names in (theirs, ours))
        if there != here:
            lists = (", ".join(map(ascii, names)) or "none" for names in (there, here))
            raise self.error(f"{subject} are {next(lists)} there, {next(lists)} in the certificate")

    def figure(self, value: Any, unit: Any, where: str) -> Fraction:
        if isinstance(value, Fraction):  # the middle of a range
            return in_si(value, unit if isinstance(unit, str) else "")
        if isinstance(value, bool) or not isinstance(value, int | Decimal):
            raise self.error(f"{where} is no number there")
        number = Decimal(value)
        if not number.is_finite() or abs(number.adjusted()) > MOST_EXPONENT:
            raise self.error(f"{where} is not finite there, or too large")
        try:
            return in_si(Fraction(number), unit if isinstance(unit, str) else "")
        except Refused as error:
            raise self.error(f"{where}: {error}") from error

    def sample_time(self) -> None:
        written, unit = self.file.get("sample_time"), "s"
        if isinstance(written, str) and (timed := TIMED.fullmatch(written)):
            written, unit = Decimal(timed[1]), timed[2] or "s"
        seconds = None if written is None else self.figure(written, unit, "sample_time")
        if seconds != self.plant.sample_time:
            figures = (
                "nothing" if t is None else f"{float(t):.12g}"
                for t in (seconds, self.plant.sample_time)
            )
            raise self.error(
                f"sample_time is {next(figures)} there, {next(figures)} in the certificate"
            )

    def parameters(self) -> None:
        theirs = self.section("parameters")
        self.uncertain = uncertain_in(theirs)
        signals = {v.name: v for v in self.plant.disturbances if v.unknown}
        graph = self.plant.graph
        for name in self.uncertain:
            if name not in signals:
                raise self.error(f"parameters.{name} has a range there, not in the certificate")
            symbol = graph.variable(signals[name].symbol)
            self.derived[name] = graph.add(signals[name].rest, symbol)
        moving = self.moving(theirs)
        # Parameters added by the blend are in the model's equations, which a claim covers.
        ours = self.blend.without_parameters(self.model.get("parameters", {}))
        certain = [name for name in theirs if name not in self.uncertain and name not in moving]
        self.same_names(certain, ours, "parameters")
        self.names |= {name: self.derived[name] for name in moving}
        for name in certain:
            where, ball = f"parameters.{name}", self.plant.balls.get(name)
            node = self.parameter(name, theirs, ())
            equals = None if ball is None else ball.equals
            if equals is None:
                equals = self.constant(ours[name], f"model.{where}")
            if not self.algebra.equal(node, equals):
                value = self.plant.graph.value(node)
                stated = in_words(ours[name] if ball is None else ours[name]["equals"])
                figure = "another expression" if value is None else f"{float(value):.12g}"
                raise self.error(f"{where} is {figure} there, {stated} in the certificate")
            self.names[name] = node if ball is None else self.plant.graph.variable(name)

    def moving(self, theirs: Mapping[str, Any]) -> list[str]:
        """Return the parameters of the file that depend on an uncertain one."""
        if not self.uncertain:
            return []
        graph = self.plant.graph
        varying = [name for name in theirs if graph.variables(self.parameter(name, theirs, ()))]
        return [name for name in varying if name not in self.uncertain]

    def parameter(self, name: str, theirs: Mapping[str, Any], above: tuple[str, ...]) -> int:
        """Return the node of a parameter of the file: a figure, or an expression of others."""
        where = f"parameters.{name}"
        if name in above or len(above) > MOST_ABOVE:
            raise self.error(f"{where} depends on itself there, or on too many others")
        if name not in self.derived:
            entry = theirs[name]
            written = _get(entry, "value") if isinstance(entry, dict) else entry
            if isinstance(written, str) and not NUMBER.fullmatch(written):
                for named in sorted(set(NAME.findall(written)) & set(theirs)):
                    self.parameter(named, theirs, (*above, name))
                scope = Scope(dict(self.derived))
                node = read_expression(written, self.plant.graph, scope, f"{self.path}: {where}")
            else:
                value = self.figure(written, _get(entry, "unit", "-"), where)
                node = self.plant.graph.constant(value)
            self.derived[name] = node
        return self.derived[name]

    def rests_elsewhere(self, variable: Variable, key: str, written: Any, unit: Any) -> bool:
        """Return whether the file has another rest; a rest to be solved for has no value there."""
        where = f"{key}.{variable.name}.rest"
        if key != "disturbances" and (written == "solve" or isinstance(written, dict)):
            self.unsolved.append(variable.name)
            return False
        ball = variable.ball
        certified_rest = variable.rest if ball is None or ball.equals is None else ball.equals
        if isinstance(written, str) and not NUMBER.fullmatch(written):
            scope = Scope(dict(self.derived))
            node = read_expression(written, self.plant.graph, scope, f"{self.path}: {where}")
            return not self.algebra.equal(node, certified_rest)
        return self.plant.graph.value(certified_rest) != self.figure(written, unit, where)

    def constant(self, written: Any, where: str) -> int:
        """Return the node of a number or constant text of the certificate."""
        text = str(written)
        return read_expression(text, self.plant.graph, Scope({}), where)

    def variables(self, key: str, theirs: Mapping[str, Any], ours: list[Variable]) -> list[str]:
        """Compare names and ranges; return the names of those with other equilibrium values."""
        self.same_names(theirs, [v.name for v in ours], key)
        resting_elsewhere = []
        graph = self.plant.graph
        for variable in ours:
            entry, where = theirs[variable.name], f"{key}.{variable.name}"
            unit = _get(entry, "unit", "-")
            # A reference rests where what follows it does, and the embedding proves that.
            if _get(entry, "si rest") is None and self.rests_elsewhere(
                variable, key, _get(entry, "rest", 0), unit
            ):
                resting_elsewhere.append(variable.name)
            exact, ball = graph.value(variable.rest), variable.ball
            rest_range = None if exact is None else (exact, exact)
            rest_range = rest_range if ball is None else ball.side
            node = graph.variable(variable.symbol)
            self.names[variable.name] = graph.add(variable.rest, node)
            ends = _get(entry, "range", None)
            side = None
            if ends is not None:
                if not isinstance(ends, list) or len(ends) != 2 or rest_range is None:
                    raise self.error(f"{where}.range cannot be compared")
                low, high = (self.figure(end, unit, f"{where}.range") for end in ends)
                side = (low - rest_range[0], high - rest_range[1])
            inside = side is not None and variable.side is not None and (
                side[0] <= variable.side[0] and variable.side[1] <= side[1]
            )  # fmt: skip
            if side != variable.side and self.may_be_narrower and key == "states" and inside:
                self.narrower.append(f"{variable.name} in {_range(variable.side, rest_range)}")
            elif side != variable.side:
                raise self.error(
                    f"{where}.range is {_range(side, rest_range)} there, "
                    f"{_range(variable.side, rest_range)} in the certificate"
                )
        return resting_elsewhere

    def expressions(self, tables: Mapping[str, int], references: FileReferences) -> None:
        states = [variable.name for variable in self.plant.states]
        compared_states, f = self.blend.equations(states, self.plant, self.names)
        scope = Scope(self.names, tables)
        equations = {**self.section("equations"), **references.equations(self.section("outputs"))}
        equations |= self.integrators
        self.same_names(equations, compared_states, "equations")
        for name, node in zip(compared_states, f, strict=True):
            self.equal(equations[name], node, scope, f"equations.{name}")
        self.blend.compare(self, scope)
        mass = self.section("mass")
        if bool(mass) != (self.plant.mass is not None):
            raise self.error("the one has a mass matrix, the other none")
        unit_node, nothing = self.plant.graph.constant(1), self.plant.graph.constant(0)
        for i, row in enumerate(self.plant.mass or []):
            mass_row = mass.get(states[i])
            if mass_row is not None and not isinstance(mass_row, dict):
                raise self.error(f"mass.{states[i]} is no row of entries there")
            for j, node in enumerate(row):
                if mass_row is None or states[j] not in mass_row:
                    # A row that is not given is a row of the identity matrix.
                    identity_entry = unit_node if mass_row is None and i == j else nothing
                    if not self.algebra.equal(node, identity_entry):
                        raise self.error(f"mass.{states[i]}.{states[j]} is another there")
                    continue
                self.equal(mass_row[states[j]], node, scope, f"mass.{states[i]}.{states[j]}")
        outputs = self.section("outputs")
        ours = [_get(y, "name") for y in _list(self.model, "outputs")]
        self.same_names(outputs, ours, "outputs")
        for name, node in zip(map(str, ours), self.plant.outputs, strict=True):
            self.equal(_get(outputs[name], "expression"), node, scope, f"outputs.{name}")

    def measured(self, outputs: dict[str, Any]) -> dict[str, Any]:
        """Return the outputs of the file, with those that ``measured`` adds.

        A name alone is that of an output, or of a state; a table has an expression of its own.
        """
        outputs_by_name = dict(outputs)
        for entry in _list(self.file, "measured"):
            name = entry if isinstance(entry, str) else str(_get(entry, "name"))
            written = _get(entry, "expression")
            if written is not None and name in outputs_by_name:
                raise self.error(f"measured has {name} twice there")
            if name not in outputs_by_name:
                outputs_by_name[name] = {"expression": name if written is None else written}
        return outputs_by_name

    def equal(self, written: Any, node: int, scope: Scope, where: str) -> None:
        theirs = read_expression(written, self.plant.graph, scope, f"{self.path}: {where}")
        try:
            same = theirs == node or self.algebra.equal(theirs, node)
        except Refused as error:
            raise self.error(f"{where} cannot be compared: {error}") from error
        if not same:
            raise self.error(
                f"{where} is {in_words(written)} there, which is not shown to be the certificate's"
            )
        if theirs != node:
            # Algebra does not cover points where a part of either expression is undefined.
            graph = self.plant.graph
            table_names = {graph[n].name for n in graph.below([theirs]) if graph[n].op == "table"}
            if missing := sorted(table_names - set(self.plant.tables)):
                raise self.error(f"{where} has the table {', '.join(missing)} there, which cancels")
            try:
                self.ranges.prove_continuous(theirs, where)
            except Refused as error:
                raise self.error(f"{error}, as the file writes it") from error


def _range(
    side: tuple[Fraction, Fraction] | None, rest_ends: tuple[Fraction, Fraction] | None
) -> str:
    if side is None or rest_ends is None:
        return "nothing"
    ends = zip(rest_ends, side, strict=True)
    return f"[{', '.join(f'{float(rest_value + end):.12g}' for rest_value, end in ends)}]"


def _get(entry: Any, key: str, otherwise: Any = None) -> Any:
    return entry.get(key, otherwise) if isinstance(entry, dict) else otherwise


def _list(entry: Any, key: str) -> list[Any]:
    entries = _get(entry, key, [])
    return entries if isinstance(entries, list) else []


def _resting_inside(entry: Any) -> Any:
    """Return a scheduling signal with its rest; by default the middle of a range without 0."""
    ends = _get(entry, "range", None)
    if _get(entry, "rest", None) is not None or not isinstance(ends, list) or len(ends) != 2:
        return entry
    decimals = [Decimal(str(end)) for end in ends if isinstance(end, (int, float, Decimal))]
    if len(decimals) < 2 or decimals[0] <= 0 <= decimals[1]:
        return entry
    return {**entry, "rest": Fraction(sum(decimals)) / 2}
