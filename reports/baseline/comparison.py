"""Comparison of two certificates: every figure of the old one with that of the new one.

Claims are matched by kind and name, the others by kind and order.  Something got worse when

    a claim that was PROVED has no counterpart, is not PROVED now, or asks something else
    a figure changed to the worse by more than the tolerance times its old value
    winds that were covered are not, or a figure over the wind is worse at one of them
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.files.differences import (
    Difference,
    differences_between,
    in_words,
    shown,
)
from takagi.certificates.checker.files.model_content import beside_the_claims
from takagi.certificates.checker.kernel.reader import Number as FileNumber
from takagi.certificates.checker.kernel.reader import canonical, number
from takagi.certificates.checker.kernel.result import Checked, Claim, Verdict
from takagi.certificates.checker.replay.claim_kinds import class_of
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.reports.sections.plant.summary import SummaryRow

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
    for difference in differences_between(gains, new.get("gains")):
        yield _stated_change("gains", difference, gains)
    for section in ("configuration", "versions"):
        old_section, new_section = (_provenance(document, section) for document in (old, new))
        for difference in differences_between(old_section, new_section):
            yield _stated_change(section, difference, old_section)


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
        yield _stated_change("model", difference, old)
    old_content, new_content = (_content(model) for model in (old, new))
    if old_content and new_content:
        # Data that the model's other members do not contain, such as a tower's mass.
        for difference in differences_between(old_content, new_content):
            if (
                difference.path[0] not in _TOLD
                and difference.path[0] not in old
                and beside_the_claims(difference, old_content, old, None)
            ):
                yield _stated_change("model file", difference, old_content)


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


def _stated_change(section: str, difference: Difference, owner: Any) -> Change:
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
            winds = owner["wind"]
            inside = isinstance(winds, list) and -1 < k < len(winds)
            return f"{table} at wind {in_words(winds[k]) if inside else k + 1} m/s"
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
    named = isinstance(entry, str) and not isinstance(entry, FileNumber)
    return ascii(entry)[1:-1] if named else str(k + 1)


Data = Mapping[str, Any]
Number = Fraction | float
BOX = "box of validity"
# Members that bound a disturbance; which of them a claim has is a part of what it asks.
DISTURBANCE_BOUNDS = ("disturbance_bounds", "disturbance_norm")


@dataclass(frozen=True, slots=True)
class Moved:
    """One figure of both certificates.

    ``change``: relative to the old value, positive for better; infinite if the old value is 0 or
    missing.  ``place``: for a profile, the winds of this change.
    """

    claim: str
    figure: str
    unit: str
    old: Number
    new: Number
    change: Number
    worse: bool
    place: str = ""


@dataclass(frozen=True, slots=True)
class GainSize:
    """The largest size of one gain over the rules, in both laws: of an input by a state."""

    name: str
    old: float
    new: float

    @property
    def ratio(self) -> float | None:
        """new over old; None where the old gain is 0."""
        return self.new / self.old if self.old else None


@dataclass(frozen=True, slots=True)
class SummaryChange:
    """A row of the designs' summaries that differs, in both texts; "" for a missing one."""

    name: str
    old: str
    new: str


@dataclass(frozen=True, slots=True)
class CertificateComparison:
    """The result of comparing an old certificate with a new one.

    Attributes
    ----------
    tolerance : share by which a figure may get worse.
    moved : every figure that both have.
    lost : claim -> why it cannot be compared any more.
    added : names of claims that are new.
    changed : which parameters, gains and options differ.
    gains : sizes of the gains; empty if the laws are not by rules, or have other names.
    summary : what differs between the designs' summaries; empty for certificates alone.
    """

    tolerance: Fraction
    moved: tuple[Moved, ...]
    lost: Mapping[str, str]
    added: tuple[str, ...]
    changed: tuple[Change, ...]
    gains: tuple[GainSize, ...] = ()
    summary: tuple[SummaryChange, ...] = ()

    @property
    def passes(self) -> bool:
        """Whether nothing got worse by more than the tolerance."""
        return not self.lost and not any(figure.worse for figure in self.moved)


