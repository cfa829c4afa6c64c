"""Existing gains of a plant: the law of a gain file, of states or of measured outputs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.files.gain_file import stated_law
from takagi.certificates.checker.kernel.reader import (
    Number,
    member,
    read_json,
    read_matrix,
    read_stack,
)
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.controller.content import read_gain_file
from takagi.certificates.design.plant.tracking_design import with_ranges
from takagi.certificates.document.model_data import floats, stack_of
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.tracking import observer_data
from takagi.models.arrays import Floats
from takagi.models.equilibrium_line import ConstantObserver
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    from takagi.certificates.design.plant.observed_design import ObservedWork
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

NAME = "pdc"
LONGEST = 120  # the most characters of a value in a message


def read_gains(path: Path, model: TSModel, *, any_trim: bool = False) -> Floats:
    """Return K (r, m, n) of a gain file whose law belongs to this model.

    Names, premises with their bounds, rules, trim and sample time of the law must be the model's,
    number by number. With other values the same gains would give another law.

    ``any_trim`` : accept another trim: the plant has changed, and the law shall rest where the
    plant rests now.

    Raises
    ------
    CertificateError : unreadable, not strict JSON, without a law, a law of another kind or of
        another model, gains of the wrong shape.
    """
    source, law = str(path), read_plant_law(path)
    K = _gains(law, model, source)
    compare_law(law, _law_of(model, K, source), source, any_trim=any_trim)
    return K


def _gains(law: Mapping[str, Any], model: TSModel, source: str) -> Floats:
    """Return K (r, m, n); one gain for all rules is repeated."""
    K = stack_of(read_stack(law, "K", f"{source}: law"))
    r, n, m = model.B.shape
    if K.shape[0] not in (1, r) or K.shape[1:] != (m, n):
        raise CertificateError(
            f"{source}: law.K has shape {K.shape}; {r} rules, {m} inputs and {n} states need "
            f"({r}, {m}, {n}), or (1, {m}, {n}) for one gain in all rules"
        )
    return np.array(np.broadcast_to(K, (r, m, n)))


def _law_of(model: TSModel, K: Floats, source: str) -> Mapping[str, Any]:
    """Return the law that a model has with these gains."""
    try:
        loop = ClaimedLoop.of(model, K, model_data=plant_and_claim(model)[0])
    except ModelError as error:
        raise CertificateError(f"{source}: law.K: {error}") from error
    return loop.gains_data or {}


def compare_law(
    law: Mapping[str, Any], law_of_model: Mapping[str, Any], source: str, *, any_trim: bool
) -> None:
    """Refuse a law that differs in more than K (and trim, if ``any_trim``); names the member."""
    for key in sorted((set(law) | set(law_of_model)) - ({"K", "trim"} if any_trim else {"K"})):
        if _exact(law.get(key)) == _exact(law_of_model.get(key)):
            continue
        raise CertificateError(
            f"{source}: law.{key} is not the model's: the file has {_short(law.get(key))}, the "
            f"model {_short(law_of_model.get(key))}; design the gains anew, or give the plant file "
            "and the options that they were made with"
        )


def read_plant_law(path: Path) -> Mapping[str, Any]:
    """Return the law of a plant's gain file, its numbers as they are written.

    Raises
    ------
    CertificateError : unreadable, of a later version, without a law, or a law of another kind.
    """
    source = str(path)
    law = stated_law(read_gain_file(path), source)
    if not isinstance(law, Mapping) or law.get("name") != NAME:
        name = ascii(law.get("name")) if isinstance(law, Mapping) else "no object"
        raise CertificateError(
            f"{source}: law.name is {name}; the model is a plant, whose laws are {NAME!r}: give "
            "the gain file that 'takagi design' wrote for this plant"
        )
    read_stack(law, "K", f"{source}: law")
    return law


def in_ranges_of(path: Path, plant: Plant) -> Plant:
    """Return the plant with the ranges of states in a gain file, where they are narrower."""
    stated = read_json(path)
    listed = stated.get("states") if isinstance(stated, Mapping) else None
    states = {v.name: v for v in plant.states}
    narrower = {}
    for entry in listed if isinstance(listed, list) else []:
        if not isinstance(entry, Mapping):
            continue
        name, ends = entry.get("name"), entry.get("range")
        if not isinstance(name, str) or name not in states:
            continue
        side = states[name].range
        if side is None or not isinstance(ends, list) or [*map(type, ends)] != [Number, Number]:
            continue
        low, high = map(Fraction, ends)
        if side.lower <= low < high <= side.upper:
            narrower[name] = replace(states[name], range=Interval(low, high))
    return with_ranges(plant, narrower)


def _exact(value: Any) -> Any:
    """Return the value with its numbers as rationals: 0.10 and 1e-1 are the same number."""
    if isinstance(value, Mapping):
        return {key: _exact(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_exact(inner) for inner in value]
    if isinstance(value, Number):
        return Fraction(value)
    if isinstance(value, float | int) and not isinstance(value, bool):
        return Fraction(repr(value))
    return value


def _short(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value, default=str)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."


def read_observer_gains(
    path: Path, work: ObservedWork, *, any_trim: bool = False
) -> tuple[Floats, Floats]:
    """Return K (r, m, n) and L (r or 1, n, p) of a gain file for this plant.

    ``any_trim`` : as of ``read_gains``.

    Raises
    ------
    CertificateError : the file is unreadable, or its law uses all states, other outputs or weights,
        or belongs to another plant.
    """
    source, law = str(path), read_plant_law(path)
    if "integrators" in law:
        order = len(law["integrators"])
        raise CertificateError(
            f"{source}: its law is a controller with {order} states of its own; give --controller "
            f"order={order}, or write controller = {{ order = {order} }} in the plant's file"
        )
    if "observer" not in law:
        raise CertificateError(
            f"{source}: its law has all states, but the plant measures "
            f"{', '.join(work.base.task.plant.measured or ())}; design the gains anew, or leave "
            "out 'measured'"
        )
    where = f"{source}: law"
    K = _gains(law, work.base.task.model, source)
    L = stack_of(read_stack(member(law, "observer", where), "L", f"{where}.observer"))
    (r, _, n), p = K.shape, len(work.rows)
    if L.shape[0] not in (1, r) or L.shape[1:] != (n, p):
        raise CertificateError(f"{where}.observer.L has shape {L.shape}; ({r}, {n}, {p}) is needed")
    try:
        law_of_model = work.loop(K, L).gains_data
    except (ModelError, CertificateError) as error:
        raise CertificateError(f"{where}: {error}") from error
    compare_law(law, law_of_model or {}, source, any_trim=any_trim)
    return K, L


def read_reference_gains(
    path: Path, plant: Plant, model: TSModel
) -> tuple[Floats, ConstantObserver]:
    """Return K (r, m, n) and the observer of a gain file for a plant with references.

    Raises
    ------
    CertificateError : the file is unreadable, its law has all states, other outputs or matrices of
        another shape, or belongs to another plant.
    """
    source, law = str(path), read_plant_law(path)
    where, rows = f"{source}: law", plant.measured_rows
    stated_observer = law.get("observer")
    if not isinstance(stated_observer, Mapping) or stated_observer.get("weights") != "constant":
        raise CertificateError(
            f"{source}: its law has no observer with constant matrices, but the plant measures "
            f"{', '.join(plant.measured or ())} and follows a reference; design the gains anew"
        )
    K = _gains(law, model, source)
    n, m, p = len(plant.own_states), K.shape[1], len(rows)
    shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "L": (n, p)}
    matrices = {
        key: floats(read_matrix(stated_observer, key, f"{where}.observer", shape))
        for key, shape in shapes.items()
    }
    observer = ConstantObserver(**matrices, measured=plant.measured or ())
    law_of_model = {**_law_of(model, K, source), **observer_data(observer)}
    compare_law(law, law_of_model, source, any_trim=False)
    return K, observer
