"""What is said of a model's file beside a certificate, changed in each part."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from takagi.certificates.checker.kernel.reader import Number
from tests.certificates.pinned.turbine.model_file_changes import REPLACED
from tests.certificates.pinned.turbine.recorded_files import (
    PLANTS,
    TURBINES,
    answer,
    certificate,
    model_of,
    texts_of,
)
from tests.certificates.pinned.turbine.values import Named

# Changes in one group.
TOGETHER = 12


NUMBER = re.compile(r"(?<![\w^.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")


TEXT = re.compile(r'"[^"]*"')


ENTRY = re.compile(r"(?m)^\w+ = .*\n|, \w+ = (?:\[[^\]]*\]|\{[^}]*\}|[^,}\]]+)(?=[,} ])")


def rewrites(text: str) -> Iterator[tuple[str, str]]:
    """Yield the text with a number larger or of another kind, another word, or an entry less."""
    changes: tuple[tuple[re.Pattern[str], Callable[[str], list[str]]], ...] = (
        (NUMBER, lambda found: [str(round(float(found) * 1.01 + 0.001, 6)), '"word"']),
        (TEXT, lambda _: ['"word"', "1"]),
        (ENTRY, lambda _: [""]),
    )
    for pattern, others in changes:
        for number, match in enumerate(pattern.finditer(text)):
            for other in others(match[0]):
                line = text.count("\n", 0, match.start()) + 1
                name = f"line {line}, {match[0].strip()[:24]} {number} to {other or 'nothing'}"
                yield name, f"{text[: match.start()]}{other}{text[match.end() :]}"


def of_rewrites(name: str, file: str, first: int, step: int) -> Named:
    """Yield the answers to some of the rewrites of one file."""
    data, texts = certificate(name), texts_of(name)
    listed = list(rewrites(texts[file]))[first::step]
    for what, text in listed:
        yield what, answer(data, texts | {file: text})


def of_replaced(name: str, first: int) -> Named:
    data, texts = certificate(name), texts_of(name)
    file = next(iter(texts))
    for number, (old, new) in enumerate(REPLACED[name]):
        if number % 4 == first:
            assert old in texts[file] or old == "sin", old
            changed = texts | {file: texts[file].replace(old, new, 1)}
            yield f"{number}: {old[:40]!r} to {new[:60]!r}", answer(data, changed)


def of_certificate(name: str, first: int) -> Named:
    """Yield the answers where the certificate's model or law is changed instead."""
    texts = texts_of(name)
    for number, (path, value) in enumerate(_places(model_of(name))):
        if number % 4 != first:
            continue
        data = certificate(name)
        holder: Any = data["model"]
        for step in path[:-1]:
            holder = holder[step]
        if value is None:
            del holder[path[-1]]
        else:
            holder[path[-1]] = value
        yield f"{path} to {value}", answer(data, texts)


def of_free_actuators() -> Named:
    """Yield the answers where the one, the other or both have an actuator without a range."""
    texts = texts_of("room")
    file, text = next(iter(texts.items()))
    free = text.replace(", range = [0, 1.5]", "")
    for name, written in (("both", free), ("the certificate", text)):
        data = certificate("room")
        data["model"]["blending"]["low"]["range"] = None
        del data["model"]["model_file"]["inputs"]["cooling"]["range"]
        yield name, answer(data, texts | {file: written})


def of_names_that_meet() -> Named:
    """Yield the answer where file and certificate have a parameter with an actuator's name."""
    texts, data = texts_of("room"), certificate("room")
    file, text = next(iter(texts.items()))
    named = text.replace("a = { value", 'cooling = { value = 1, unit = "-" }\na = { value')
    data["model"]["parameters"]["cooling"] = Number("1")
    yield "an actuator's name", answer(data, texts | {file: named})


def of_law_rows() -> Named:
    """Yield the answers where the law's rows are not as long as its winds."""
    for name in ("wind", "effectiveness_limit"):
        for short in (True, False):
            data, texts = certificate("turbine"), texts_of("turbine")
            row = data["gains"][name]
            data["gains"][name] = row[:-1] if short else [*row, Number("99")]
            yield f"{name} {short}", answer(data, texts)
    data = certificate("turbine")
    for what, gains in (("no limit", {"rated_torque": data["gains"]["rated_torque"]}),):
        yield what, answer({**data, "gains": gains}, texts_of("turbine"))


def _places(model: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    for key, part in model.items():
        if key not in ("model_file", "kind"):
            yield (key,), None
            if isinstance(part, (int, float)) and not isinstance(part, bool):
                yield (key,), Number(repr(part * 1.0001 + 1e-9))
    for path, value in (
        (("states", 0, "rest"), Number("1")),
        (("states", 0, "range"), None),
        (("inputs", 0, "rest"), Number("7")),
        (("inputs", 0, "rest"), Number("1.25")),
        (("blending", "low"), None),
        (("blending", "high"), 1),
        (("inputs", 0, "range", 1), Number("7")),
        (("parameters", "a"), "1/2"),
        (("parameters", "a"), Number("0.51")),
        (("parameters", "m"), "3/2"),
        (("tables", "rub", "coefficients", 2), Number("-0.04")),
        (("tables", "rub", "coefficients", 2), Number("-0.0500001")),
        (("tables", "rub", "knots", 0, 4), Number("0.001")),
        (("tables", "pull", "knots", 1, 4), Number("0.1")),
        (("blending", "overlap"), Number("0.4")),
        (("blending", "low", "idle"), Number("0.4")),
        (("blending", "low", "error"), None),
        (("blending", "high", "range"), None),
        (("blending", "equations"), None),
        (("blending", "equations"), []),
        (("torque_surface", "coefficients", 1, 1), Number("0.09")),
        (("torque_surface", "coefficients", 1, 1), Number("0.1000000001")),
        (("model_file", "name"), "another"),
    ):
        holder: Any = model
        for step in path[:-1]:
            inside = isinstance(holder, list) or step in holder
            holder = holder[step] if inside else None
            if holder is None:
                break
        if isinstance(holder, list) or (isinstance(holder, dict) and path[-1] in holder):
            yield path, value


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    found: dict[str, Any] = {
        "free actuators": of_free_actuators,
        "names that meet": of_names_that_meet,
        "rows of the law": of_law_rows,
    }
    for name in (*PLANTS, *TURBINES):
        for first in range(4):
            found[f"{name} replaced, {first}"] = lambda n=name, f=first: of_replaced(n, f)
        if name == "factor":
            continue
        for first in range(4):
            tag = f"certificate of {name}, {first}"
            found[tag] = lambda n=name, f=first: of_certificate(n, f)
        for file, text in texts_of(name).items():
            if file == "pull.csv":
                continue
            step = -(-sum(1 for _ in rewrites(text)) // TOGETHER)
            for first in range(step):
                found[f"{name}, {file}, {first}"] = lambda n=name, file=file, f=first, s=step: (
                    of_rewrites(n, file, f, s)
                )
    return found
