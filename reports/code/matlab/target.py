"""The target `mat`: two functions, a README, and ``W.mat`` for who needs the gains alone."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import (
    Call,
    Constant,
    ControllerProgram,
    Formula,
    Name,
    Number,
    Operation,
    Spline,
    file_word,
    identifiers,
    parsed,
    reserved_words,
)
from takagi.reports.code.run import value_of
from takagi.reports.code.targets import REPORTED, Exported, ExportSettings, filled, shared_context

# The first 116 bytes of a MAT-file are free text.  scipy writes the date there, which is replaced:
# the same law must give the same bytes.
HEADER = 116


def struct_file(
    program: ControllerProgram, model: Mapping[str, Any] | None, claims: tuple[Any, ...]
) -> bytes:
    """Return a MAT-file of version 5 with the struct ``takagi``.

    Its members are ``name``, ``verdict``, ``sample_time`` ([] if the user chooses it),
    ``constants`` with every number of the program, and their ``units``.  A plant's law also has
    ``K`` (m, n, r) and ``rules`` (r, p); with its certificate ``A`` (n, n, r), ``B`` (n, m, r), and
    in ``P`` one matrix for each claim that has one.

    Parameters
    ----------
    model, claims : of the certificate; with None and () their members are left out.
    """
    # Imported here: scipy loads slowly, and other targets do not need it.
    from scipy.io import savemat

    names = words_of(program)
    content: dict[str, Any] = {
        "name": program.name,
        "verdict": program.verdict,
        "sample_time": [] if program.sample_time is None else float(program.sample_time),
        "constants": {
            names[constant.name]: _member(constant.value) for constant in program.constants
        },
        "units": {names[constant.name]: constant.unit for constant in program.constants},
    }
    law = program.document["law"]
    if "K" in law:
        content["K"] = np.moveaxis(np.array(law["K"], dtype=np.float64), 0, 2)
        content["rules"] = np.array(law.get("rules", []), dtype=np.float64)
    if model is not None and "rules" in law:
        content |= _vertices(model, law)
    matrices = {
        f"claim_{k}_{claim['kind'].replace('-', '_')}": np.array(
            [[_float(number) for number in row] for row in claim["P"]]
        )
        for k, claim in enumerate(claims)
        if _is_matrix(claim.get("P"))
    }
    if matrices:
        content["P"] = matrices
    written = io.BytesIO()
    file: Any = written
    savemat(file, {"takagi": content}, long_field_names=True, oned_as="column")
    text = b"MATLAB 5.0 MAT-file, written by takagi"
    return text.ljust(HEADER) + written.getvalue()[HEADER:]


def _member(value: Any) -> Any:
    if isinstance(value, Decimal):
        return float(value)
    if isinstance(value, Spline):
        fields = {f"knots{k}": _member(knots) for k, knots in enumerate(value.knots, start=1)}
        rows = value.coefficients
        return fields | {"coefficients": _member(rows if len(value.knots) > 1 else rows[0])}
    return np.array(value, dtype=np.float64)


def _vertices(model: Mapping[str, Any], law: Mapping[str, Any]) -> dict[str, Floats]:
    """Return A and B of every rule if the certificate's model has them as formulas, else {}."""
    embedding = model.get("embedding") or {}
    if not {"A", "B", "premises"} <= set(embedding):
        return {}
    parameters = {name: _float(text) for name, text in law.get("parameters", {}).items()}
    parameters |= {name: _float(text) for name, text in model.get("parameters", {}).items()}
    vertices: dict[str, Floats] = {}
    for word in ("A", "B"):
        stack = []
        for rule in law["rules"]:
            corner = {
                premise["name"]: _float(premise["upper"] if bit == 1 else premise["lower"])
                for premise, bit in zip(embedding["premises"], rule, strict=True)
            }
            rows = embedding[word]
            stack.append(
                [
                    [value_of(parsed(str(entry)), parameters | corner) for entry in row]
                    for row in rows
                ]
            )
        vertices[word] = np.moveaxis(np.array(stack, dtype=np.float64), 0, 2)
    return vertices


def _float(value: Any) -> float:
    """Return a number of a certificate, which may be a fraction or the middle of a ball."""
    if isinstance(value, Mapping):
        return _float(value["value"])
    return float(Fraction(str(value)))


