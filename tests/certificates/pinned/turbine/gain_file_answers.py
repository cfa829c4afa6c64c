"""The gain files that follow from certificates, and what is said of others."""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from takagi.certificates.checker.controller.content import file_content
from takagi.certificates.checker.controller.numbers import exact, short
from takagi.certificates.checker.files.gain_file import compare_gains, expected_file
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.controller.content import plain
from tests.certificates.pinned.turbine.inputs import CELLS, Document, as_read, document
from tests.certificates.pinned.turbine.recorded_files import (
    PLANTS,
    answer,
    certificate,
    own_words,
)
from tests.certificates.pinned.turbine.values import Named, said


def documents() -> Iterator[tuple[str, Document]]:
    """Yield every recorded certificate with a controller."""
    for name in PLANTS:
        yield name, certificate(name)
    own = {
        "observer": {"l1": Number("2.5"), "wind_limits": [Number("1.5"), Number("37.5")]},
        "start": {"wind": [Number("3")], "integrals": [[Number("0")], [Number("1")]]},
        "certificate": {"verdict": "PROVED"},
        "name": "a law",
    }
    for cell in (*CELLS, "paper", "paper-two-integrators"):
        data = as_read(document(cell))
        yield cell, data | {"controller": own}
    data = as_read(document("torque"))
    data["gains"]["wind_filter"] = Number("0")
    yield "torque without a filter", data | {"controller": own}
    for key in ("speed_ramp_shape", "variant"):
        data = as_read(document("paper"))
        data["gains"]["coupling"][key] = "other"
        yield f"paper, other {key}", data | {"controller": own}
    data = as_read(document("paper"))
    data["gains"]["coupling"]["speed_ramp_shape"] = "linear"
    data["gains"]["full"]["premises"]["d"] = [Number("1"), Number("1.0")]
    yield "paper, linear", data | {"controller": own}


def of_gain_files(name: str) -> Named:
    """Yield the whole gain file that follows from model and law, part by part."""
    data = dict(documents())[name]
    content = said(expected_file, data)
    if isinstance(content, str):
        yield "refused", content
        return
    for key, part in content.items():
        for number, entry in enumerate(part) if key == "programs" else [(0, part)]:
            yield f"{key} {number}", json.dumps(entry, ensure_ascii=True)


def told_of(about: Document, content: Any) -> Any:
    """Return what is said of a gain file with this content."""
    text = content if isinstance(content, str) else json.dumps(content)
    return answer(about, {"gains.json": text}, compare_gains)


def of_gain_members(name: str) -> Named:
    """Yield what is said of a gain file without one of its members, or with another."""
    data = dict(documents())[name]
    own = plain(expected_file(data))
    for key in own:
        yield f"without {key}", told_of(data, {k: v for k, v in own.items() if k != key})
        yield f"{key} is 1", told_of(data, {**own, key: 1})


def of_gain_changes(name: str) -> Named:
    """Yield what is said of a gain file that differs, or of another certificate."""
    data = dict(documents())[name]
    own = plain(expected_file(data))

    def told(content: Any, about: Document = data) -> Any:
        return told_of(about, content)

    yield "itself", told(own)
    yield "law alone", told({"law": own["law"]})
    yield "more", told({**own, "remark": "x", "note\n": 1})
    yield "much", told({**own, **{f"k{k}": k for k in range(1200)}})
    yield "no law", told({"format": "takagi-gains"})
    yield "no object", told("[]")
    law = {k: v for k, v in data.items() if k != "controller"}
    yield "without a controller", told(own, law)
    yield "its law alone", told({"law": own["law"]}, law)
    yield "another law", told({"law": {**own["law"], "name": "other"}}, law)
    earlier = {**data, "controller": {"version": Number("2"), "states": []}}
    yield "earlier", told({"format": "takagi-gains", "version": 2, "law": own["law"]}, earlier)
    yield "earlier, another", told({"version": 1, "law": own["law"]}, earlier)
    for what, broken in (
        ("no hashes", {**data, "provenance": {}}),
        ("no model", {**data, "model": {}}),
        ("model is a text", {**data, "model": "x"}),
        ("no premises", {**data, "gains": {"name": "pdc"}}),
        ("another name", {**data, "gains": {**data["gains"], "name": "paper"}}),
    ):
        yield what, told(own, broken)


def said_of_file(data: Document) -> Any:
    """Return the names of the members of the gain file, or why there is none."""
    found = said(expected_file, data)
    return own_words(found) if isinstance(found, str) else sorted(found)


def of_programs() -> Named:
    """Yield programs of other laws and models: no weights, measured premises, odd names."""
    data = certificate("cart")
    law, model, own = data["gains"], data["model"], data["controller"]

    def content(**changes: Any) -> str:
        parts = {"model": model, "law": law, "own": own, **changes}
        found = said(file_content, parts["model"], parts["law"], parts["own"])
        return found if isinstance(found, str) else json.dumps(found)

    yield "no premises", content(law={**law, "premises": []})
    flat = [{**p, "upper": p["lower"]} for p in law["premises"]]
    yield "flat premises", content(law={**law, "premises": flat})
    named = [{k: v for k, v in p.items() if k != "expression"} for p in law["premises"]]
    yield "measured premises", content(law={**law, "premises": named})
    with_signal = [{**law["premises"][0], "expression": "w + F + x"}, *law["premises"][1:]]
    yield "premises of signals", content(law={**law, "premises": with_signal})
    for key, symbol in (("disturbances", "dw"), ("states", "dx"), ("inputs", "dF")):
        listed = [{**v, "symbol": symbol} for v in model[key][:1]] + model[key][1:]
        premises = [{**law["premises"][0], "expression": f"{symbol} + x"}]
        changed = {**law, "premises": premises}
        yield f"symbols of {key}", content(model={**model, key: listed}, law=changed)
    free = [{**v, "range": None} for v in model["inputs"]]
    yield "free input", content(model={**model, "inputs": free})
    taken = {**model["parameters"], "rules": Number("1"), "x_rest": Number("2")}
    yield "taken names", content(model={**model, "parameters": taken})
    matrices = {"state_names": ["a [m]", "b"], "input_names": ["u [N]"]}
    two = {**law, **matrices}
    yield "no plant", content(model=matrices, law=two, own={**own, "states": [], "inputs": []})
    room = certificate("room")
    for side, other in (("low", Number("1")), ("high", Number("-1"))):
        blending = deepcopy(room["gains"]["blending"])
        blending[side]["direction"] = other
        blending[side]["range"] = None
        turned = {**room["gains"], "blending": blending}
        yield f"{side} turned", content(model=room["model"], law=turned, own=room["controller"])
    blending = deepcopy(room["gains"]["blending"])
    blending["low"]["error"] = blending["high"]["error"] = None
    turned = {**room["gains"], "blending": blending}
    yield "no errors", content(model=room["model"], law=turned, own=room["controller"])
    for key in ("states", "inputs"):
        short_of = {**own, key: own[key][:-1]}
        yield f"{key} that are one less", said_of_file({**data, "controller": short_of})
    for value in (Number("1.5"), "sqrt(2)", 0.1, 3, "2/3"):
        yield f"number {value!r}", (exact(value), short(exact(value)))


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    found: dict[str, Any] = {"programs": of_programs}
    for name, _ in documents():
        found[f"gain file, {name}"] = lambda name=name: of_gain_files(name)
    for name in ("step", "torque"):
        found[f"gain file of {name} changed"] = lambda name=name: of_gain_changes(name)
    for name in ("step", "room"):
        found[f"members of {name}"] = lambda name=name: of_gain_members(name)
    return found
