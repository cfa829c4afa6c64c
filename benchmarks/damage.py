"""One small change anywhere in a certificate: a digit, sign, bit, bound, rule, unit, word.

The place is drawn branch by branch, so that long matrices do not outweigh short fields; the change
fits what stands there.  Numbers are the text they are written as, so that one digit is one digit.
"""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from takagi.certificates.checker.kernel.reader import Number, canonical, digest, read_text

Data = dict[str, Any]
Place = tuple[Any, ...]
PARTS = ("model", "gains", "claims")
SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "^": "*", "(": ")", ".": "", " ": ""}
FUNCTIONS = {"sin": "cos", "cos": "sin", "tan": "sin", "tanh": "atan", "exp": "cos", "sqrt": "exp"}
UNITS = ("deg", "rad", "mm", "m", "s", "ms", "kN", "N", "-", "rpm", "rad/s", "m/s")


def as_written(document: Mapping[str, Any]) -> Data:
    """Return a document with its numbers as text, as the checker's reader has it."""
    return read_text(json.dumps(document), "document")


def text_of(document: Data) -> str:
    """Return the JSON of a document as written."""
    return canonical(document)


def resealed(document: Data) -> Data:
    """Return the document with the hashes of what it now says: what a forger would do."""
    hashes = {part: digest(document.get(part)) for part in PARTS}
    return document | {"provenance": {**document["provenance"], "sha256": hashes}}


def mutant(document: Data, rng: random.Random) -> tuple[Place, str, Data] | None:
    """Return (place, what was done, mutant); None where the change changes nothing."""
    place: list[Any] = [rng.choice([part for part in PARTS if document.get(part) is not None])]
    value = document[place[0]]
    while isinstance(value, (dict, list)) and value and (len(place) < 2 or rng.random() > 0.06):
        key = rng.choice(sorted(value)) if isinstance(value, dict) else rng.randrange(len(value))
        place.append(key)
        value = value[key]
    changed = deepcopy(document)
    owner = changed
    for key in place[:-1]:
        owner = owner[key]
    what = _changed(owner, place[-1], rng)
    if canonical(changed) == canonical(document):
        return None
    return tuple(place), what, changed


def _changed(owner: Any, key: Any, rng: random.Random) -> str:
    value = owner[key]
    if isinstance(value, Number):
        what, owner[key] = _number(value, rng)
    elif isinstance(value, str):
        what, owner[key] = _text(value, rng)
    elif isinstance(value, list) and value:
        what = _list(value, rng)
    elif isinstance(value, dict) and len(value) > 1:
        first, second = rng.sample(sorted(value), 2)
        if rng.random() < 0.5:
            value[first], value[second] = value[second], value[first]
            what = "members exchanged"
        else:
            del value[first]
            what = "member left out"
    else:
        owner[key] = Number("1") if value is None else None
        what = "value replaced"
    return what


def _number(value: Number, rng: random.Random) -> tuple[str, Number]:
    way = rng.choice(("digit", "digit", "last digit", "sign", "bit", "power of ten", "factor"))
    if way == "digit":
        places = [i for i, c in enumerate(value) if c.isdigit()]
        i = rng.choice(places)
        digit = rng.choice([d for d in "0123456789" if d != value[i]])
        return "digit", _valid(value[:i] + digit + value[i + 1 :], value)
    if way == "last digit":
        mantissa, e, exponent = value.partition("e")
        whole, point, places_text = mantissa.partition(".")
        scaled = str(int(whole + places_text) + rng.choice((-1, 1)))
        sign, scaled = ("-", scaled[1:]) if scaled.startswith("-") else ("", scaled)
        scaled = scaled.rjust(len(places_text) + 1, "0")
        cut = len(scaled) - len(places_text)
        return way, _valid(sign + scaled[:cut] + point + scaled[cut:] + e + exponent, value)
    if way == "sign":
        return way, Number(value[1:] if value.startswith("-") else "-" + value)
    if way == "bit":
        bits = struct.unpack("<q", struct.pack("<d", float(value)))[0] ^ (1 << rng.randrange(56))
        return way, _valid(repr(struct.unpack("<d", struct.pack("<q", bits))[0]), value)
    if way == "power of ten":
        return way, _valid(repr(float(value) * rng.choice((0.1, 10.0))), value)
    factor = rng.choice((0.0, 0.5, 0.9, 0.99, 0.999, 1.001, 1.01, 1.1, 2.0))
    return "factor", _valid(repr(float(value) * factor), value)


def _valid(written: str, otherwise: Number) -> Number:
    """Return a number that JSON takes, or the one before."""
    try:
        json.loads(written)
    except ValueError:
        return otherwise
    return Number(written)


def _text(value: str, rng: random.Random) -> tuple[str, str]:
    for name, other in FUNCTIONS.items():
        if name + "(" in value and rng.random() < 0.3:
            return "function", value.replace(name + "(", other + "(", 1)
    if " [" in value and rng.random() < 0.5 or value in UNITS:
        head, bracket, _ = value.partition(" [")
        unit = rng.choice(UNITS)
        return "unit", f"{head} [{unit}]" if bracket else unit
    if not value:
        return "word", "x"
    i = rng.randrange(len(value))
    c = value[i]
    if c.isdigit():
        other = rng.choice([d for d in "0123456789" if d != c])
        return "digit in an expression", value[:i] + other + value[i + 1 :]
    other = SWAPPED.get(c, rng.choice("xyzuvwab"))
    return "character", value[:i] + other + value[i + 1 :]


def _list(value: list[Any], rng: random.Random) -> str:
    way = rng.random()
    if len(value) > 1 and way < 0.6:
        i, j = rng.sample(range(len(value)), 2)
        value[i], value[j] = value[j], value[i]
        return "entries exchanged"
    if way < 0.8:
        del value[rng.randrange(len(value))]
        return "entry left out"
    value.append(deepcopy(rng.choice(value)))
    return "entry doubled"
