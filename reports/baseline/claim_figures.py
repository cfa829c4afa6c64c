r"""The numbers that show whether a claim is stronger than another of its kind.

Read from the numbers of the file that the checker has proved, exactly.  Of an ellipsoid
{x'Px <= c} they are

    volume                      rounded down, as the checker shows it
    safe start of x_k           sqrt(c / P_kk), the largest x_k in it with the others at rest

Where a figure depends on the wind it is a ``Profile``: one number for each span of winds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from takagi.certificates.checker.kernel.definite import is_positive_definite
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import canonical, matrix, number, numbers
from takagi.certificates.checker.words.ellipsoid_size import (
    LARGEST,
    square_root_below,
    volume_below,
)


@dataclass(frozen=True, slots=True)
class ClaimFigure:
    """One number that is better when it is larger, or smaller.

    ``span``: the reference of a relative change; None for the number itself.
    """

    name: str
    unit: str
    value: Fraction | float
    larger: bool = True
    span: Fraction | None = None


@dataclass(frozen=True, slots=True)
class Profile:
    """A number for each span (low, high) of winds [m/s]; larger is better."""

    name: str
    unit: str
    spans: tuple[tuple[Fraction, Fraction, Fraction], ...]


Found = ClaimFigure | Profile
Data = Mapping[str, Any]
Reading = Callable[[Data, Data], Iterator[Found]]


def claim_figures(claim: Data, document: Data) -> tuple[Found, ...]:
    """Return the figures of a claim; none for a kind that has none.

    Parameters
    ----------
    claim, document : as the strict reader returns them, accepted by the checker.
    """
    kind = str(claim["kind"])
    found: list[Found] = []
    for key, unit, larger, name in _MEMBERS.get(kind, ()):
        found += _of(claim, key, unit, larger=larger, name=name)
    return (*found, *(_READINGS[kind](claim, document) if kind in _READINGS else ()))


def question(claim: Data) -> str:
    """Return what a claim is about as one text; only figures with equal texts are compared."""
    keys = _QUESTIONS.get(str(claim["kind"]), ())
    asked = {key: claim[key] for key in keys if key in claim}
    return canonical({"asked": asked, "bounded": sorted(k for k in _BOUNDS if k in claim)})


def box_figures(model: Data) -> Iterator[ClaimFigure]:
    """Yield the ends of the box of a model or plant; a wider box is a stronger claim."""
    if model.get("kind") == "plant":
        groups = (model.get(key, []) for key in ("states", "inputs", "disturbances"))
        sides = {v["name"]: (v.get("range"), v.get("unit", "")) for group in groups for v in group}
    else:
        sides = {name: (side, "") for name, side in model.get("box", {}).items()}
    for name, (side, unit) in sides.items():
        if side is None:
            yield ClaimFigure(f"{name}, lower end", unit, -inf, larger=False)
            yield ClaimFigure(f"{name}, upper end", unit, inf)
            continue
        low, high = (_end(end, name) for end in side)
        yield ClaimFigure(f"{name}, lower end", unit, low, larger=False, span=high - low)
        yield ClaimFigure(f"{name}, upper end", unit, high, span=high - low)


def _end(end: Any, name: str) -> Fraction:
    """Return an end of a range: a number, or a text such as "5/6" where no decimal is exact."""
    return Fraction(end) if isinstance(end, str) else number({"range": end}, "range", name)


def _of(claim: Data, key: str, unit: str, *, larger: bool, name: str = "") -> Iterator[ClaimFigure]:
    """Yield one member of the claim, or each entry of a row."""
    if claim.get(key) is None:
        return
    words = name or key.replace("_", " ")
    if isinstance(claim[key], list):
        for k, value in enumerate(numbers(claim, key, key)):
            yield ClaimFigure(f"{words} {k + 1}", unit, value, larger)
    else:
        yield ClaimFigure(words, unit, number(claim, key, key), larger)


def _weight_rates(claim: Data, document: Data) -> Iterator[Found]:
    for k, row in enumerate(claim.get("rates", [])):
        name = f"rates of weights {k + 1}"
        if row is None:
            yield ClaimFigure(name, "1/s", inf)
        else:
            yield ClaimFigure(name, "1/s", min(numbers({"row": row}, "row", name)))


def _rounding(claim: Data, document: Data) -> Iterator[Found]:
    least = min(min(row) for row in matrix(claim, "absolute", "absolute"))
    yield ClaimFigure("absolute rounding of gains, least", "", least)


def _ellipsoid(claim: Data, document: Data) -> Iterator[Found]:
    P, level = matrix(claim, "P", "P"), number(claim, "level", "level")
    if not is_positive_definite(P) or level <= 0:
        return
    if len(P) <= LARGEST:
        yield ClaimFigure("volume of the set", "", volume_below(Matrix.of(P), level))
    for k, (name, unit) in enumerate(_states(document, len(P))):
        yield ClaimFigure(
            f"safe start of {name}, others at rest", unit, square_root_below(level / P[k][k])
        )
    yield from _of(claim, "disturbance_bounds", "", larger=True, name="bound on disturbance")
    yield from _of(claim, "disturbance_norm", "", larger=True, name="bound on disturbance")


def _inputs(claim: Data, document: Data) -> Iterator[Found]:
    yield from _ellipsoid(claim, document)
    yield from _of(claim, "input_limits", "", larger=False, name="limit of input")
    yield from _of(claim, "rate_limits", "", larger=False, name="limit of rate of input")


def _states(document: Data, count: int) -> list[tuple[str, str]]:
    model = document["model"]
    if model.get("kind") == "plant":
        return [(str(s["name"]), str(s.get("unit", ""))) for s in model["states"]]
    named = model.get("state_names", [f"x{k + 1}" for k in range(count)])
    return [(str(name), "") for name in named]


def _effort_sharing(claim: Data, document: Data) -> Iterator[Found]:
    cells, gains = claim["cells"], document["gains"]
    yield from _of(claim["settling"], "decay_rate", "1/s", larger=True, name="common decay rate")
    for key, unit in (("wind_error", "m/s"), ("wind_rate", "m/s^2"), ("decay_rate", "1/s")):
        words = key.replace("_", " ")
        yield Profile(words, unit, _spans(cells, key))
    fastest = max(numbers(gains, "rotor_speed", "gains"))
    peak = number(claim["peaks"], "speed_error", "peaks")
    rated = number(document["model"], "rated_rotor_speed", "model")
    yield ClaimFigure("overspeed", "-", (fastest + peak) / rated - 1, larger=False)
    low, high = numbers(claim["uncertainty"], "inertia", "uncertainty", 2)
    yield ClaimFigure("inertia, lower end", "of nominal", low, larger=False)
    yield ClaimFigure("inertia, upper end", "of nominal", high)
    frozen = bool(claim["uncertainty"]["frozen_wake"])
    yield ClaimFigure("frozen wake included", "", Fraction(frozen))


def _wind_rate(claim: Data, document: Data) -> Iterator[Found]:
    for place, one in enumerate(claim["ranges"], start=1):
        wind, rate = (numbers(one, key, key) for key in ("wind", "estimate_rate"))
        spans = zip(wind, wind[1:], map(min, rate, rate[1:]), strict=False)
        yield Profile(f"rate of the wind, range {place}", "m/s^2", tuple(spans))
        known = f"error of the estimate, range {place}"
        yield from _of(one, "estimate_error", "m/s", larger=True, name=known)


def _running_loop(claim: Data, document: Data) -> Iterator[Found]:
    yield from _of(claim, "decay_rate", "1/s", larger=True, name="decay rate with the observer")
    covered = sum((high - low for low, high, _ in _boxes(claim)), Fraction(0))
    yield ClaimFigure("winds covered with the observer", "m/s", covered)
    yield Profile("box of the wind estimate", "m/s", _boxes(claim))


def _boxes(claim: Data) -> tuple[tuple[Fraction, Fraction, Fraction], ...]:
    cells: list[Data] = [{"wind": cell["wind"], **cell["sides"]} for cell in claim["cells"]]
    return _spans(cells, "estimate")


def _actuator_rates(claim: Data, document: Data) -> Iterator[Found]:
    yield from _of(claim, "torque_step", "N m", larger=False)
    for name, unit in (("pitch_rate", "rad/s"), ("torque_rate", "N m/s")):
        largest = max(number(cell, name, name) for cell in claim["cells"])
        yield ClaimFigure(f"largest {name.replace('_', ' ')}", unit, largest, larger=False)


def _published(claim: Data, document: Data) -> Iterator[Found]:
    yield from _of(claim, "speed_overlap", "rad/s", larger=True)
    yield from _of(claim, "torque_overlap", "N m", larger=True)
    yield Profile("decay rate", "1/s", _spans(claim["cells"], "decay_rate"))


def _spans(cells: list[Data], key: str) -> tuple[tuple[Fraction, Fraction, Fraction], ...]:
    found = ((*numbers(cell, "wind", "wind", 2), number(cell, key, key)) for cell in cells)
    return tuple(sorted((low, high, value) for low, high, value in found))


# Kind -> members that are figures: key, unit, whether larger is better, and the name of another.
_DECAY = ("decay_rate", "1/s", True, "")
_ENERGY = (("gain", "-", False, ""), ("energy_bound", "-", True, ""))
_MEMBERS: dict[str, tuple[tuple[str, str, bool, str], ...]] = {
    "decay": (_DECAY,),
    "observer": (_DECAY,),
    "observed-feedback": (_DECAY,),
    "fuzzy-decay": (_DECAY,),
    "transient": (_DECAY, ("overshoot", "-", False, ""), ("settling_time", "s", False, "")),
    "gain-rounding": (_DECAY, ("relative", "-", True, "relative rounding of gains")),
    "l2-gain": _ENERGY,
    "fuzzy-l2-gain": _ENERGY,
    "h2-norm": (("norm", "-", False, ""),),
    "peak": (("gain", "-", False, ""), ("disturbance_norm", "", True, "bound on disturbance")),
    "exit-probability": (
        ("probability", "-", False, "probability of leaving the set"),
        ("horizon", "s", True, ""),
    ),
    "sampled-loop": (_DECAY, ("sample_time", "s", True, "")),
}
# Kind -> its further figures.
_READINGS: dict[str, Reading] = {
    "fuzzy-decay": _weight_rates,
    "gain-rounding": _rounding,
    "fuzzy-l2-gain": _weight_rates,
    "invariant-ellipsoid": _ellipsoid,
    "input-limits": _inputs,
    "coherent-loop": _effort_sharing,
    "paper-loop": _published,
    "wind-rate": _wind_rate,
    "actuator-rates": _actuator_rates,
    "running-loop": _running_loop,
}
# Members that bound a disturbance; which of them are present is a part of the question.
_BOUNDS = ("disturbance_bounds", "disturbance_norm")
_QUESTIONS = {
    "region": ("parts",),
    "transient": ("scales", "settled_share"),
    "l2-gain": ("disturbance", "output"),
    "h2-norm": ("disturbance", "output"),
    "peak": ("disturbance", "output"),
    "exit-probability": ("disturbance", "noise", "start"),
    "invariant-ellipsoid": ("disturbance",),
    "input-limits": ("disturbance",),
}
