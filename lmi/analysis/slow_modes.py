"""Single vertices that decay too slowly: an answer "no" without a solver.

The error of a computed eigenvalue is the rounding error times its condition number. For a loop with
gains of 1e5 that can be more than the decay rate. If an eigenvalue is that near to its limit, the
exact coefficients of the characteristic polynomial decide, by Routh's table.

Source: Golub and Van Loan (2013), Matrix Computations, section 7.2.2 (condition of an eigenvalue);
Gantmacher (1959), The Theory of Matrices, volume 2, chapter XV (Routh).
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.argument_checks import rate_parameter
from takagi.models.arrays import Floats

# Number of vertices that are examined, slowest first; the others are left to the solver.
MOST_VERTICES = 8
# The rounding error of an eigenvalue is at most this many times norm, condition number and epsilon.
ROUNDING = 8.0


def slow_vertex(
    A: Floats, alpha: float, *, step: float | None = None
) -> tuple[int, complex, Floats] | None:
    """Return (vertex, eigenvalue, Z) of a vertex whose own eigenvalue has Re >= -alpha.

    In discrete time |z| >= e^(-alpha T).
    """
    sizes = _sizes(np.linalg.eigvals(A), step).max(axis=1)
    limit = -alpha if step is None else float(np.exp(-alpha * step))
    for vertex in np.argsort(-sizes, kind="stable")[:MOST_VERTICES].tolist():
        if sizes[vertex] + _most_rounding(A[vertex]) < limit:
            return None
        eigenvalues, vectors = np.linalg.eig(A[vertex])
        worst = int(np.argmax(_sizes(eigenvalues, step)))
        excess = float(_sizes(eigenvalues, step)[worst] - limit)
        off = float(_rounding(A[vertex], vectors)[worst])
        sure = abs(excess) > off
        if (sure and excess > 0) or (not sure and not decays_exactly(A[vertex], alpha, step=step)):
            v = vectors[:, worst]
            Z = np.real(np.outer(v, v.conj()))
            return vertex, complex(eigenvalues[worst]), Z / np.trace(Z)
    return None


def _sizes(eigenvalues: NDArray[Any], step: float | None) -> Floats:
    """Return the number that decides on decay: the real part, or the modulus in discrete time."""
    return np.asarray(eigenvalues.real if step is None else np.abs(eigenvalues))


def _most_rounding(A: Floats) -> float:
    """Return the largest possible rounding error of an eigenvalue, that of a defective one."""
    size = float(np.linalg.norm(A))
    return float(size * (ROUNDING * len(A) * float(np.finfo(float).eps)) ** (1.0 / len(A)))


def _rounding(A: Floats, vectors: Floats) -> Floats:
    """Return the possible rounding error of each eigenvalue; inf if it cannot be bounded."""
    try:
        left_vectors = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return np.full(len(A), np.inf)
    with np.errstate(over="ignore"):  # inf: almost dependent eigenvectors give no bound
        condition = np.linalg.norm(left_vectors, axis=1) * np.linalg.norm(vectors, axis=0)
    unit = ROUNDING * len(A) * np.finfo(float).eps * float(np.linalg.norm(A))
    # For larger errors the first-order bound does not hold.
    return np.where(unit * condition.max() < 1e-3 * np.linalg.norm(A), unit * condition, np.inf)


def decays_exactly(A: Floats, alpha: float, *, step: float | None = None) -> bool:
    """Return whether every eigenvalue has Re < -alpha, or |z|^2 < e^(-2 alpha T), in integers.

    The entries and the rate count as the numbers that they store.
    """
    import flint

    n = len(A)
    exact = flint.fmpq_mat(n, n, [_rational(entry) for entry in A.ravel().tolist()])
    one = flint.fmpq_mat(n, n, [flint.fmpq(int(j == k)) for j in range(n) for k in range(n)])
    if step is None:
        return _is_hurwitz(exact + one * _rational(alpha))
    # |w| < c where (w + c) / (w - c) has a negative real part; w the squares of the eigenvalues.
    limit = one * _rational(rate_parameter(alpha, step)["contraction"])
    squares = exact * exact
    try:
        transformed = (squares - limit).solve(squares + limit)
    except ZeroDivisionError:
        return False
    return _is_hurwitz(transformed)


def _rational(value: float) -> Any:
    import flint

    exact = Fraction(value)
    return flint.fmpq(exact.numerator, exact.denominator)


def _is_hurwitz(matrix: Any) -> bool:
    """Return whether all eigenvalues have negative real parts, by Routh's table."""
    polynomial = matrix.charpoly()
    coefficients = [polynomial[k] for k in range(polynomial.degree(), -1, -1)]
    above, below = coefficients[0::2], coefficients[1::2]
    while below:
        if not above[0] > 0 or not below[0] > 0:
            return False
        share = above[0] / below[0]
        padded = [*below[1:], *[0 * share] * (len(above) - len(below))]
        above, below = below, [a - share * b for a, b in zip(above[1:], padded, strict=True)]
    return bool(above[0] > 0)
