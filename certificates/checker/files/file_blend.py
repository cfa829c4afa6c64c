"""The section ``[blending]`` of a plant file against the blend of a certificate.

The file has the plant with its two actuators. The certificate has the blended plant: one more state
(the effort), its rate as the input in place of the actuators, and signals. Here the written
descriptions are compared. The claim ``effort-blend`` proves that they give the equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

from takagi.certificates.checker.files.differences import in_words
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.reading import PlantNodes, Variable

ADDED = ("_idle", "_effort_rest", "_rest")


class Comparison(Protocol):
    """The methods of the plant's comparison that the comparison of its blend uses."""

    plant: PlantNodes

    def figure(self, value: Any, unit: Any, where: str) -> Fraction: ...

    def constant(self, written: Any, where: str) -> int: ...

    def equal(self, written: Any, node: int, scope: Scope, where: str) -> None: ...


@dataclass(frozen=True)
class FileBlend:
    """Both descriptions of a blend: the sections of ``file`` and ``model``, {} if there is none."""

    file: Mapping[str, Any]
    model: Mapping[str, Any]
    inputs: Mapping[str, Any]
    path: Path

    @classmethod
    def of(cls, file: Mapping[str, Any], model: Any, path: Path) -> FileBlend:
        """Return the pair.

        Raises
        ------
        OtherModel : only one of them has a blend, or a section is malformed.
        """
        found = cls(
            _object(file.get("blending", {})),
            _object(model.get("blending", {})),
            _object(file.get("inputs", {})),
            path,
        )
        if bool(file.get("blending")) != bool(model.get("blending")):
            raise found.error("the one has a blend, the other none")
        for key in ("effort", "low", "high") if file.get("blending") else ():
            if not isinstance(found.file.get(key), dict):
                raise found.error(f"blending.{key} is missing")
            if key == "effort":
                continue
            if not isinstance(found.model.get(key), dict):
                raise found.error(f"the certificate has no blending.{key}")
            name = found.file[key].get("input")
            if not isinstance(name, str) or not isinstance(found.inputs.get(name), dict):
                raise found.error(f"blending.{key}.input is no input there")
        return found

    def error(self, problem: str) -> OtherModel:
        return OtherModel(f"{self.path}: not the certificate's plant: {problem}")

    @property
    def actuators(self) -> list[str]:
        return [str(self.file[key]["input"]) for key in ("low", "high")] if self.file else []

    @property
    def states(self) -> dict[str, Any]:
        """The state that the blend adds, in the format of the file."""
        if not self.file:
            return {}
        effort = self.file["effort"]
        kept = {key: effort[key] for key in ("unit", "range", "rest") if key in effort}
        return {str(self.model.get("effort")): kept}

    @property
    def errors(self) -> dict[str, Any]:
        """The signals that the actuator errors add, in the format of the file."""
        found: dict[str, Any] = {}
        for key in ("low", "high") if self.file else ():
            error = self._number(self.file[key].get("error", 0), f"blending.{key}.error")
            name = self.model[key].get("error")
            if bool(error) != (name is not None):
                raise self.error(
                    f"blending.{key}.error is {error} there, and not so in the certificate"
                )
            if name is not None:
                found[str(name)] = {"range": [-error, error]}
        return found

    def _number(self, value: Any, where: str) -> Any:
        if isinstance(value, bool) or not isinstance(value, int | Decimal):
            raise self.error(f"{where} is no number there")
        return value

    def without_share(self, signals: list[Variable]) -> list[Variable]:
        """Return the certificate's signals without the share; a claim proves the share's range."""
        return [v for v in signals if not self.file or v.name != self.model.get("share")]

    def without_actuators(self, inputs: Mapping[str, Any]) -> dict[str, Any]:
        """Return the file's inputs with the effort's rate in the place of the actuators."""
        if not self.file:
            return dict(inputs)
        found = {name: entry for name, entry in inputs.items() if name not in self.actuators}
        effort = self.file["effort"]
        rate: dict[str, Any] = {"unit": _per_second(str(effort.get("unit", "-")))}
        if effort.get("rate") is not None:
            most = self._number(effort["rate"], "blending.effort.rate")
            rate["range"] = [-most, most]
        return {**found, str(self.model.get("rate")): rate}

    def without_parameters(self, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """Return the certificate's parameters without those that the blend adds."""
        added = {f"{name}{end}" for name in self.actuators for end in ADDED}
        added |= {"effort_rest"} if self.file else set()
        return {name: value for name, value in parameters.items() if name not in added}

    def equations(
        self, states: list[str], plant: PlantNodes, names: dict[str, int]
    ) -> tuple[list[str], list[int]]:
        """Return states and nodes to compare; with a blend, before the actuators are substituted.

        The actuators become variables with their own names.
        """
        if not self.file:
            return states, plant.f
        for name in self.actuators:
            if name in names:
                raise self.error(f"the actuator {name} has the name of something else")
            names[name] = plant.graph.variable(name)
        own = [name for name in states if name != self.model.get("effort")]
        written = self.model.get("equations")
        if not isinstance(written, list) or len(written) != len(own):
            raise self.error("the certificate's blend has no equations for its states")
        scope = Scope(names, {name: table.arguments for name, table in plant.tables.items()})
        return own, [
            read_expression(row, plant.graph, scope, f"model.blending.equations[{i}]")
            for i, row in enumerate(written)
        ]

    def compare(self, comparison: Comparison, scope: Scope) -> None:
        """Compare overlap, directions, effectiveness, idle values and limits.

        Raises
        ------
        OtherModel : one of them differs.
        """
        if not self.file:
            return
        effort = self.file["effort"]
        overlap = comparison.figure(effort.get("overlap"), effort.get("unit", "-"), "overlap")
        self._same(comparison, self.model.get("overlap"), overlap, "blending.effort.overlap")
        for key in ("low", "high"):
            theirs, ours, where = self.file[key], self.model[key], f"blending.{key}"
            for name in ("input", "direction"):
                if not _alike(theirs.get(name), ours.get(name)):
                    raise self.error(
                        f"{where}.{name} is {in_words(theirs.get(name))} there, "
                        f"{in_words(ours.get(name))} in the certificate"
                    )
            entry = self.inputs[theirs["input"]]
            unit = entry.get("unit", "-")
            idle = comparison.figure(entry.get("rest", 0), unit, f"inputs.{theirs['input']}")
            self._same(comparison, ours.get("idle"), idle, f"the rest of {theirs['input']}")
            self._compare_range(comparison, entry.get("range"), ours.get("range"), unit, where)
            node = read_expression(
                ours.get("effectiveness"), comparison.plant.graph, scope, f"model.{where}"
            )
            comparison.equal(theirs.get("effectiveness"), node, scope, f"{where}.effectiveness")

    def _compare_range(
        self, comparison: Comparison, theirs: Any, ours: Any, unit: str, where: str
    ) -> None:
        if (theirs is None) != (ours is None):
            raise self.error(f"{where}.input has a range in one of the two, and none in the other")
        if theirs is None:
            return
        if not (isinstance(theirs, list) and isinstance(ours, list) and len(theirs) == len(ours)):
            raise self.error(f"the range of {where}.input cannot be compared")
        for mine, end in zip(ours, theirs, strict=True):
            figure = comparison.figure(end, unit, f"range of {where}.input")
            self._same(comparison, mine, figure, f"the range of {where}.input")

    def _same(self, comparison: Comparison, ours: Any, figure: Fraction, what: str) -> None:
        node = comparison.constant(ours, what)
        if comparison.plant.graph.value(node) != figure:
            raise self.error(
                f"{what} is {float(figure):.12g} there, {in_words(ours)} in the certificate"
            )


def _object(given: Any) -> dict[str, Any]:
    return given if isinstance(given, dict) else {}


def _alike(theirs: Any, ours: Any) -> bool:
    """Return whether a value is the certificate's: numbers by value, 1.0 is 1."""
    if isinstance(theirs, int | Decimal) and isinstance(ours, Number):
        return not isinstance(theirs, bool) and Decimal(theirs) == Decimal(ours)
    return str(theirs) == str(ours)


def _per_second(unit: str) -> str:
    """Return a unit as the files write it, per second."""
    if unit == "-":
        return "1/s"
    top, slash, bottom = unit.partition("/")
    return f"{top}/({bottom.strip('()')} s)" if slash else f"{unit}/s"
