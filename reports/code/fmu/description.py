"""modelDescription.xml of FMI 3.0 and 2.0, and buildDescription.xml."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from xml.sax.saxutils import quoteattr

from takagi.models.errors import ModelError
from takagi.models.files.units import BASE, parse_unit
from takagi.reports.code.fmu.model_source import FmuModel, Variable
from takagi.reports.code.proof_words import proof_lines

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
CAUSALITY = {
    "time": "independent",
    "parameter": "parameter",
    "input": "input",
    "output": "output",
    "kept": "local",
}
LOGS = (("logStatusWarning", "said once"), ("logStatusError", "why a call was refused"))


def model_description_3(model: FmuModel, token: str) -> str:
    """Return the description of an FMU of FMI 3.0."""
    variables = [
        _element("Float64", name=one.name, valueReference=place, **_kind(one), **_real(one))
        for place, one in enumerate(model.variables)
    ]
    outputs = [*_outputs(model), len(model.variables)]
    unknown = [
        place
        for place in outputs
        if place == len(model.variables) or model.variables[place].start is None
    ]
    variables.append(
        _element("UInt32", name="status", valueReference=len(model.variables), **_status(model))
    )
    return _whole(
        model,
        {"fmiVersion": "3.0", "instantiationToken": token},
        _element(
            "CoSimulation",
            modelIdentifier=model.word,
            canGetAndSetFMUState="true",
            canSerializeFMUState="true",
            canHandleVariableCommunicationStepSize="true",
        ),
        variables,
        (
            *(_element("Output", valueReference=place) for place in outputs),
            *(_element("InitialUnknown", valueReference=place) for place in unknown),
        ),
    )


def model_description_2(model: FmuModel, token: str, sources: Iterable[str]) -> str:
    """Return the description of an FMU of FMI 2.0."""
    variables = [
        _element(
            "ScalarVariable",
            (_element("Real", **_real(one)),),
            name=one.name,
            valueReference=place,
            **_kind(one),
        )
        for place, one in enumerate(model.variables)
    ]
    status = len(model.variables)
    variables.append(
        _element(
            "ScalarVariable",
            (_element("Integer"),),
            name="status",
            valueReference=status,
            **_status(model),
        )
    )
    # Places are counted from 1 here.
    outputs = [*_outputs(model), status]
    unknown = [one for one in outputs if one == status or model.variables[one].start is None]
    files = tuple(_element("File", name=name) for name in sources)
    return _whole(
        model,
        {"fmiVersion": "2.0", "guid": token},
        _element(
            "CoSimulation",
            (_element("SourceFiles", files),),
            modelIdentifier=model.word,
            canHandleVariableCommunicationStepSize="true",
            canNotUseMemoryManagementFunctions="true",
            canGetAndSetFMUstate="true",
            canSerializeFMUstate="true",
        ),
        variables,
        (
            _element("Outputs", (_element("Unknown", index=one + 1) for one in outputs)),
            _element("InitialUnknowns", (_element("Unknown", index=one + 1) for one in unknown)),
        ),
    )


def build_description(model: FmuModel, sources: Iterable[str]) -> str:
    """Return buildDescription.xml of FMI 3.0: how the sources become a library."""
    files = tuple(_element("SourceFile", name=name) for name in sources)
    parts = (
        _element("SourceFileSet", files, language="C99"),
        _element("Library", name="m", external="true"),
    )
    configuration = _element("BuildConfiguration", parts, modelIdentifier=model.word)
    return HEAD + _element("fmiBuildDescription", (configuration,), fmiVersion="3.0") + "\n"


def _whole(
    model: FmuModel,
    version: dict[str, str],
    interface: str,
    variables: Iterable[str],
    structure: Iterable[str],
) -> str:
    step = float(model.c.sample_time)
    parts = (
        interface,
        _element("UnitDefinitions", _units(model)),
        _element(
            "LogCategories", (_element("Category", name=name, description=d) for name, d in LOGS)
        ),
        _element("DefaultExperiment", startTime="0", stopTime=repr(1000 * step), stepSize=step),
        _element("ModelVariables", variables),
        _element("ModelStructure", structure),
    )
    about = " ".join(proof_lines(model.program))
    gains = model.program.hashes.get("gains")
    if gains:
        about += f", SHA-256 of its gains {gains}"
    root = _element(
        "fmiModelDescription",
        parts,
        **version,
        modelName=model.title,
        description=about,
        generationTool="takagi",
        variableNamingConvention="flat",
    )
    return HEAD + root + "\n"


def _outputs(model: FmuModel) -> list[int]:
    return [place for place, one in enumerate(model.variables) if CAUSALITY[one.role] == "output"]


def _units(model: FmuModel) -> Iterator[str]:
    for unit in dict.fromkeys(one.unit for one in model.variables if one.unit not in ("", "-")):
        exponents = base_units(unit)
        base = () if exponents is None else (_element("BaseUnit", (), **exponents),)
        yield _element("Unit", base, name=unit)


def _kind(one: Variable) -> dict[str, str]:
    """Return causality, variability, initial and description."""
    found = {"causality": CAUSALITY[one.role]}
    if one.role == "parameter":
        found["variability"] = "fixed"
    else:
        found["variability"] = "continuous" if one.continuous else "discrete"
    if one.role == "parameter":
        found["initial"] = "exact"
    elif one.role in ("output", "kept"):
        found["initial"] = "calculated"
    if one.description:
        found["description"] = one.description
    return found


def _real(one: Variable) -> dict[str, str]:
    found = {} if one.unit in ("", "-") else {"unit": one.unit}
    if one.start is not None:
        found["start"] = repr(float(one.start))
    return found


def _status(model: FmuModel) -> dict[str, str]:
    bits = ", ".join(
        f"{bit} {word.replace('_', ' ').lower()}"
        for word, bit in sorted(model.c.status_bits.items(), key=lambda pair: pair[1])
    )
    return {
        "causality": "output",
        "variability": "discrete",
        "initial": "calculated",
        "description": f"of the last sample, a sum of: {bits}; 0 where all is well",
    }


def _element(tag: str, inside: Iterable[str] = (), /, **attributes: object) -> str:
    """Return an element, its parts one level deeper."""
    head = "".join(f" {key}={quoteattr(str(value))}" for key, value in attributes.items())
    body = "\n".join(inside)
    if not body:
        return f"<{tag}{head}/>"
    deeper = "\n".join(f"  {line}" for line in body.split("\n"))
    return f"<{tag}{head}>\n{deeper}\n</{tag}>"


def base_units(unit: str) -> dict[str, int] | None:
    """Return the exponents of kg, m, s, A, K, mol, cd and rad that are not 0.

    None for a text that is no SI unit; signals of a gain file are in SI.
    """
    try:
        found = parse_unit(unit)
    except ModelError:
        return None
    powers = found.dimension.exponents
    if not found.is_si or any(power.denominator != 1 for power in powers):
        return None
    exponents = {name: int(power) for name, power in zip(BASE, powers, strict=True)}
    exponents["rad"] = _radians(unit)
    return {name: power for name, power in exponents.items() if power}


def _radians(unit: str) -> int:
    """Return the exponent of rad, which is a pure number in SI and a base unit in FMI."""
    above, _, below = unit.partition("/")

    def count(text: str) -> int:
        return sum(int(power or 1) for power in re.findall(r"\brad\b(?:\^(-?\d+))?", text))

    return count(above) - count(below)