def compare_certificates(
    old: Data,
    new: Data,
    *,
    checked_old: Checked,
    checked_new: Checked,
    tolerance: Fraction = Fraction(1, 20),
) -> CertificateComparison:
    """Return the comparison of the old certificate's claims with the new ones.

    Parameters
    ----------
    old, new : documents as the strict reader returns them.
    checked_old, checked_new : the checker's answers to them: only what is PROVED counts.
    tolerance : share >= 0 of a figure's old value by which it may get worse.

    Raises
    ------
    ModelError : the certificates are about two plants.
    """
    _require_one_plant(old["model"], new["model"])
    old_claims, new_claims = _labelled(old, checked_old), _labelled(new, checked_new)
    pairs = _matched(list(old_claims), list(new_claims))
    compared, lost = list(_box_moved(old, new, tolerance)), {}
    for label, (claim, answer) in old_claims.items():
        if answer.verdict is not Verdict.PROVED:
            continue
        why, counterpart = _counterpart(claim, new_claims.get(pairs.get(label, ("", "", 0))))
        if counterpart is None:
            lost[_name(label)] = why
            continue
        theirs = {figure.name: figure for figure in counterpart.figures}
        for figure in answer.figures:
            compared.append(_moved(_name(label), figure, theirs.get(figure.name), tolerance))
    added = tuple(_name(label) for label in new_claims if label not in pairs.values())
    sizes = gain_sizes(old.get("gains"), new.get("gains"))
    return CertificateComparison(
        tolerance, tuple(compared), lost, added, tuple(changes(old, new)), sizes
    )


def summary_changes(
    old: Sequence[SummaryRow], new: Sequence[SummaryRow]
) -> tuple[SummaryChange, ...]:
    """Return the rows of two designs' summaries that differ, in the order of the new one."""
    # A law has a row of gains for each input, all of one name.
    before, after = (
        {row.name: "; ".join(r.text for r in rows if r.name == row.name) for row in rows}
        for rows in (old, new)
    )
    return tuple(
        SummaryChange(name, before.get(name, ""), after.get(name, ""))
        for name in {**after, **before}
        if before.get(name) != after.get(name)
    )


def _require_one_plant(old: Data, new: Data) -> None:
    """Refuse plants of two names, other than a plant that was renamed: signals as before."""
    names, signals = ([read(model) for model in (old, new)] for read in (plant_name, _signals))
    renamed = signals[0] == signals[1] and old.get("kind") != "turbine"
    if names[0] != names[1] and not renamed:
        raise ModelError(
            f"two plants were given, {names[0]} and {names[1]}; figures are compared of one plant, "
            "as it is and as it was: give two certificates of one"
        )


def plant_name(model: Data) -> str:
    """Return the name of a certificate's model; its states where it has none."""
    return str(model.get("name", f"a model of {', '.join(_signals(model)) or 'matrices'}"))


def _signals(model: Data) -> list[str]:
    listed = (*model.get("states", ()), *model.get("inputs", ()))
    named = [str(entry["name"]) for entry in listed if isinstance(entry, Mapping)]
    return named or [str(name) for name in model.get("state_names", ())]


def gain_sizes(old: Any, new: Any) -> tuple[GainSize, ...]:
    """Return the sizes of the gains of two laws by rules; () for laws of other names or kinds."""
    laws = [law for law in (old, new) if isinstance(law, Mapping) and _is_list(law.get("K"))]
    named = [[law.get("input_names"), law.get("state_names")] for law in laws]
    if len(laws) < 2 or named[0] != named[1] or not all(map(_is_list, named[0])):
        return ()
    inputs, states = (list(names or ()) for names in named[0])
    gains = []
    for k, row in enumerate(inputs):
        for j, column in enumerate(states):
            sizes = [max(abs(float(str(K[k][j]))) for K in law["K"]) for law in laws]
            gains.append(GainSize(f"{row} by {column}", *sizes))
    return tuple(gains)


def _is_list(value: Any) -> bool:
    return isinstance(value, list)


Label = tuple[str, str, int]


def _labelled(document: Data, checked: Checked) -> dict[Label, tuple[Data, Claim]]:
    """Return the claims by kind, name, and which of those of that name it is."""
    labelled: dict[Label, tuple[Data, Claim]] = {}
    for claim, answer in zip(document["claims"], checked.claims, strict=True):
        kind, name = str(claim["kind"]), str(claim["name"])
        k = next(k for k in range(len(labelled) + 1) if (kind, name, k) not in labelled)
        labelled[kind, name, k] = claim, answer
    return labelled


def _matched(old: Sequence[Label], new: Sequence[Label]) -> dict[Label, Label]:
    """Return old label -> new label: the same one, else the next of its kind that is left."""
    pairs = {label: label for label in old if label in new}
    unpaired = [label for label in new if label not in pairs]
    for label in old:
        if label in pairs:
            continue
        chosen = next((candidate for candidate in unpaired if candidate[0] == label[0]), None)
        if chosen is not None:
            pairs[label] = chosen
            unpaired.remove(chosen)
    return pairs


def _name(label: Label) -> str:
    kind, name, k = label
    return f"{name} ({k + 1})" if k else name or kind


