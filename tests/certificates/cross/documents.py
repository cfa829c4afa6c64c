"""Recorded certificates of every kind of claim about loops, and damaged ones."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from tests.certificates.kinds.claims import Data, resealed
from tests.certificates.recorded.answers import kinds, recorded

SHOWN = {"PROVED", "DISPROVED"}


def documents() -> dict[str, Data]:
    found = {}
    for kind in kinds():
        true = [text for answer, text in recorded(kind) if {facts[0] for facts in answer} <= SHOWN]
        for number, text in enumerate(true[:: (len(true) + 1) // 2 or 1]):
            found[f"{kind}-{number}"] = json.loads(text)
    return found


STRANGE: list[Any] = [None, True, "", "1", [], {}, [[]], [1], {"a": 1}, -1, 0, 1e-30, 1e30]


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if path:
        yield path
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from paths(value[key], (*path, key))


def damage(document: Data, path: tuple[Any, ...], rng: random.Random) -> None:
    place: Any = document
    for key in path[:-1]:
        place = place[key]
    before = place[path[-1]]
    way = rng.random()
    if way < 0.1:
        del place[path[-1]]
    elif way < 0.15 and isinstance(place, list):
        place.append(deepcopy(before))
    elif isinstance(before, (int, float)) and not isinstance(before, bool) and way < 0.7:
        place[path[-1]] = before * rng.choice([-1, 0, 0.5, 0.99, 1.01, 2, 1e6]) + rng.choice(
            [0, 0.1]
        )
    else:
        place[path[-1]] = deepcopy(rng.choice(STRANGE))


def mutants(whole: list[Data], count: int, seed: int) -> Iterator[tuple[str, Data]]:
    rng = random.Random(seed)
    for _ in range(count):
        document = deepcopy(rng.choice(whole))
        path = rng.choice([p for p in paths(document) if "provenance" not in p])
        damage(document, path, rng)
        yield f"{document.get('claims', [{}])!s:.60} {path}", resealed(document)
