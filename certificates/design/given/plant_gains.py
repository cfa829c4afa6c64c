"""Existing gains: the law of a gain file, for the plant that it was made for."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.files.gain_file import stated_law
from takagi.certificates.checker.kernel.matrices import read_stack
from takagi.certificates.checker.kernel.reader import Number, read_json
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel

NAME = "pdc"
LONGEST = 120  # the most characters of a value in a message


def read_gains(path: Path, model: TSModel) -> Floats:
    """Return K (r, m, n) of a gain file whose law belongs to this model.

    Names, premises with their bounds, rules, trim and sample time of the law must be the model's,
    number by number. With other values the same gains would give another law.

    Raises
    ------
    CertificateError : unreadable, not strict JSON, without a law, a law of another kind or of
        another model, gains of the wrong shape.
    """
    source, law = str(path), read_plant_law(path)
    stack = read_stack(law, "K", f"{source}: law")
    K = np.array([_floats(matrix) for matrix in stack])
    r, n, m = model.B.shape
    if K.shape[0] not in (1, r) or K.shape[1:] != (m, n):
        raise CertificateError(
            f"{source}: law.K has shape {K.shape}; {r} rules, {m} inputs and {n} states need "
            f"({r}, {m}, {n}), or (1, {m}, {n}) for one gain in all rules"
        )
    K = np.array(np.broadcast_to(K, (r, m, n)))
    try:
        wanted = ClaimedLoop.of(model, K, model_data=plant_and_claim(model)[0]).gains_data
    except ModelError as error:
        raise CertificateError(f"{source}: law.K: {error}") from error
    _compare(law, wanted or {}, source)
    return K


def _compare(law: Mapping[str, Any], wanted: Mapping[str, Any], source: str) -> None:
    for key in sorted(set(law) | set(wanted)):
        if key == "K" or _exact(law.get(key)) == _exact(wanted.get(key)):
            continue
        raise CertificateError(
            f"{source}: law.{key} is not the model's: the file has {_short(law.get(key))}, the "
            f"model {_short(wanted.get(key))}; design the gains anew, or give the plant file and "
            "the options that they were made with"
        )


def read_plant_law(path: Path) -> Mapping[str, Any]:
    """Return the law of a plant's gain file, its numbers as they are written.

    Raises
    ------
    CertificateError : unreadable, not strict JSON, without a law, or a law of another kind.
    """
    source = str(path)
    law = stated_law(read_json(path), source)
    if not isinstance(law, Mapping) or law.get("name") != NAME:
        shown = ascii(law.get("name")) if isinstance(law, Mapping) else "no object"
        raise CertificateError(
            f"{source}: law.name is {shown}; the model is a plant, whose laws are {NAME!r}: give "
            "the gain file that 'takagi design' wrote for this plant"
        )
    read_stack(law, "K", f"{source}: law")
    return law


def _floats(matrix: Any) -> list[list[float]]:
    rows, columns = matrix.shape
    return [[float(matrix[i, j]) for j in range(columns)] for i in range(rows)]


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