def _counterpart(claim: Data, new: tuple[Data, Claim] | None) -> tuple[str, Claim | None]:
    if new is None:
        return "the new certificate has no such claim", None
    counterpart, answer = new
    if answer.verdict is not Verdict.PROVED:
        return f"was PROVED, is {answer.verdict.name}", None
    if _question(counterpart) != _question(claim):
        return "the claim of the new certificate asks something else", None
    return "", answer


def _question(claim: Data) -> str:
    """Return what a claim is about as one text; only figures with equal texts are compared."""
    keys = class_of(str(claim["kind"])).asks
    members = {key: claim[key] for key in keys if key in claim}
    return canonical({"asked": members, "bounds": [k for k in DISTURBANCE_BOUNDS if k in claim]})


def _box_figures(model: Data) -> Iterator[Figure]:
    """Yield the ends of the box of a model or plant; a wider box is a stronger claim."""
    if model.get("kind") == "plant":
        groups = (model.get(key, []) for key in ("states", "inputs", "disturbances"))
        sides = {v["name"]: (v.get("range"), v.get("unit", "")) for group in groups for v in group}
    else:
        sides = {name: (side, "") for name, side in model.get("box", {}).items()}
    for name, (side, unit) in sides.items():
        if side is None:
            yield Figure(f"{name}, lower end", unit, None, larger=False)
            yield Figure(f"{name}, upper end", unit, None)
            continue
        # A text such as "5/6" stands where no decimal is exact.
        low, high = (
            Fraction(end) if isinstance(end, str) else number({"range": end}, "range", name)
            for end in side
        )
        yield Figure(f"{name}, lower end", unit, low, larger=False, span=high - low)
        yield Figure(f"{name}, upper end", unit, high, span=high - low)


def _box_moved(old: Data, new: Data, tolerance: Fraction) -> Iterator[Moved]:
    old_figures, new_figures = (
        {f.name: f for f in _box_figures(document["model"])} for document in (old, new)
    )
    for name in {**old_figures, **new_figures}:
        # A variable without a range in one of them is unbounded there.
        ours, theirs = old_figures.get(name), new_figures.get(name)
        ours, theirs = ours or _unbounded(theirs), theirs or _unbounded(ours)
        yield _moved(BOX, ours, theirs, tolerance)


def _unbounded(figure: Figure | None) -> Figure:
    assert figure is not None
    return Figure(figure.name, figure.unit, None, figure.larger)


def _moved(
    claim: str, old: Figure | WindProfile, new: Figure | WindProfile | None, tolerance: Fraction
) -> Moved:
    """Return one row; a missing figure counts as worse than every value."""
    if isinstance(old, WindProfile):
        spans = new.spans if isinstance(new, WindProfile) else ()
        rows = [
            (_change(value, theirs, None), winds, value, theirs)
            for winds, value, theirs in _over_wind(old, spans)
        ]
        change, winds, value, theirs = min(rows, key=lambda row: row[0])
        worse = change < -tolerance
        return Moved(claim, old.name, old.unit, value, theirs, change, worse, winds)
    worst = -inf if old.larger else inf
    theirs = _number(new) if isinstance(new, Figure) else worst
    change = _change(_number(old), theirs, old.span, larger=old.larger)
    return Moved(claim, old.name, old.unit, _number(old), theirs, change, change < -tolerance)


def _number(figure: Figure) -> Number:
    """Return a figure's value; infinite where it has no bound."""
    return figure.value if figure.value is not None else inf if figure.larger else -inf


def _over_wind(
    old: WindProfile, spans: Sequence[tuple[Fraction, Fraction, Fraction]]
) -> Iterator[tuple[str, Fraction, Number]]:
    """Yield each old span with the least new value over it; -inf where winds are not covered."""
    for low, high, value in old.spans:
        over = [span for span in spans if span[0] < high and span[1] > low]
        covered = low
        for first, last, _ in over:
            if first <= covered:
                covered = max(covered, last)
        lowest = min((theirs for *_, theirs in over), default=-inf)
        where = f"{float(low):g} to {float(high):g} m/s"
        yield where, value, lowest if covered >= high else -inf


def _change(old: Number, new: Number, span: Fraction | None, *, larger: bool = True) -> Number:
    """Return the change relative to the old value, or to ``span``; positive for better."""
    if old == new:
        return Fraction(0)
    gain: Number = new - old if larger else old - new
    if not (isinstance(gain, Fraction) and isinstance(old, Fraction)):
        return inf if gain > 0 else -inf
    size = abs(old) if span is None else span
    if size == 0:
        return inf if gain > 0 else -inf
    return gain / size
