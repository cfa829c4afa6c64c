"""Parts of a plant's file that are compared one by one.

The file has the plant with its two actuators. The certificate has the blended plant: one more state
(the effort), its rate as the input in place of the actuators, and signals. Here the written
descriptions are compared. The claim ``effort-blend`` proves that they give the equations.

The field ``measured`` of a plant file against the law of a certificate.

The field lists the outputs that a law has instead of the states.  A certificate may be about a law
with other outputs, or with all states; then it is not about the law that the file asks for.

The field ``controller`` of a plant file against the states that a law has beside the plant's.

The section ``[reference]`` of a plant file against the references of a certificate.

The file states which state or output follows which signal.  In the certificate the signal is a
disturbance, the integral a state, and h(x) - r the equation of the integral.  Here they are written
in the form of the file, so that the comparison is the same as for all other entries.

The uncertain parameters of a plant file, in the form of the file's signals.

A parameter with a range, ``m = { range = [0.9, 1.1], unit = "kg" }`` or ``m = "[0.9, 1.1] kg"``, is
a signal of the certificate that no law knows.  Its rest is its value; without a value, the middle
of its range.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

from takagi.certificates.checker.files.differences import in_words
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.kernel.reader import Number, read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import FUNCTIONS
from takagi.certificates.checker.plant.integrators import integrators_of
from takagi.certificates.checker.plant.reading import PlantNodes, Variable

ADDED = ("_idle", "_effort_rest", "_rest")
# A name in a formula; not the exponent of a number such as 1e-3.
_IDENTIFIER = re.compile(r"(?<![A-Za-z0-9_.])[A-Za-z_][A-Za-z0-9_]*", re.ASCII)


class Comparison(Protocol):
    """The methods of the plant's comparison that the comparison of its blend uses."""

    plant: PlantNodes

    def figure(self, value: Any, unit: Any, where: str) -> Fraction: ...

    def constant(self, written: Any, where: str) -> int: ...

    def equal(self, written: Any, node: int, scope: Scope, where: str) -> None: ...


def other_plant(path: Path, problem: str) -> OtherModel:
    """Return the exception for a plant that is not the certificate's."""
    return OtherModel(f"{path}: not the certificate's plant: {problem}")


