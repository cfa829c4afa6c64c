"""Modes of a vertex that no input moves, or that no output shows."""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.models.errors import ModelError


def check_stabilisable(
    A: Array,
    B: Array,
    *,
    units: Array,
    names: tuple[str, ...] = (),
    dual: bool = False,
    step: float | None = None,
) -> None:
    """Raise ModelError for a vertex with an undamped eigenvalue that no input can move.

    Undamped: Re >= 0, or |z| >= 1 in discrete time.

    Parameters
    ----------
    A, B : in states and inputs of order one, x = units xhat, so that rounding means something.
    names : of the states; x1, x2, ... when empty.
    dual : write the message about outputs and observation instead.
    step : sample time T in s of a discrete-time model; None for continuous time.
    """
    mode = fixed_mode(A, B, 0.0, step=step)
    if mode is None:
        return
    vertex, eigenvalue, direction = mode
    labels = names or tuple(f"x{k}" for k in range(1, A.shape[1] + 1))
    state_shares = [
        f"{weight:+.3g} * {label}"
        for weight, label in zip(direction / units, labels, strict=True)
        # Smaller parts of the direction are rounding, and would only confuse the message.
        if abs(weight) > 1e-6 * np.abs(direction / units).max()
    ]
    verb, need = ("be seen in no output", "C") if dual else ("be moved by no input", "B")
    where = "" if step is None else ", not inside the unit circle,"
    raise ModelError(
        f"vertex {vertex + 1} of {len(A)}: the mode at {_number(eigenvalue)}{where} "
        f"({' '.join(state_shares)}) does not decay and can {verb}; change {need} or the box, so "
        "that it decays or can be reached"
    )


def fixed_mode(
    A: Array, B: Array, decay_rate: float, *, step: float | None = None
) -> tuple[int, complex, Array] | None:
    """Return (vertex, eigenvalue, left eigenvector) that no input moves, Re >= -decay_rate.

    By the Popov-Belevitch-Hautus test, [A - lambda I, B] without full rank, in floating point;
    None when none exists.

    Parameters
    ----------
    step : sample time T in s of x+ = A x + B u, whose eigenvalues count when |z| >=
        e^(-decay_rate T); None for continuous time.
    """
    A, B = A.astype(np.float64), B.astype(np.float64)
    for vertex, (vertex_matrix, reach) in enumerate(zip(A, B, strict=True)):
        size = float(np.abs(vertex_matrix).max()) or 1.0
        reach = reach * (size / (np.abs(reach).max() or 1.0))
        eigenvalues = np.linalg.eigvals(vertex_matrix)
        for eigenvalue in _with_means(eigenvalues, size):
            if step is None:
                # An eigenvalue exactly at the limit does not decay fast enough, whichever way it is
                # rounded.
                slow = eigenvalue.real >= -decay_rate - 1e-12 * size
            else:
                slow = abs(eigenvalue) >= np.exp(-decay_rate * step) - 1e-12 * size
            direction = (
                _unmoved(vertex_matrix - eigenvalue * np.eye(len(vertex_matrix)), reach, size)
                if slow
                else None
            )
            if direction is not None:
                return vertex, complex(eigenvalue), direction
    return None


def _number(eigenvalue: complex) -> str:
    return f"{eigenvalue:.6g}" if eigenvalue.imag else f"{eigenvalue.real:.6g}"


def _with_means(eigenvalues: Array, size: float) -> list[complex]:
    """Return the eigenvalues, those near one another as their mean first.

    A multiple eigenvalue is computed as several that are off by a root of the rounding error;
    their mean is not.
    """
    values: list[complex] = []
    for eigenvalue in eigenvalues:
        cluster = eigenvalues[np.abs(eigenvalues - eigenvalue) <= 1e-5 * size]
        mean = complex(cluster.mean())
        # Of a real matrix a cluster that is its own mirror image has a real mean.
        if abs(mean.imag) <= 1e-14 * size:
            mean = complex(mean.real, 0.0)
        values += [mean, complex(eigenvalue)] if len(cluster) > 1 else [complex(eigenvalue)]
    return values


def _unmoved(shifted: Array, reach: Array, size: float) -> Array | None:
    """Return the real direction v with v' [A - lambda I, B] = 0, to rounding; None if none."""
    left_vectors, singular, _ = np.linalg.svd(np.concatenate([shifted, reach], axis=1))
    if singular[-1] > 1e-10 * size:
        return None
    v = left_vectors[:, -1].conj()
    return np.asarray(np.real(v / v[np.argmax(np.abs(v))]))