def _is_matrix(value: Any) -> bool:
    """Return whether a claim's P is one matrix; some claims have one for each rule."""
    return bool(
        isinstance(value, list)
        and value
        and all(isinstance(row, list) and len(row) == len(value) for row in value)
        and not any(isinstance(number, list) for row in value for number in row)
    )


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W_step.m``, ``W_start.m``, ``W.mat`` and ``README.md``.

    Raises
    ------
    ModelError : single precision, or a sample time that is not the law's own.
    """
    if settings.precision != "double":
        raise ModelError("--to mat computes in double; leave --precision out, or take --to c")
    word = file_word(program.plant)
    return Exported(
        {
            f"{word}.mat": struct_file(program, settings.model, settings.claims),
            **texts(program, word, settings),
        },
        {
            f"{word}_step.m": "one sample of the law; runs in MATLAB, Simulink and Octave",
            f"{word}_start.m": "its state before the first sample",
            f"{word}.mat": f"struct of gains, tables and matrices: load {word}.mat",
            "README.md": "inputs, outputs, units, an example and a Simulink block",
        },
    )


# Keywords and functions that a name must not replace.
RESERVED = reserved_words("matlab")


def words_of(program: ControllerProgram) -> dict[str, str]:
    """Return name of the program -> identifier in MATLAB, which must not begin with ``_``."""
    stripped = {name: name.lstrip("_") or "x" for name in program.names()}
    unique = identifiers(stripped.values(), RESERVED, language="MATLAB")
    return {name: unique[word] for name, word in stripped.items()}


def texts(program: ControllerProgram, word: str, settings: ExportSettings) -> dict[str, str]:
    """Return ``W_step.m`` with the functions that it calls, ``W_start.m`` and ``README.md``."""
    names = words_of(program)
    context = shared_context(program, settings, REPORTED) | {
        "word": word,
        "names": names,
        "constants": [
            line
            for constant in program.constants
            for line in _definition(constant, names[constant.name])
        ],
        "text": lambda formula: _text(formula, names),
        "line": _line,
    }
    templates = {f"{word}_step.m": "step.m", f"{word}_start.m": "start.m", "README.md": "README.md"}
    return {name: filled("matlab", template, context) for name, template in templates.items()}


def _definition(constant: Constant, name: str) -> Iterator[str]:
    value = constant.value
    note = f"  % {_line(constant.unit)}; {constant.path}"
    if isinstance(value, Spline):
        for k, knots in enumerate(value.knots, start=1):
            yield f"{name}.knots{k} = {_matrix([knots])};{note}"
        yield f"{name}.coefficients = {_matrix(value.coefficients)};"
    elif isinstance(value, Decimal):
        yield f"{name} = {value};{note}"
    else:
        rows = value if isinstance(value[0], tuple) else [value]
        yield f"{name} = {_matrix(rows)};{note}"


def _text(formula: Formula, names: Mapping[str, str]) -> str:
    def text(part: Formula) -> str:
        return _text(part, names)

    match formula:
        case Number(value):
            return str(value)
        case Name("sample_time"):
            return "T"
        case Name(name):
            return names.get(name, name)
        case Operation(sign, None, right):
            return f"({sign}{text(right)})"
        case Operation(sign, left, right) if left is not None:
            return f"({text(left)}{sign}{text(right)})"
        case Call("first", (row,)):
            return f"{text(row)}(1)"
        case Call("last", (row,)):
            return f"{text(row)}(end)"
        case Call("mix", (rules, values, *weights)):
            weight_texts = ", ".join(map(text, weights))
            return f"mix({text(rules)}, {text(values)}, [{weight_texts}])"
        case Call("spline", arguments):
            word = f"spline{len(arguments) - 1}"
            return f"{word}({', '.join(map(text, arguments))})"
        case Call(function, arguments):
            return f"{function}({', '.join(map(text, arguments))})"
    raise AssertionError(formula)


def _matrix(rows: Iterable[Iterable[object]]) -> str:
    """Return rows of numbers as a matrix, eight numbers in a line."""
    texts = []
    for row in rows:
        numbers = [str(number) for number in row]
        lines = [" ".join(numbers[k : k + 8]) for k in range(0, len(numbers), 8)]
        texts.append(" ...\n    ".join(lines))
    return "[" + "; ...\n    ".join(texts) + "]"


def _line(text: str) -> str:
    """Return a text on one line, for a comment."""
    return " ".join(text.split())