@dataclass(frozen=True)
class FileBlend:
    """Both descriptions of a blend: the sections of ``file`` and ``model``, {} if there is none."""

    file: Mapping[str, Any]
    model: Mapping[str, Any]
    inputs: Mapping[str, Any]
    path: Path

    @classmethod
    def of(cls, file: Mapping[str, Any], model: Any, path: Path) -> FileBlend:
        """Return the blend of the file and that of the certificate.

        Raises
        ------
        OtherModel : only one of them has a blend, or a section is malformed.
        """
        blend = cls(
            _object(file.get("blending", {})),
            _object(model.get("blending", {})),
            _object(file.get("inputs", {})),
            path,
        )
        if bool(file.get("blending")) != bool(model.get("blending")):
            raise blend.error("the one has a blend, the other none")
        for key in ("effort", "low", "high") if file.get("blending") else ():
            if not isinstance(blend.file.get(key), dict):
                raise blend.error(f"blending.{key} is missing")
            if key == "effort":
                continue
            if not isinstance(blend.model.get(key), dict):
                raise blend.error(f"the certificate has no blending.{key}")
            name = blend.file[key].get("input")
            if not isinstance(name, str) or not isinstance(blend.inputs.get(name), dict):
                raise blend.error(f"blending.{key}.input is no input there")
        return blend

    def error(self, problem: str) -> OtherModel:
        return other_plant(self.path, problem)

    @property
    def actuators(self) -> list[str]:
        return [str(self.file[key]["input"]) for key in ("low", "high")] if self.file else []

    @property
    def states(self) -> dict[str, Any]:
        """The state that the blend adds, in the format of the file."""
        if not self.file:
            return {}
        effort = self.file["effort"]
        variable = {key: effort[key] for key in ("unit", "range", "rest") if key in effort}
        return {str(self.model.get("effort")): variable}

    @property
    def errors(self) -> dict[str, Any]:
        """The signals that the actuator errors add, in the format of the file."""
        signals: dict[str, Any] = {}
        for key in ("low", "high") if self.file else ():
            error = self._number(self.file[key].get("error", 0), f"blending.{key}.error")
            name = self.model[key].get("error")
            if bool(error) != (name is not None):
                raise self.error(
                    f"blending.{key}.error is {error} there, and not so in the certificate"
                )
            if name is not None:
                signals[str(name)] = {"range": [-error, error]}
        return signals

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
        remaining = {name: entry for name, entry in inputs.items() if name not in self.actuators}
        effort = self.file["effort"]
        rate: dict[str, Any] = {"unit": _per_second(str(effort.get("unit", "-")))}
        if effort.get("rate") is not None:
            largest_rate = self._number(effort["rate"], "blending.effort.rate")
            rate["range"] = [-largest_rate, largest_rate]
        return {**remaining, str(self.model.get("rate")): rate}

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
        compared_states = [name for name in states if name != self.model.get("effort")]
        written = self.model.get("equations")
        if not isinstance(written, list) or len(written) != len(compared_states):
            raise self.error("the certificate's blend has no equations for its states")
        scope = Scope(names, {name: table.arguments for name, table in plant.tables.items()})
        return compared_states, [
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

    def _same(self, comparison: Comparison, ours: Any, figure: Fraction, field_path: str) -> None:
        node = comparison.constant(ours, field_path)
        if comparison.plant.graph.value(node) != figure:
            raise self.error(
                f"{field_path} is {float(figure):.12g} there, {in_words(ours)} in the certificate"
            )


def _object(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _alike(theirs: Any, ours: Any) -> bool:
    """Return whether a value equals the certificate's; numbers by value, so that 1.0 equals 1."""
    if isinstance(theirs, int | Decimal) and isinstance(ours, Number):
        return not isinstance(theirs, bool) and Decimal(theirs) == Decimal(ours)
    return str(theirs) == str(ours)


def _per_second(unit: str) -> str:
    """Return a unit as the files write it, per second."""
    if unit == "-":
        return "1/s"
    top, slash, bottom = unit.partition("/")
    return f"{top}/({bottom.strip('()')} s)" if slash else f"{unit}/s"


def compare_measured(gains: Any, file: dict[str, Any], path: Path, plant: PlantNodes) -> None:
    """Compare what the law measures with what the plant file lists; the order means nothing.

    Without gains there is no law, and nothing is compared.  A law of states alone measures what the
    file lists by the states' names if it uses no other state: its gains on the others are zero,
    none is in a premise where rules have gains of their own, none is in what a reference follows,
    and none in the effectiveness of an actuator behind a blend.

    Parameters
    ----------
    file : what the file at ``path`` says, numbers and texts as ``read_toml`` returns them.
    plant : the certificate's, whose states the law names.

    Raises
    ------
    OtherModel : the law measures other outputs; with names.
    """
    if not isinstance(gains, dict):
        return
    theirs = _names(file["measured"], "measured", path) if "measured" in file else None
    ours = None
    if "observer" in gains:
        observer = gains["observer"]
        measured = observer.get("measured") if isinstance(observer, dict) else None
        ours = _names(measured, "gains.observer.measured", path)
    if theirs == ours:
        return
    if theirs is not None and ours is None:
        every = set(_object(file.get("states")))
        used = _states_used(gains, plant)
        if (every if used is None else used & every) <= theirs - _other_outputs(file):
            return
    if ours is None:
        why = f"the law has all states, the field measured lists {_told(theirs)} alone"
    elif theirs is None:
        why = f"the law measures {_told(ours)}, without the field measured it has all states"
    elif unlisted := ours - theirs:
        why = f"the law measures {_told(unlisted)}, which the field measured does not list"
    else:
        why = f"the field measured lists {_told(theirs - ours)}, which the law does not measure"
    raise other_plant(path, why)


def _other_outputs(file: dict[str, Any]) -> set[str]:
    """Return the names whose output in the file has an expression other than this name."""
    measured = file.get("measured")
    entries = [(str(e.get("name")), e) for e in map(_object, _entries(measured)) if e]
    expressions = [*_object(file.get("outputs")).items(), *entries]
    return {
        name
        for name, entry in expressions
        if str(_object(entry).get("expression", name)).strip() != name
    }


def _states_used(gains: dict[str, Any], plant: PlantNodes) -> set[str] | None:
    """Return which states a law without observer uses; None, for all, where that is unclear.

    The integrals of references, and an effort, are states of the law itself.  A state that does not
    rest at 0 stands in the law as its deviation, under a name of the certificate.
    """
    try:
        K = read_stack(gains, "K", "gains")
    except CertificateError:
        return None
    if gains.get("state_names") != [state.label for state in plant.states]:
        return None
    columns = range(min(K[0].shape[1], len(plant.states)))
    used = {plant.states[j].name for j in columns if any(row[j] for M in K for row in M.rows)}
    formulas = [_object(r).get("follow") for r in _entries(gains.get("references"))]
    blending = gains.get("blending")
    if blending is not None:
        actuators = (_object(_object(blending).get(key)) for key in ("low", "high"))
        formulas += [actuator.get("effectiveness") for actuator in actuators]
    if any(M != K[0] for M in K):
        premises = _entries(gains.get("premises"))
        formulas += [_object(p).get("expression") for p in premises] or [None]
    state_of = {name: state.name for state in plant.states for name in (state.name, state.symbol)}
    known = {*plant.premise_scope.names, *plant.premise_scope.tables, *FUNCTIONS, "pi"}
    for formula in formulas:
        if type(formula) is not str:
            return None
        names = set(_IDENTIFIER.findall(formula))
        if not names <= known:
            return None
        used |= {state_of[name] for name in names & state_of.keys()}
    return used


def _entries(listed: Any) -> list[Any]:
    return listed if isinstance(listed, list) else []


def _names(listed: Any, where: str, path: Path) -> set[str]:
    """Return the names; an entry of a file is a name, or a table with a name."""
    entries = listed if isinstance(listed, list) else [None]
    names = [entry.get("name") if isinstance(entry, dict) else entry for entry in entries]
    texts = {name for name in names if type(name) is str}  # a number of the reader is a str too
    if not all(type(name) is str for name in names):
        raise other_plant(path, f"{where} is no list of names")
    return texts


def _told(names: set[str] | None) -> str:
    return ", ".join(ascii(name)[1:-1] for name in sorted(names or ())) or "nothing"


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "none"


def _refuse_names(file: Mapping[str, Any], names: set[str], path: Path, words: str) -> None:
    """Refuse a name with which something of the certificate would stand in the file's place."""
    sections = ("states", "inputs", "disturbances", "scheduling", "parameters", "equations")
    stated = {name for section in sections for name in _object(file.get(section, {}))}
    if name_clashes := stated & names:
        raise other_plant(path, f"{_listed(name_clashes)} is a quantity of the file, and {words}")


def integrators_in(file: Mapping[str, Any], model: Any, gains: Any, path: Path) -> dict[str, str]:
    """Return state -> rate of the integrators that the certificate has beside the file's plant.

    Raises
    ------
    CertificateError : model and law do not have the same.
    OtherModel : ``controller`` of the file asks for another law, or a name is one of the file.
    """
    integrators = integrators_of(model, gains)
    count, asked = len(integrators), _object(file.get("design")).get("controller")
    order = _object(asked).get("order", 0)
    matches = type(order) is int and order == count and (count == 0 or isinstance(asked, dict))
    if isinstance(gains, dict) and asked is not None and not matches:
        raise other_plant(
            path,
            f"its field controller is {in_words(asked)}, and the law has {count or 'no'} states of "
            "its own",
        )
    names = {*integrators, *integrators.values()}
    _refuse_names(file, names, path, "the controller's own in the certificate")
    return integrators


@dataclass(frozen=True)
class FileReferences:
    """Reference -> its entry in the file, and its integral in the certificate."""

    entries: Mapping[str, Mapping[str, Any]]
    integral: Mapping[str, str]
    path: Path

    @classmethod
    def of(cls, file: Mapping[str, Any], model: Any, path: Path) -> FileReferences:
        """Return the references of the file, with their integrals in the certificate.

        Raises
        ------
        OtherModel : they are not those of one another, or a section is malformed.
        """
        entries = file.get("reference", {})
        listed = model.get("references", [])
        if not isinstance(entries, dict) or not all(isinstance(e, dict) for e in entries.values()):
            raise other_plant(path, "[reference] is no section there")
        ours = listed if isinstance(listed, list) else []
        named = {
            str(reference.get("reference")): str(reference.get("integral"))
            for reference in ours
            if isinstance(reference, dict)
        }
        if sorted(entries) != sorted(named):
            raise other_plant(
                path,
                f"references are {_listed(entries)} there, {_listed(named)} in the certificate",
            )
        words = "a reference or an integral in the certificate"
        _refuse_names(file, {*entries, *named.values()}, path, words)
        return cls(entries, named, path)

    @property
    def integrals(self) -> dict[str, Any]:
        """The integral states, in the format of the file: rest 0, no range."""
        return {self.integral[name]: {} for name in self.entries}

    def signals(
        self, states: Mapping[str, Any], outputs: Mapping[str, Any], plant: PlantNodes
    ) -> dict[str, Any]:
        """The signals, in the format of the file; each rests at the value of what follows it.

        The rest is that of the certificate, which proves that the integral is constant there.
        """
        rests = {v.name: plant.graph.value(v.rest) for v in plant.disturbances}
        signals: dict[str, Any] = {}
        for name, entry in self.entries.items():
            followed = entry.get("follow")
            quantity = (
                outputs.get(followed, states.get(followed)) if isinstance(followed, str) else None
            )
            if not isinstance(quantity, dict):
                raise other_plant(self.path, f"reference.{name}.follow is no state or output there")
            unit = entry.get("unit", quantity.get("unit", "-"))
            signals[name] = {"unit": unit, "range": entry.get("range"), "si rest": rests.get(name)}
        return signals

    def equations(self, outputs: Mapping[str, Any]) -> dict[str, str]:
        """The equations of the integrals."""
        equations = {}
        for name, entry in self.entries.items():
            followed = str(entry["follow"])
            output = outputs.get(followed)
            h = output.get("expression") if isinstance(output, dict) else followed
            equations[self.integral[name]] = f"({h}) - {name}"
        return equations


LARGEST = 100  # exponent of ten, in a figure
FIGURE = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*"
RANGE = re.compile(rf"\s*\[{FIGURE},{FIGURE}\](.*)", re.ASCII)


def uncertain_in(parameters: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return name -> unit, range and rest, of the parameters that have a range."""
    return {
        name: signal
        for name, entry in parameters.items()
        for signal in [_signal(entry)]
        if signal is not None
    }


def _signal(entry: Any) -> dict[str, Any] | None:
    if isinstance(entry, str):
        match = RANGE.fullmatch(entry)
        if match is None:
            return None
        entry = {"range": [Decimal(match[1]), Decimal(match[2])], "unit": match[3].strip() or "-"}
    elif isinstance(entry, list):
        entry = {"range": entry}
    if not isinstance(entry, dict) or entry.get("range") is None:
        return None
    ends = entry["range"]
    rest_value = entry.get("value")
    if rest_value is None and isinstance(ends, list) and len(ends) == 2:
        rest_value = _middle(*ends)
    return {"unit": entry.get("unit", "-"), "range": ends, "rest": rest_value}


def _middle(low: Any, high: Any) -> Fraction | None:
    """Return (low + high)/2; None for ends that are no finite numbers of usual size."""
    if any(isinstance(end, bool) or not isinstance(end, int | Decimal) for end in (low, high)):
        return None
    ends = [Decimal(low), Decimal(high)]
    if not all(end.is_finite() and abs(end.adjusted()) <= LARGEST for end in ends):
        return None
    return (Fraction(ends[0]) + Fraction(ends[1])) / 2
