"""Certificates that are proved, with one entry changed and hashes that fit, and the answers to it.

``damaged/<kind>.jsonl`` holds a certificate in its first line, and after it a line for each change:
the place of an entry, what stands there then, and the answer.  An entry becomes zero, its
negative, a little more, a little less, a word in the place of a number, or it is left out; an
equation loses a sign.

``python -m tests.certificates.recorded.damages`` writes the answers of today, as ``answers`` does.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from takagi.certificates.checker.kernel.reader import digest, read_text
from tests.certificates.recorded.answers import FOLDER, Answer, answer_of

DAMAGED = FOLDER / "damaged"
# In the place of a value: the entry is left out.
LEFT_OUT = "(left out)"
Place = list[str | int]
Damage = tuple[Place, Any, Answer]


def names() -> list[str]:
    """Return the names of the certificates that are damaged."""
    return sorted(path.stem for path in DAMAGED.glob("*.jsonl"))


def damages(name: str) -> tuple[dict[str, Any], list[Damage]]:
    """Return the certificate, and each change of it with its answer."""
    first, *lines = (DAMAGED / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()
    found: list[Damage] = [
        (place, value, answer) for place, value, answer in map(json.loads, lines)
    ]
    return json.loads(first), found


def damaged(document: dict[str, Any], place: Place, value: Any) -> str:
    """Return the certificate as text with this value there, and hashes that fit."""
    document = deepcopy(document)
    holder: Any = document
    for step in place[:-1]:
        holder = holder[step]
    if value == LEFT_OUT:
        del holder[place[-1]]
    else:
        holder[place[-1]] = value
    hashes = document["provenance"]["sha256"]
    read = read_text(json.dumps(document), "certificate")
    for part in hashes:
        hashes[part] = digest(read.get(part))
    return json.dumps(document)


def changes(value: Any) -> Iterator[Any]:
    """Yield what may stand in the place of an entry."""
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


def main() -> None:
    """Write the answers of today."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        for name in names():
            document, listed = damages(name)
            lines = [json.dumps(document)]
            for place, value, _ in listed:
                answer = answer_of(damaged(document, place, value), path)
                lines.append(json.dumps([place, value, answer]))
            (DAMAGED / f"{name}.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
