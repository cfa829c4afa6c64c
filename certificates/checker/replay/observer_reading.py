"""Reading of the observer in a certificate's gains, for the loop of model and gains."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.observer_law import ObserverLaw
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, at

MEASURED, ESTIMATED = "measured", "estimated"


def observed_by(loop: PolytopicLoop, model: Any, gains: Any) -> PolytopicLoop:
    """Return the loop with the observer of ``gains.observer``, and with its measured outputs only.

    Raises
    ------
    CertificateError : an output that the model does not have, gains L of another shape, weights at
        the estimate without the slopes of a plant.
    """
    observer, where = gains["observer"], "gains.observer"
    weights = reader.text(observer, "weights", where)
    if weights not in (MEASURED, ESTIMATED):
        raise CertificateError(f"{where}.weights: {MEASURED!r} or {ESTIMATED!r} is needed")
    rows = measured_outputs(observer, model, where)
    L = read_stack(observer, "L", where)
    at_estimate = weights == ESTIMATED
    count = 1 if at_estimate else loop.rules
    if L[0].shape != (loop.order, len(rows)) or len(L) not in (1, count):
        raise CertificateError(
            f"{where}.L: {loop.order} by {len(rows)} is needed, one matrix"
            + ("" if at_estimate else f" or {count}")
        )
    slopes = _slopes(loop, model, rows, where) if at_estimate else ()
    C, D = (tuple(_rows(M, rows) for M in stack) for stack in (loop.C, loop.D))
    return replace(loop, C=C, D=D, observer=ObserverLaw(L, at_estimate, slopes))


def measured_outputs(observer: Any, model: Any, where: str) -> list[int]:
    """Return the indices of the measured outputs among the outputs of the model.

    Raises
    ------
    CertificateError : a name that is not one output, or is there twice.
    """
    plant = reader.text(model, "kind", "model") == "plant"
    names = reader.member(model, "outputs" if plant else "output_names", "model")
    measured = reader.member(observer, "measured", where)
    if (
        not isinstance(measured, list)
        or not measured
        or len(set(map(str, measured))) != len(measured)
    ):
        raise CertificateError(f"{where}.measured: different names of outputs are needed")
    if not isinstance(names, list):
        names = []
    if plant:
        names = [y.get("name") if isinstance(y, dict) else None for y in names]
    for name in measured:
        if not isinstance(name, str) or names.count(name) != 1:
            raise CertificateError(f"{where}.measured: {name!a} is not one output of the model")
    return [names.index(name) for name in measured]


def _rows(matrix: Matrix, rows: list[int]) -> Matrix:
    return Matrix([list(matrix.rows[k]) for k in rows], matrix.below)


def _slopes(
    loop: PolytopicLoop, model: Any, rows: list[int], where: str
) -> tuple[tuple[Matrix, Matrix], ...]:
    """Return the vertices of the slopes of equations and measured outputs by the state."""
    if reader.text(model, "kind", "model") != "plant" or "slopes" not in model:
        raise CertificateError(f"{where}: weights at the estimate need model.slopes of a plant")
    # Imported here: a law without an observer at its estimate needs no slopes.
    from takagi.certificates.checker.plant.slope_embedding import slope_loop

    slopes = slope_loop(model)
    if slopes.order != loop.order or not slopes.C:
        raise CertificateError("model.slopes: those of all states and outputs are needed")
    return tuple((at(slopes.A, k), _rows(at(slopes.C, k), rows)) for k in range(slopes.rules))
