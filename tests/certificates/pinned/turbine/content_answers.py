"""What a model's file says, where two contents differ, and files that are none."""

from __future__ import annotations

import hashlib
import json
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from takagi.certificates.checker.files import differences, model_content
from takagi.certificates.checker.files.given_files import unconnected
from takagi.certificates.checker.files.toml_file import read_toml
from takagi.certificates.checker.kernel.reader import Number
from tests.certificates.pinned.turbine.inputs import as_read
from tests.certificates.pinned.turbine.recorded_files import (
    PLANTS,
    TURBINES,
    answer,
    certificate,
    texts_of,
)
from tests.certificates.pinned.turbine.values import Named, said


def of_differences() -> Named:
    """Yield which parts of two values differ, and how values are told."""
    one = as_read({"a": [1, 2.0, {"b": "x"}], "c": True, "d": None, "e": {"f": 1e1}})
    for name, other in (
        ("same", {"a": [1.0, 2, {"b": "x"}], "c": True, "d": None, "e": {"f": 10}}),
        ("number", {"a": [1, 2.5, {"b": "x"}], "c": True, "d": None, "e": {"f": 10}}),
        ("text", {"a": [1, 2, {"b": "y"}], "c": False, "d": 0, "e": {"f": "10"}}),
        ("length", {"a": [1, 2], "c": 1, "d": {}, "e": []}),
        ("keys", {"e": {"g": 1}, "h": [1], "d\u00e9 \n": 1}),
        ("none", {}),
    ):
        read = as_read(other)
        found = [
            *differences.differences_between(one, read),
            *differences.differences_between(read, one),
        ]
        yield name, [(d.place, *differences.shown(d)) for d in found]
    for value in (
        *(None, "text", "\u00e9\n", True, Number("1.50"), {}, {"a": Number("1")}),
        *([], [Number("1")] * 3, [Number("1")] * 4, "x" * 60, "x" * 61, {"k": "y" * 99}),
    ):
        yield f"told {value!r:.30}", differences.in_words(value)


def of_long_texts() -> Named:
    """Yield how two values are told beside each other: what is about their first difference."""
    ends = ("", "b", "b" * 19, "b" * 21, "b" * 41, "b" * 100)
    for same in (0, 39, 40, 59, 60, 61, 200):
        for first, second in pairwise(ends):
            pair = differences.Difference(("x",), "a" * same + first, "a" * same + "c" + second)
            yield f"shown {same} {len(first)} {len(second)}", differences.shown(pair)
    alike: tuple[tuple[Any, Any], ...] = ((Number("1"), "1"), (True, "true"), (None, "nothing"))
    for one, other in alike:
        yield f"shown {one!r} {other!r}", differences.shown(differences.Difference((), one, other))


def of_contents(name: str) -> Named:
    """Yield what a model's file says, part by part."""
    texts = texts_of(name)
    more = "day = 2026-01-01\nbig = 9007199254740993\nmost = 9007199254740992\nx = 1e2\n"
    content = answer({}, {k: more * (k.endswith("toml")) + t for k, t in texts.items()},
                     lambda _, path: model_content.model_content(path))  # fmt: skip
    for key, part in content.items():
        yield key, json.dumps(part)


def of_words() -> Named:
    """Yield which texts are words, which are names of the user's, and links out of the folder."""
    text = """source = "a"
[states]
x = { description = "b", unit = "m", source = 1 }
[equations]
source = "c"
description = "d"
[mass]
x = { source = "e" }
[premises]
source = "f"
[tables]
t = { unit = "m" }
u = 1
"""
    content = answer({}, {"m.toml": text}, lambda _, path: model_content.model_content(path))
    yield "words", json.dumps(content)
    with TemporaryDirectory() as folder, TemporaryDirectory() as other:
        (Path(other) / "t.csv").write_text("1\n", encoding="utf-8")
        (Path(folder) / "t.csv").symlink_to(Path(other) / "t.csv")
        found = said(model_content.inside_folder, Path(folder) / "m.toml", "t.csv")
        yield "a link", str(found).replace(folder, "")


