"""A design as JSON, ``design.json``: what its pages read, beside the gains and the certificate.

Written once, at design time; ``design_of_record`` makes the design of it again, and solves nothing.
The model is derived again from the copies of its files, and the certificate is checked again.

Values of takagi's own classes are objects with the class's name and members; what is derived again
is a name.  Only dataclasses and named tuples below ``takagi.`` are made, by their members.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.replay.certificate import WITHOUT, check
from takagi.certificates.design.design import Design, StepClock, Tell
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.static_gains import plant_of_law
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.pdc import ReferenceFeedback
from takagi.models.laws.published.regional_schedule import model_evaluators
from takagi.models.loading import read_model
from takagi.models.turbine.region_models import full_load_model, partial_load_model
from takagi.models.turbine.trim import derated
from takagi.models.turbine.wind_observer import wind_observer_model
from takagi.reports.figures.response import QUANTITIES

if TYPE_CHECKING:
    from takagi.models.loading import ModelFile

UNREADABLE = (
    ArithmeticError, AttributeError, ImportError, LookupError, RecursionError, TypeError, ValueError
)  # fmt: skip


# Modules that folders of before name, and where their records are now.
_MOVED = {
    "takagi.reports.margins.running_search": "takagi.reports.margins.running_over_wind",
    "takagi.reports.simulation.design_runs": "takagi.reports.simulation.measured_loop",
}


def design_record(design: Design, source: ModelFile, model: str) -> str:
    """Return the text of ``design.json``.

    Parameters
    ----------
    source : the model's file.
    model : the place of its copy, relative to the design's folder.
    """
    data = {
        "given": str(source.name),
        "model": model,
        "settings": _Writer({})(design.settings),
        "design": _Writer(_derived_of(design))(design),
    }
    return json.dumps(data, separators=(",", ":")) + "\n"


def design_of_record(
    record: Mapping[str, Any],
    model: Path,
    certificate: Path,
    gains: Path | None,
    *,
    tell: Tell | None = None,
) -> Design:
    """Return the design that a folder records, with the verdicts of a check made now.

    Parameters
    ----------
    record : the content of ``design.json``;  model, certificate, gains : the files beside it.
    tell : called with a word before each step.

    Raises
    ------
    CertificateError : a file is damaged, or gains, model and certificate are not of one design.
    ModelError : the copy of the model, or a member of the record, cannot be read.
    """
    clock = StepClock(tell)
    with clock("check of the certificate"):
        checked = check(certificate, gains=gains, model=model)
        # What a check says of the files that it was not given is no part of a design.
        messages = [text for text in checked.messages if text != WITHOUT.format("gain", "gains")]
        checked = replace(checked, messages=messages)
    document = json.loads(certificate.read_text(encoding="utf-8"))
    with clock("model"):
        source = read_model(model)
        try:
            settings = _Reader({})(record["settings"])
            derived = _derived_again(source, settings, gains)
            derived |= {"settings": settings, "document": document, "checked": checked}
            design: Design = _Reader(derived)(record["design"])
            # A record that states verdicts, a certificate or a model of its own is refused.
            for name, value in _derived_of(design).items():
                if value is not derived[name]:
                    raise ValueError(f"it states {name!r} of its own")
            if isinstance(design, PlantDesign):
                _require_proved_law(design, document)
            else:
                _require_readable(design)
        except (ModelError, CertificateError):
            raise
        except UNREADABLE as error:
            version, folder = _version(document), certificate.parent
            raise ModelError(
                f"{folder}/design.json: cannot be read ({type(error).__name__}: {error}), for it "
                f"is damaged, or of another version ({version}); design again with 'takagi design "
                f"{record.get('given')} --out {folder} --force'"
            ) from error
    return design


def _derived_of(design: Any) -> dict[str, Any]:
    """Return name -> the parts of a design that are not written, because they are made again."""
    derived = {"document": design.document, "checked": design.checked, "settings": design.settings}
    if design.kind == "plant":
        return derived | {"plant": design.plant, "model": design.model}
    from takagi.models.laws.published.law import PublishedLaw

    names = ("turbine", "partial_load", "full_load")
    observed = {"observer": design.observer.model}
    derived |= observed | {name: getattr(design, name) for name in names}
    if isinstance(design.law, PublishedLaw):
        # Functions of the premises, which JSON cannot hold.
        derived["partial evaluators"] = design.law.partial.evaluators
        derived["full evaluators"] = design.law.full.evaluators
    return derived


def _derived_again(source: ModelFile, settings: Any, gains: Path | None) -> dict[str, Any]:
    """Return the same parts, without document and verdicts, from the model's file."""
    if source.kind == "plant":
        from takagi.certificates.design.given.plant_gains import in_ranges_of
        from takagi.certificates.design.plant.tracking_design import claims_alone
        from takagi.certificates.design.plant.work import plant_model

        plant = plant_of_law(source.model, settings)
        if gains is not None and claims_alone(plant):
            plant = in_ranges_of(gains, plant)
        return {"plant": plant, "model": plant_model(plant, settings)}
    speed = settings.speed_setpoint
    turbine = derated(source.model, settings.torque_setpoint, speed_setpoint=speed)
    partial = partial_load_model(turbine, speed_setpoint=speed)
    full = full_load_model(turbine, speed_setpoint=speed)
    return {
        "turbine": turbine,
        "partial_load": partial,
        "full_load": full,
        "observer": wind_observer_model(turbine, speed_setpoint=speed),
        "partial evaluators": model_evaluators(turbine, partial, speed),
        "full evaluators": model_evaluators(turbine, full, speed),
    }


