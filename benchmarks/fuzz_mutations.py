"""Damage for certificates: of their tree, of the texts in it, of the file's characters."""

from __future__ import annotations

import random
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from takagi.certificates.checker.kernel.reader import Number, digest

Path = tuple[Any, ...]
NUMBERS = ["0", "-0", "1", "-1", "2", "3", "0.5", "1e-30", "1e30", "1e40", "-1e40", "1e-40", "1E+2"]
NUMBERS += ["9" * 60, "0." + "3" * 58, "1e41", "1e999999999", "-0.0", "12", "1000000", "80", "1e7"]
STRANGE: list[Any] = [None, True, False, "", "x", "1", "NaN", "\x00", "\u202e", "a" * 300, [], {}]
STRANGE += [[[]], [{}], {"": {}}, [Number("1")], [[Number("1")]], [[[Number("1")]]], "../x", "/dev"]
STRANGE += [[Number("1"), [Number("2")]], {"motion": [Number("1")]}, "disturbances", "inputs"]
TOKENS = ["sin(", "cos(", "tan(", "exp(", "log(", "sqrt(", "abs(", "min(", "atan2(", "(", ")", ","]
TOKENS += "+ - * / ^ ** **0.5 ^-1 ^99 ^1e9 0 1 1e99 pi e".split()
TOKENS += ["9" * 40, " ", ".", "_", "\n", "\t", "é", "x", "(" * 50, ")" * 50, "-" * 50, "1/0", "=="]
CHARACTERS = '{}[]",:0123456789.eE+-\\ \n\x00é\ud7ff tfn"'


def places(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the path of every part but the whole, leaves and branches alike."""
    if path:
        yield path
    if isinstance(value, dict):
        for key, part in value.items():
            yield from places(part, (*path, key))
    elif isinstance(value, list):
        for k, part in enumerate(value):
            yield from places(part, (*path, k))


def at(value: Any, path: Path) -> Any:
    for key in path:
        value = value[key]
    return value


def damaged_tree(tree: Any, other: Any, rng: random.Random) -> Any:
    """Return a copy with one to four changes; ``other`` lends parts of itself."""
    found = deepcopy(tree)
    for _ in range(rng.choice((1, 1, 1, 1, 2, 4))):
        paths = list(places(found))
        if not paths:
            return found
        path = _chosen(paths, found, rng)
        rng.choice(CHANGES)(found, path, other, rng)
    return found


def _chosen(paths: list[Path], tree: Any, rng: random.Random) -> Path:
    """Return a path; half the time by its name, so that long tables do not drown the rest."""
    if rng.random() < 0.5:
        return rng.choice(paths)
    names = {tuple(k for k in path if isinstance(k, str)): path for path in paths}
    name = rng.choice(list(names))
    return rng.choice([p for p in paths if tuple(k for k in p if isinstance(k, str)) == name])


def _replace(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    owner, before = at(tree, path[:-1]), at(tree, path)
    if isinstance(before, Number):
        owner[path[-1]] = _number(before, rng)
    elif isinstance(before, str):
        owner[path[-1]] = _written(before, rng)
    else:
        owner[path[-1]] = deepcopy(rng.choice(STRANGE))


def _strange(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    at(tree, path[:-1])[path[-1]] = deepcopy(rng.choice(STRANGE))


def _drop(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    del at(tree, path[:-1])[path[-1]]


def _double(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    owner = at(tree, path[:-1])
    if isinstance(owner, list):
        more = rng.choice((1, 1, 2, 9, 90))
        owner[path[-1] : path[-1]] = [deepcopy(owner[path[-1]]) for _ in range(more)]
    else:
        owner[rng.choice((*owner, *TOKENS))] = deepcopy(owner[path[-1]])


def _lend(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    lent = list(places(other))
    alike = [p for p in lent if p[-1] == path[-1]]
    at(tree, path[:-1])[path[-1]] = deepcopy(at(other, rng.choice(alike or lent)))


def _add(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    """Give an object a member that another one has."""
    owner = at(tree, path)
    if isinstance(owner, dict):
        named = [p for p in places(other) if isinstance(p[-1], str)]
        chosen = rng.choice(named)
        owner[chosen[-1]] = deepcopy(at(other, chosen))


def _swap(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    second = rng.choice(list(places(tree)))
    if path == second[: len(path)] or second == path[: len(second)]:
        return
    first, last = at(tree, path), at(tree, second)
    at(tree, path[:-1])[path[-1]] = last
    at(tree, second[:-1])[second[-1]] = first


def _deepen(tree: Any, path: Path, other: Any, rng: random.Random) -> None:
    owner = at(tree, path[:-1])
    for _ in range(rng.choice((1, 2, 45))):
        owner[path[-1]] = [owner[path[-1]]]


CHANGES = [_replace, _replace, _replace, _strange, _drop, _double, _lend, _add, _swap, _deepen]


def _number(before: str, rng: random.Random) -> Any:
    way = rng.random()
    if way < 0.4:
        return Number(rng.choice(NUMBERS))
    if way < 0.7:
        k = rng.randrange(len(before))
        after = before[:k] + rng.choice("0123456789") + before[k + 1 :]
        return Number(after) if before[k].isdigit() and _is_json(after) else Number("7")
    try:
        factor = rng.choice((-1, 0.5, 2, 0.999, 1.001, 10))
        return Number(repr(max(-1e39, min(1e39, float(before) * factor))))
    except (ValueError, OverflowError):
        return Number("0")


def _is_json(number: str) -> bool:
    digits = number.lstrip("-")
    return not (len(digits) > 1 and digits[0] == "0" and digits[1].isdigit())


def _written(before: str, rng: random.Random) -> str:
    """Change a text as if it were an expression."""
    way, k = rng.random(), rng.randint(0, len(before))
    if way < 0.5:
        return before[:k] + rng.choice(TOKENS) + before[k:]
    if way < 0.7:
        return before[:k] + before[min(len(before), k + rng.randint(1, 4)) :]
    if way < 0.8:
        return before * rng.choice((2, 3, 60))
    if way < 0.9:
        return rng.choice(("sin(", "(", "-(", "1/(", "sqrt(")) + before + ")"
    return rng.choice((*TOKENS, *(x for x in STRANGE if isinstance(x, str))))


def damaged_text(text: str, rng: random.Random) -> str:
    """Change characters of a file, or leave out, repeat or move some of them."""
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        k = rng.randint(0, len(text))
        size = rng.choice((1, 1, 2, 8, 100))
        way = rng.random()
        if way < 0.5:
            text = text[:k] + rng.choice(CHARACTERS) + text[k + rng.choice((0, 1)) :]
        elif way < 0.7:
            text = text[:k] + text[k + size :]
        elif way < 0.85:
            text = text[:k] + text[k : k + size] * rng.choice((2, 3, 50)) + text[k + size :]
        else:
            place = rng.randint(0, len(text))
            text = text[:k] + text[place : place + size] + text[k:]
    return text


def resealed(tree: Any) -> Any:
    """Return the tree with the hashes of what it now says."""
    if not isinstance(tree, dict):
        return tree
    hashes = {part: digest(tree.get(part)) for part in ("model", "gains", "claims")}
    return tree | {"provenance": {"sha256": hashes}}


def without_content(tree: Any) -> Any:
    """Return the tree without its copy of the model file, so that meanings are compared."""
    model = tree.get("model") if isinstance(tree, dict) else None
    if not isinstance(model, dict):
        return tree
    return tree | {"model": {key: part for key, part in model.items() if key != "model_file"}}
