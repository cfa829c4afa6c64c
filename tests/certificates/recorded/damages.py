"""Certificates that are proved, with one entry changed and hashes that fit, and the answers to it.

``damaged/<kind>.jsonl`` holds a certificate in its first line, in the second the answers, and after
them a line for each change: the place of an entry, what stands there then, and which answer it
gets.  An entry becomes zero, its negative, a little more, a little less, a word in the place of a
number, or it is left out; an equation loses a sign.  Or a line holds several changes that make one
forged certificate, which answer it gets, what it is, and words that its answer has to have.

``python -m tests.certificates.recorded.damages`` writes the answers of today, as ``answers`` does.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.checker.replay import certificate
from tests.certificates.recorded.answers import FOLDER, Answer, facts_of, taken

DAMAGED = FOLDER / "damaged"
# In the place of a value: the entry is left out.
LEFT_OUT = "(left out)"
PARTS = ("model", "gains", "claims")
Place = list[str | int]
Changes = list[tuple[Place, Any]]


class Damage(NamedTuple):
    changes: Changes
    answer: Answer
    what: str = ""
    words: str = ""


def names() -> list[str]:
    return sorted(path.stem for path in DAMAGED.glob("*.jsonl"))


def damages(name: str) -> tuple[dict[str, Any], list[Damage]]:
    first, second, *lines = (DAMAGED / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()
    answers = json.loads(second)
    found = [_read(json.loads(line), answers) for line in lines]
    return read_text(first, "certificate"), found


def _read(line: list[Any], answers: list[Answer]) -> Damage:
    if isinstance(line[0][0], list):
        changed, number, *words = line
        return Damage([(place, value) for place, value in changed], answers[number], *words)
    place, value, number = line
    return Damage([(place, value)], answers[number])


def answer_to(document: dict[str, Any], changed: Changes, said: list[str] | None = None) -> Answer:
    """Return the answer to the certificate with these values, and hashes that fit."""
    data = _damaged(document, changed)
    return facts_of(lambda: _checked(data), "FILE", said)


def _checked(data: dict[str, Any]) -> Any:
    certificate._require_whole(data, "FILE")
    return certificate._replayed(data, "FILE", [], certificate.exact_decider)


def _damaged(document: dict[str, Any], changed: Changes) -> dict[str, Any]:
    """Return a copy of what stands above the places, and all else as it is."""
    whole = {**document}
    for place, value in changed:
        holder: Any = whole
        for step in place[:-1]:
            inner = holder[step]
            holder[step] = {**inner} if isinstance(inner, dict) else [*inner]
            holder = holder[step]
        if value == LEFT_OUT:
            del holder[place[-1]]
        else:
            # Numbers are read as those of a file are.
            holder[place[-1]] = read_text(json.dumps({"": value}), "value")[""]
    parts = {str(place[0]) for place, _ in changed} & {*PARTS, *_hashes(document)}
    if parts:
        new = {part: digest(whole.get(part)) for part in parts}
        whole["provenance"] = {**whole["provenance"], "sha256": {**_hashes(whole), **new}}
    return whole


def _hashes(document: dict[str, Any]) -> dict[str, Any]:
    return dict(document["provenance"]["sha256"])


def changes(value: Any) -> Iterator[Any]:
    if isinstance(value, bool) or value is None:
        yield from (LEFT_OUT, "word")
    elif isinstance(value, (int, float)):
        yield from (0, -value or -1, value + 1, round(value * 1.01, 12), round(value * 0.99, 12))
        yield from ("word", LEFT_OUT)
    elif isinstance(value, str):
        yield from ("word", LEFT_OUT)
        for old, new in (("+", "-"), ("-", "+"), ("*", "/"), ("^", "*"), ("(", "(1 + ")):
            if old in value:
                yield value.replace(old, new, 1)
    else:
        yield from ([], LEFT_OUT, 0)


def line(damage: Damage, number: int) -> str:
    if damage.what:
        return json.dumps([damage.changes, number, damage.what, damage.words])
    ((place, value),) = damage.changes
    return json.dumps([place, value, number])


def main() -> None:
    for name in names():
        path = DAMAGED / f"{name}.jsonl"
        first = path.read_text(encoding="utf-8").splitlines()[0]
        document, listed = damages(name)
        answers: list[Answer] = []
        lines = []
        for damage in listed:
            answer = taken(damage.answer, answer_to(document, damage.changes), str(damage))
            if answer not in answers:
                answers.append(answer)
            lines.append(line(damage, answers.index(answer)))
        path.write_text("\n".join([first, json.dumps(answers), *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
