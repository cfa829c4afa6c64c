"""Existing gains of a law with measured outputs: K and L of a gain file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.checker.kernel.matrices import read_stack
from takagi.certificates.checker.kernel.reader import member
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.design.given.plant_gains import compare_law, floats_of, read_plant_law
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.plant.observed_design import ObservedWork


def read_observer_gains(path: Path, work: ObservedWork) -> tuple[Floats, Floats]:
    """Return K (r, m, n) and L (r or 1, n, p) of a gain file for this plant.

    Raises
    ------
    CertificateError : the file is unreadable, or its law uses all states, other outputs or weights,
        or belongs to another plant.
    """
    source, law = str(path), read_plant_law(path)
    if "observer" not in law:
        raise CertificateError(
            f"{source}: its law has all states, but the plant measures "
            f"{', '.join(work.question.measured)}; design the gains anew, or leave out 'measured'"
        )
    where = f"{source}: law"
    K, L = (
        np.array([floats_of(matrix) for matrix in read_stack(owner, key, place)])
        for owner, key, place in (
            (law, "K", where),
            (member(law, "observer", where), "L", f"{where}.observer"),
        )
    )
    r, n, m = work.model.B.shape
    p = len(work.question.rows)
    if K.shape[0] not in (1, r) or K.shape[1:] != (m, n):
        raise CertificateError(f"{where}.K has shape {K.shape}; ({r}, {m}, {n}) is needed")
    if L.shape[0] not in (1, r) or L.shape[1:] != (n, p):
        raise CertificateError(f"{where}.observer.L has shape {L.shape}; ({r}, {n}, {p}) is needed")
    K = np.array(np.broadcast_to(K, (r, m, n)))
    try:
        wanted = work.loop(K, L).gains_data
    except (ModelError, CertificateError) as error:
        raise CertificateError(f"{where}: {error}") from error
    compare_law(law, wanted or {}, source)
    return K, L