def of_owners() -> Named:
    """Yield which differences are beside the claims."""
    content = {"a": {"unit": "m", "value": "1"}, "b": {"unit": "m", "range": ["1"]}}
    model = {"kind": "plant", "model_file": {"a": {"unit": "s", "value": "1"}, "b": {"unit": "s"}}}
    values = ((None, "-"), ("-", None), ("1", "2"), (None, "2"), ("1", None))
    for path in (
        ("sample_time",), ("a", "unit"), ("b", "unit"), ("inputs", "u", "rest"),
        ("states", "x", "rest"), ("states", "x", "range", 0), ("states", "x", "more"),
        ("parameters", "k", "value"), ("parameters", "k"), ("equations", "x"),
        ("equations", "x", "unit"), ("mass", "x", "x"), ("outputs", "y", "unit"),
        ("outputs", "y", "expression"), ("blending", "effort", "rate"), ("blending", "effort", "x"),
        ("blending", "low", "error"), ("blending", "low", "x"), ("blending", "mid", "error"),
        ("design", "rate"), ("name",), ("rotor", "radius", "value"), ("rotor", "mass", "value"),
        ("generator", "torque_rate_limit", "value"), ("generator", "inertia"),
        ("frozen_wake", "wind", "values"), ("frozen_wake", "pitch", "values"),
    ):  # fmt: skip
        for kind, more, gains in (
            ("plant", {}, {}), ("turbine", {}, {}), ("turbine", {}, {"effectiveness_limit": 1}),
            ("turbine", {"torque_rate_limit": 1}, None),
        ):  # fmt: skip
            told = [
                model_content.beside_the_claims(
                    differences.Difference(path, *pair),
                    content,
                    model | more | {"kind": kind},
                    gains,
                )
                for pair in values
            ]
            yield f"{path} {kind} {sorted(more)} {gains}", told
    for name in (
        *("a.csv", "a/b.csv", "../a", "/a", "", ".", "a\\b", "c:d", "a\nb", 1, None, "a/../b"),
    ):
        yield f"inside {name!r}", said(_inside, name)
    for cell in ("1", " 2.50", "word", "", "1e3", "nan"):
        yield f"cell {cell!r}", model_content._cell(cell)


def _inside(name: Any) -> str:
    return model_content.inside_folder(Path("/nowhere/model.toml"), name).as_posix()


def of_sizes() -> Named:
    """Yield how files are read that are no TOML, or too large."""
    for name, text in (
        ("deep", "a = " + "[" * 2000 + "]" * 2000),
        ("no TOML", "a = "),
        ("64 parts", ".".join(["a"] * 64) + " = 1"),
        ("65 parts", ".".join(["a"] * 65) + " = 1"),
        ("large", "#" * 4_000_000),
        ("larger", "#" * 4_000_001),
        ("BOM", "\ufeffa = 1.5"),
        ("number", "a = 1e9999999"),
    ):
        found = answer({}, {"file.toml": text}, lambda _, p: read_toml(p, Decimal, what="file"))
        yield name, str(found)[:200]
    yield "no file", said(read_toml, Path("/nowhere/at/all"), Decimal, what="file")
    yield "a folder", said(read_toml, Path("/"), Decimal, what="file")


def of_companions() -> Named:
    """Yield what is said of other kinds of models, and of certificates of earlier versions."""
    data, texts = certificate("cart"), texts_of("cart")
    for name, model in (
        ("no kind", {}),
        ("hashes", {"files_sha256": {"cart.toml": "0"}}),
        ("a text", "model"),
    ):
        yield name, answer({**data, "model": model}, texts)
    yield "no model", answer({"claims": []}, texts)
    earlier = {**data, "model": {k: v for k, v in data["model"].items() if k != "model_file"}}
    yield "earlier", answer(earlier, texts)
    for owner in ("provenance", "model"):
        digest = hashlib.sha256(texts["cart.toml"].encode()).hexdigest()
        own = {**earlier[owner], "files_sha256": {"cart.toml": digest}}
        yield f"earlier, with its hash in {owner}", answer({**earlier, owner: own}, texts)
    own = {
        "files_sha256": {file: hashlib.sha256(texts[file].encode()).hexdigest() for file in texts}
    }
    yield "by all hashes", answer({**data, "model": own}, texts)
    room = certificate("room")
    yield "no blend claim", answer({**room, "claims": room["claims"][:1]}, texts_of("room"))
    for kinds in (("decay",), ("quadratic-decay", "decay", "no-common-quadratic"), ()):
        yield f"unconnected {kinds}", unconnected({"claims": [{"kind": k} for k in kinds]})


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    found: dict[str, Any] = {
        "differences": of_differences,
        "long texts": of_long_texts,
        "words of files": of_words,
        "beside the claims": of_owners,
        "sizes": of_sizes,
        "companions": of_companions,
    }
    for name in (*PLANTS, *TURBINES):
        found[f"content of {name}"] = lambda name=name: of_contents(name)
    return found