def _require_readable(design: Design) -> None:
    """Refuse a turbine's margins and runs that the pages cannot show."""
    from takagi.reports.sections.turbine.summary import summary_rows
    from takagi.reports.simulation.measured_loop import MeasuredLoop

    if not isinstance(design, TurbineDesign) or design.measured is None:
        return
    if not isinstance(design.measured, MeasuredLoop):
        raise ValueError("its margins and runs are of another kind")
    for run in design.measured.runs:
        for line in (result.line for result in (run.law, run.reference) if result and result.line):
            # Raises where their lengths differ, or one holds no numbers.
            np.sum([run.time, run.schedule, *(getattr(line, name) for name in QUANTITIES)])
    summary_rows(design)


def _require_proved_law(design: PlantDesign, document: Mapping[str, Any]) -> None:
    """Refuse a plant's model or law other than those of the certificate."""
    model, stated = plant_and_claim(design.model)[0], document["model"]
    if model is not None and model != {key: stated.get(key) for key in model}:
        raise ValueError("its model is not the certificate's")
    law = document.get("gains")
    if law is None or design.gains is None:
        if law is not design.gains:
            raise ValueError("its gains are not the certificate's")
        return
    output = design.output_law
    run = design.law if output is None else output.feedback
    pairs: list[tuple[Floats, Any]] = [(design.gains, law["K"])]
    if run is not None:
        pairs += [(run.gains, law["K"]), (run.state_rest, law["trim"]["state"])]
        pairs += [(run.input_rest, law["trim"]["input"])]
    if isinstance(output, ReferenceFeedback):
        pairs += [(getattr(output.observer, key), law["observer"][key]) for key in "ABCL"]
    elif output is not None:
        pairs += [(output.L, law["observer"]["L"])]
    for recorded, proved in pairs:
        if not np.array_equal(
            recorded, np.broadcast_to(np.asarray(proved, float), np.shape(recorded))
        ):
            raise ValueError("its gains are not the certificate's")


def _version(document: Any) -> str:
    """Return the version that wrote a certificate, as far as it says so."""
    for key in ("provenance", "versions", "takagi"):
        document = document.get(key) if isinstance(document, Mapping) else None
    return str(document)


class _Writer:
    """Values as JSON; ``derived`` are named, and a value that occurs again is a number."""

    def __init__(self, derived: Mapping[str, Any]) -> None:
        self._names = {id(value): name for name, value in derived.items()}
        self._before: dict[int, int] = {}

    def __call__(self, value: Any) -> Any:
        if value is None or isinstance(value, bool | int | str):
            return value
        if isinstance(value, float):
            number = float(value)
            return number if np.isfinite(number) else {"float": repr(number)}
        if isinstance(value, np.generic):
            return self(value.item())
        if id(value) in self._names:
            return {"derived": self._names[id(value)]}
        if isinstance(value, Fraction):
            return {"fraction": str(value)}
        if isinstance(value, np.ndarray):
            entries = [self(entry) for entry in value.ravel().tolist()]
            return {"array": entries, "shape": value.shape, "type": value.dtype.name}
        if isinstance(value, Mapping):
            return {"mapping": [[self(key), self(entry)] for key, entry in value.items()]}
        if isinstance(value, list):
            return [self(entry) for entry in value]
        if (names := _members(type(value))) is None:
            if isinstance(value, Sequence):
                return {"tuple": [self(entry) for entry in value]}
            raise TypeError(f"a design holds a {type(value).__qualname__}, which JSON cannot")
        if id(value) in self._before:
            return {"again": self._before[id(value)]}
        members = {name: self(getattr(value, name)) for name in names}
        self._before[id(value)] = len(self._before)
        kind = type(value)
        return {"class": f"{kind.__module__}:{kind.__qualname__}", "members": members}


class _Reader:
    """The values that ``_Writer`` wrote."""

    def __init__(self, derived: Mapping[str, Any]) -> None:
        self._derived = derived
        self._before: list[Any] = []

    def __call__(self, data: Any) -> Any:
        if isinstance(data, list):
            return [self(entry) for entry in data]
        if not isinstance(data, dict):
            return data
        if "class" in data:
            return self._object(data)
        if "array" in data:
            return self._array(data)
        ((kind, content),) = data.items()
        match kind:
            case "derived":
                return self._derived[content]
            case "again":
                return self._before[content]
            case "float":
                return float(content)
            case "fraction":
                over, _, under = content.partition("/")
                return Fraction(int(over), int(under or 1))
            case "tuple":
                return tuple(self(entry) for entry in content)
            case "mapping":
                return {self(key): self(entry) for key, entry in content}
        raise ValueError(f"{kind!r} is no kind of value")

    def _object(self, data: Mapping[str, Any]) -> Any:
        module, _, name = data["class"].partition(":")
        module = _MOVED.get(module, module)
        # Nothing but data: no other module is imported, and nothing but a record is called.
        kind = getattr(import_module(module), name) if module.startswith("takagi.") else None
        if kind is None or _members(kind) is None or kind.__module__ != module:
            raise ValueError(f"{data['class']} is no record of takagi")
        value = kind(**{key: self(entry) for key, entry in data["members"].items()})
        self._before.append(value)
        return value

    def _array(self, data: Mapping[str, Any]) -> Floats:
        array = np.empty(len(data["array"]), dtype=data["type"])
        array[:] = [self(entry) for entry in data["array"]]
        return array.reshape(data["shape"])


def _members(kind: Any) -> tuple[str, ...] | None:
    """Return the names of a record's members; None for a class that is none, or is a sequence."""
    if isinstance(kind, type) and issubclass(kind, tuple):
        named: tuple[str, ...] | None = getattr(kind, "_fields", None)
        return named
    if not isinstance(kind, type) or not is_dataclass(kind) or issubclass(kind, Sequence | Enum):
        return None
    return tuple(field.name for field in fields(kind) if field.init)
