"""What is known of broken lines: a journal while a campaign runs, and a file of results after it.

The journal has a line of JSON for each change, so that a run that ends early goes on where it was.
The results are kept with the project: a line for each function, with a mark for each of its
changes: ``n`` noticed, ``s`` survives, ``.`` not tried.  A function that was edited has another
digest, and its changes are tried anew.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from line_changes import Change, module_name

NOTICED, SURVIVES, UNTRIED = "n", "s", "."


class Entry(NamedTuple):
    """One change that was tried."""

    key: str
    mark: str
    place: str
    what: str
    by: str
    how: str
    ran: int
    seconds: float


class Journal:
    """All marks by key: the results of earlier campaigns, and the journals of this one."""

    def __init__(self, results: Path, folder: Path, shard: str) -> None:
        self.results, self.folder = results, folder
        self.own = folder / f"journal-{shard}.jsonl"
        self.marks: dict[str, str] = dict(_read_results(results))
        self.read()

    def read(self) -> None:
        """Take over what the journals hold: a copy of this process may have added to them."""
        for entry in self.entries():
            self.marks[entry.key] = entry.mark

    def entries(self) -> Iterator[Entry]:
        """Yield what the journals hold, later ones of the same change too."""
        for path in sorted(self.folder.glob("journal-*.jsonl")):
            for line in path.read_text(encoding="utf-8").splitlines():
                yield Entry(**json.loads(line))

    def add(self, entry: Entry) -> None:
        """Write one line, whole."""
        self.marks[entry.key] = entry.mark
        self.folder.mkdir(parents=True, exist_ok=True)
        with self.own.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry._asdict()) + "\n")

    def keep(self, changes: Iterable[Change]) -> None:
        """Write the results of all that is known about the changes that there are."""
        marks: dict[str, str] = {}
        for change in changes:
            name = change.key.rpartition(" ")[0]
            marks[name] = marks.get(name, "") + self.marks.get(change.key, UNTRIED)
        lines = [f"{name} {row}" for name, row in sorted(marks.items()) if set(row) != {UNTRIED}]
        beside = self.results.with_suffix(".new")
        beside.write_text("\n".join(lines) + "\n", encoding="utf-8")
        beside.replace(self.results)


def _read_results(path: Path) -> Iterator[tuple[str, str]]:
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        name, _, row = line.rpartition(" ")
        yield from ((f"{name} {k}", mark) for k, mark in enumerate(row) if mark != UNTRIED)


class Explained:
    """Why changes that survive do no harm: a sentence each, by module, function and change."""

    def __init__(self, path: Path) -> None:
        self.said: dict[str, dict[str, str]] = tomllib.loads(path.read_text(encoding="utf-8"))
        self.path = path

    def why(self, change: Change) -> str:
        """Return the sentence, or nothing."""
        return self.said.get(f"{module_name(change.module)}.{change.owner}", {}).get(
            change.what, ""
        )
