"""Differences between a plant and the plant of a gain file, item by item, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.reader import Number
from takagi.models.errors import did_you_mean
from takagi.models.plant.file_units import file_unit

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

# Numbers in files are short decimals; a relative difference below this counts as none.
_SAME = 1e-12


def misfits(law: Mapping[str, Any], wanted: Mapping[str, Any]) -> list[str]:
    """Return why a law cannot be used for a plant: states, inputs, units, sample time, rest.

    Parameters
    ----------
    law, wanted : the ``law`` of the gain file, and that of the present plant with any gains.
    """
    found: list[str] = []
    for key, what in (("state_names", "state"), ("input_names", "input")):
        ours, theirs = (
            [str(label) for label in one.get(key) or []] if isinstance(one.get(key), list) else []
            for one in (law, wanted)
        )
        found += _labels(ours, theirs, what)
    old, new = law.get("sample_time"), wanted.get("sample_time")
    if not _same(old, new):
        found.append(
            f"the gains are for {_time(old)}, the plant is in {_time(new)}: design gains for it"
        )
    return found


def changes_of_signals(plant: Plant, file: Mapping[str, Any], trim: Mapping[str, Any]) -> list[str]:
    """Return ranges, rests and units in which a plant differs from the one of its gain file.

    Parameters
    ----------
    file : the whole gain file, as the strict reader returns it.
    trim : where the plant rests: lists ``state`` and ``input``, SI.

    Figures are in the units of the plant's file.
    """
    rests = [*(trim.get("state") or []), *(trim.get("input") or [])]
    own = [*plant.states, *plant.inputs]
    known = {v.name: (v, float(str(rest))) for v, rest in zip(own, rests, strict=False)}
    known |= {v.name: (v, float(v.rest)) for v in plant.disturbances}
    found: list[str] = []
    for key in ("states", "inputs", "signals"):
        listed = file.get(key)
        for entry in listed if isinstance(listed, list) else []:
            if isinstance(entry, Mapping) and str(entry.get("name")) in known:
                variable, rest = known[str(entry["name"])]
                found += _changed(variable, rest, entry)
    return found


def _labels(old: list[str], new: list[str], what: str) -> Iterator[str]:
    """Yield the states or inputs that differ; labels have the form ``angle [rad]``."""
    before, after = (dict(label.partition(" [")[::2] for label in one) for one in (old, new))
    if old and before and list(before) != list(after) and set(before) == set(after):
        yield (
            f"the {what}s stand in another order: {', '.join(before)} there, {', '.join(after)} "
            "here; write them in the old order"
        )
    for name in before:
        if name not in after:
            yield (
                f"the gains need the {what} {name}, which the plant does not have"
                f"{did_you_mean(name, after)}: give the {what} its old name, or design gains anew"
            )
        elif before[name] != after[name]:
            yield (
                f"{what} {name} is in {before[name].rstrip(']')} there and in "
                f"{after[name].rstrip(']')} here: its gains mean something else; correct the unit"
            )
    for name in after:
        if name not in before:
            yield (
                f"the plant has the {what} {name}, for which there are no gains: design gains anew"
            )


def _changed(variable: Variable, rest: float, entry: Mapping[str, Any]) -> Iterator[str]:
    size, unit = file_unit(variable)
    behind = "" if unit in ("", "-") else f" {unit}"
    if str(entry.get("unit")) != variable.unit:
        yield (f"{variable.name}: the unit was {entry.get('unit')}, it is {variable.unit} now (SI)")
        return
    old = entry.get("rest")
    if _is_number(old) and not _same(float(str(old)), rest):
        yield (
            f"{variable.name}: rest {float(str(old)) / size:.6g}{behind} -> "
            f"{rest / size:.6g}{behind}"
        )
    before, after = _ends(entry.get("range"), size), _range(variable, size)
    if before != after:
        yield f"{variable.name}: range {_shown(before)}{behind} -> {_shown(after)}{behind}"


def _ends(stated: Any, size: float) -> tuple[str, str] | None:
    if not isinstance(stated, list) or len(stated) != 2 or not all(map(_is_number, stated)):
        return None
    low, high = (f"{float(str(end)) / size:.6g}" for end in stated)
    return low, high


def _range(variable: Variable, size: float) -> tuple[str, str] | None:
    side = variable.range
    return None if side is None else (
        f"{float(side.lower) / size:.6g}", f"{float(side.upper) / size:.6g}",
    )  # fmt: skip


def _shown(ends: tuple[str, str] | None) -> str:
    return "none" if ends is None else f"[{ends[0]}, {ends[1]}]"


def _time(step: Any) -> str:
    return "continuous time" if step is None else f"samples of {float(str(step)):g} s"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | Number) and not isinstance(value, bool)


def _same(first: Any, second: Any) -> bool:
    if not (_is_number(first) and _is_number(second)):
        return bool(first == second)
    one, two = float(str(first)), float(str(second))
    return abs(one - two) <= _SAME * max(abs(one), abs(two), 1.0)
