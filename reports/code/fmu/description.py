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
        _element(
            "Float64",
            name=variable.name,
            valueReference=reference,
            **_kind(variable),
            **_real(variable),
        )
        for reference, variable in enumerate(model.variables)
    ]
    outputs = [*_outputs(model), len(model.variables)]
    unknown = [
        reference
        for reference in outputs
        if reference == len(model.variables) or model.variables[reference].start is None
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
            *(_element("Output", valueReference=reference) for reference in outputs),
            *(_element("InitialUnknown", valueReference=reference) for reference in unknown),
        ),
    )


def model_description_2(model: FmuModel, token: str, sources: Iterable[str]) -> str:
    """Return the description of an FMU of FMI 2.0."""
    variables = [
        _element(
            "ScalarVariable",
            (_element("Real", **_real(variable)),),
            name=variable.name,
            valueReference=reference,
            **_kind(variable),
        )
        for reference, variable in enumerate(model.variables)
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
    unknown = [
        index for index in outputs if index == status or model.variables[index].start is None
    ]
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
            _element("Outputs", (_element("Unknown", index=index + 1) for index in outputs)),
            _element(
                "InitialUnknowns", (_element("Unknown", index=index + 1) for index in unknown)
            ),
        ),
    )


def build_description(model: FmuModel, sources: Iterable[str]) -> str:
    """Return buildDescription.xml of FMI 3.0: how the sources become a library."""
    files = tuple(_element("SourceFile", name=name) for name in sources)
    elements = (
        _element("SourceFileSet", files, language="C99"),
        _element("Library", name="m", external="true"),
    )
    configuration = _element("BuildConfiguration", elements, modelIdentifier=model.word)
    return HEAD + _element("fmiBuildDescription", (configuration,), fmiVersion="3.0") + "\n"


def _whole(
    model: FmuModel,
    version: dict[str, str],
    interface: str,
    variables: Iterable[str],
    structure: Iterable[str],
) -> str:
    step = float(model.c.sample_time)
    elements = (
        interface,
        _element("UnitDefinitions", _units(model)),
        _element(
            "LogCategories", (_element("Category", name=name, description=d) for name, d in LOGS)
        ),
        _element("DefaultExperiment", startTime="0", stopTime=repr(1000 * step), stepSize=step),
        _element("ModelVariables", variables),
        _element("ModelStructure", structure),
    )
    description = " ".join(proof_lines(model.program))
    gains = model.program.hashes.get("gains")
    if gains:
        description += f", SHA-256 of its gains {gains}"
    root = _element(
        "fmiModelDescription",
        elements,
        **version,
        modelName=model.title,
        description=description,
        generationTool="takagi",
        variableNamingConvention="flat",
    )
    return HEAD + root + "\n"


def _outputs(model: FmuModel) -> list[int]:
    return [
        reference
        for reference, variable in enumerate(model.variables)
        if CAUSALITY[variable.role] == "output"
    ]


def _units(model: FmuModel) -> Iterator[str]:
    for unit in dict.fromkeys(
        variable.unit for variable in model.variables if variable.unit not in ("", "-")
    ):
        exponents = base_units(unit)
        base = () if exponents is None else (_element("BaseUnit", (), **exponents),)
        yield _element("Unit", base, name=unit)


def _kind(variable: Variable) -> dict[str, str]:
    """Return causality, variability, initial and description."""
    attributes = {"causality": CAUSALITY[variable.role]}
    if variable.role == "parameter":
        attributes["variability"] = "fixed"
    else:
        attributes["variability"] = "continuous" if variable.continuous else "discrete"
    if variable.role == "parameter":
        attributes["initial"] = "exact"
    elif variable.role in ("output", "kept"):
        attributes["initial"] = "calculated"
    if variable.description:
        attributes["description"] = variable.description
    return attributes


def _real(variable: Variable) -> dict[str, str]:
    attributes = {} if variable.unit in ("", "-") else {"unit": variable.unit}
    if variable.start is not None:
        attributes["start"] = repr(float(variable.start))
    return attributes


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
        parsed = parse_unit(unit)
    except ModelError:
        return None
    powers = parsed.dimension.exponents
    if not parsed.is_si or any(power.denominator != 1 for power in powers):
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
