"""Which parameters, gains and options differ between two certificates, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from takagi.certificates.checker.files.differences import (
    Difference,
    differences_between,
    in_words,
    shown,
)
from takagi.certificates.checker.files.model_content import beside_the_claims
from takagi.certificates.checker.kernel.reader import Number

Data = Mapping[str, Any]
MOST_LISTED = 8
# Members that follow from other parts of the model; reported only if nothing else differs.
_DERIVED = ("embedding", "torque_surface", "A", "B", "C", "D", "E")
# Bytes and content of the files: bytes are ignored, the content is compared separately.
_CONTENT = "model_file"
_FILES = ("files_sha256", _CONTENT)
_TOLD = ("design",)  # under ``configuration``


@dataclass(frozen=True, slots=True)
class Change:
    """One difference: of ``model``, ``gains``, ``configuration`` or ``versions``; where, and how.

    ``old`` and ``new`` are short texts.
    """

    part: str
    place: str
    old: str
    new: str


def changes(old: Data, new: Data) -> Iterator[Change]:
    """Yield what differs, numbers compared as they are written.

    old, new : certificates as the strict reader returns them.
    """
    yield from _of_model(old["model"], new["model"])
    gains = old.get("gains")
    for difference in differences_between(gains, new.get("gains")):
        yield _change("gains", difference, gains)
    for section in ("configuration", "versions"):
        old_section, new_section = (_provenance(document, section) for document in (old, new))
        for difference in differences_between(old_section, new_section):
            yield _change(section, difference, old_section)


def listed_changes(changed: Sequence[Change]) -> list[str]:
    """Return a line for each change; of each part the first ones, then how many more."""
    lines = []
    for section in dict.fromkeys(change.part for change in changed):
        section_changes = [change for change in changed if change.part == section]
        lines += [
            f"{section}: {c.place}: {c.old} -> {c.new}" for c in section_changes[:MOST_LISTED]
        ]
        if len(section_changes) > MOST_LISTED:
            lines.append(f"{section}: and {len(section_changes) - MOST_LISTED} more")
    return lines


def _of_model(old: Any, new: Any) -> Iterator[Change]:
    differences = list(differences_between(_without(old, _FILES), _without(new, _FILES)))
    first = [
        difference
        for difference in differences
        if not difference.path or difference.path[0] not in _DERIVED
    ]
    # Two models of matrices alone differ in nothing but these.
    for difference in first or differences:
        yield _change("model", difference, old)
    old_content, new_content = (_content(model) for model in (old, new))
    if old_content and new_content:
        # Data that the model's other members do not contain, such as a tower's mass.
        for difference in differences_between(old_content, new_content):
            if (
                difference.path[0] not in _TOLD
                and difference.path[0] not in old
                and beside_the_claims(difference, old_content, old, None)
            ):
                yield _change("model file", difference, old_content)


def _content(model: Any) -> dict[str, Any]:
    content = model.get(_CONTENT) if isinstance(model, dict) else None
    return content if isinstance(content, dict) else {}


def _without(model: Any, members: Sequence[str]) -> Any:
    if not isinstance(model, dict):
        return model
    return {key: value for key, value in model.items() if key not in members}


def _provenance(document: Data, section: str) -> Any:
    provenance = document.get("provenance")
    return provenance.get(section) if isinstance(provenance, Mapping) else None


def _change(section: str, difference: Difference, owner: Any) -> Change:
    location = _place(difference.path, owner) or "all of it"
    return Change(section, location, *shown(difference))


def _place(path: tuple[str | int, ...], owner: Any) -> str:
    """Return where in the gains or the model: by rule, input, state and wind where it has them."""
    match path:
        case ("K", int(rule), int(row), int(column)) if isinstance(owner, Mapping):
            u, x = _entry(owner.get("input_names"), row), _entry(owner.get("state_names"), column)
            return f"K of rule {rule + 1}, {u} by {x}"
        case ("equations", int(k)) if isinstance(owner, Mapping):
            return f"equation of {_entry(owner.get('states'), k)}"
        case (str(table), int(k)) if isinstance(owner, Mapping) and "wind" in owner:
            return f"{table} at wind {_wind(owner['wind'], k)} m/s"
    words = []
    for key in path:
        inner = _entry(owner, key) if isinstance(key, int) else ascii(key)[1:-1]
        words.append(inner)
        try:
            owner = owner[key]
        except (KeyError, IndexError, TypeError):
            owner = None
    return ".".join(words)


def _entry(listed: Any, k: int) -> str:
    """Return what an entry of a list is called: its text or name, else its number."""
    if not isinstance(listed, list) or not -1 < k < len(listed):
        return str(k + 1)
    entry = listed[k]
    if isinstance(entry, Mapping):
        entry = entry.get("name")
    named = isinstance(entry, str) and not isinstance(entry, Number)
    return ascii(entry)[1:-1] if named else str(k + 1)


def _wind(winds: Any, k: int) -> str:
    return in_words(winds[k]) if isinstance(winds, list) and -1 < k < len(winds) else str(k + 1)
