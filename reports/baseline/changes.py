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

    Parameters
    ----------
    old, new : certificates as the strict reader returns them.
    """
    yield from _of_model(old["model"], new["model"])
    gains = old.get("gains")
    for found in differences_between(gains, new.get("gains")):
        yield _change("gains", found, gains)
    for part in ("configuration", "versions"):
        before, after = (_provenance(document, part) for document in (old, new))
        for found in differences_between(before, after):
            yield _change(part, found, before)


def listed_changes(found: Sequence[Change]) -> list[str]:
    """Return a line for each change; of each part the first ones, then how many more."""
    lines = []
    for part in dict.fromkeys(change.part for change in found):
        own = [change for change in found if change.part == part]
        lines += [f"{part}: {c.place}: {c.old} -> {c.new}" for c in own[:MOST_LISTED]]
        if len(own) > MOST_LISTED:
            lines.append(f"{part}: and {len(own) - MOST_LISTED} more")
    return lines


def _of_model(old: Any, new: Any) -> Iterator[Change]:
    found = list(differences_between(_without(old, _FILES), _without(new, _FILES)))
    first = [one for one in found if not one.path or one.path[0] not in _DERIVED]
    # Two models of matrices alone differ in nothing but these.
    for one in first or found:
        yield _change("model", one, old)
    before, after = (_content(model) for model in (old, new))
    if before and after:
        # Data that the model's other members do not contain, such as a tower's mass.
        for one in differences_between(before, after):
            if (
                one.path[0] not in _TOLD
                and one.path[0] not in old
                and beside_the_claims(one, before, old, None)
            ):
                yield _change("model file", one, before)


def _content(model: Any) -> dict[str, Any]:
    found = model.get(_CONTENT) if isinstance(model, dict) else None
    return found if isinstance(found, dict) else {}


def _without(model: Any, members: Sequence[str]) -> Any:
    if not isinstance(model, dict):
        return model
    return {key: value for key, value in model.items() if key not in members}


def _provenance(document: Data, part: str) -> Any:
    provenance = document.get("provenance")
    return provenance.get(part) if isinstance(provenance, Mapping) else None


def _change(part: str, found: Difference, owner: Any) -> Change:
    place = _place(found.path, owner) or "all of it"
    return Change(part, place, *shown(found))


def _place(path: tuple[str | int, ...], owner: Any) -> str:
    """Return where in the gains or the model: by rule, input, state and wind where it has them."""
    match path:
        case ("K", int(rule), int(row), int(column)) if isinstance(owner, Mapping):
            inputs, states = (_name(owner, key, k) for key, k in
                              (("input_names", row), ("state_names", column)))  # fmt: skip
            return f"K of rule {rule + 1}, {inputs} by {states}"
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


def _name(owner: Data, key: str, k: int) -> str:
    return _entry(owner.get(key), k)


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
