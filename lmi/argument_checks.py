"""Checks on entry: arguments, modes that no input moves, vertices that decay too slowly.

The error of a computed eigenvalue is the rounding error times its condition number. For a loop with
gains of 1e5 that can be more than the decay rate. If an eigenvalue is that near to its limit, the
exact coefficients of the characteristic polynomial decide, by Routh's table.

Source: Golub and Van Loan (2013), Matrix Computations, section 7.2.2 (condition of an eigenvalue);
Gantmacher (1959), The Theory of Matrices, volume 2, chapter XV (Routh).
"""

from __future__ import annotations

from fractions import Fraction
from numbers import Integral, Real
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.condition.term import Array
from takagi.lmi.expressions.expression import Parameter
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError


@runtime_checkable
class _HasVertices(Protocol):
    @property
    def A(self) -> Array: ...


Vertices: TypeAlias = _HasVertices | ArrayLike

# Products of a few such entries are still finite.
LARGEST = 1e60


def vertex_stack(model: Vertices) -> Array:
    """Return (N, n, n) from a model's A or from an array; one (n, n) matrix is one vertex.

    Fractions stay fractions, so that a builder can be evaluated exactly.

    Raises
    ------
    ModelError : no vertices, not square, or an entry that is not finite.
    """
    source = model.A if isinstance(model, _HasVertices) else model
    A = _numbers("A", source)
    A = A[None] if A.ndim == 2 else A
    if A.ndim != 3 or A.shape[1] != A.shape[2]:
        raise ModelError(
            f"A has shape {A.shape}; (N, n, n) is needed: N vertices, each a square matrix"
        )
    if 0 in A.shape:
        raise ModelError(
            f"A has shape {A.shape}: {'no vertices' if not len(A) else 'no states'}; "
            "give at least one vertex of at least one state"
        )
    _finite("A", A)
    return A


def input_stack(model: object, A: Array, letter: str = "B") -> Array:
    """Return B (r, n, m), or C' (r, n, p) for letter "C", checked against A.

    Raises
    ------
    ModelError : absent, shape, not finite, or inputs (outputs) that are not independent.
    """
    signals = "inputs" if letter == "B" else "outputs"
    source = getattr(model, letter, None)
    if source is None:
        raise ModelError(f"the model has no {letter}; {signals} are needed, give {letter}")
    B = _numbers(letter, source)
    B = B.transpose(0, 2, 1) if letter == "C" and B.ndim == 3 else B
    if B.ndim != 3 or B.shape[:2] != A.shape[:2]:
        shape_text = "(r, n, m)" if letter == "B" else "(r, p, n)"
        raise ModelError(
            f"{letter} has shape {np.shape(source)}, A has {A.shape}; {letter} must be "
            f"{shape_text} with the vertices and states of A"
        )
    if B.shape[2] == 0:
        raise ModelError(f"the model has no {signals}; {letter} needs at least one")
    _finite(letter, B)
    check_independent(B.astype(np.float64), letter)
    return B


def sample_time_of(model: object, sample_time: float | None = None) -> float | None:
    """Return the sample time T in s of a discrete-time model; None for continuous time.

    ``sample_time`` : where the model is an array and cannot say; must agree with a model that can.

    Raises ModelError: not positive, or not the model's own.
    """
    model_time = getattr(model, "sample_time", None)
    if sample_time is None:
        return model_time
    step = float(number("sample_time", sample_time))
    if step <= 0:
        raise ModelError(
            f"sample_time is {step:g} s; it must be positive, None for continuous time"
        )
    if model_time is not None and model_time != step:
        raise ModelError(
            f"sample_time is {step:g} s, but the model's own is {model_time:g} s; leave it out"
        )
    if model_time is None and hasattr(model, "sample_time"):
        raise ModelError(
            f"sample_time is {step:g} s, but the model is of continuous time; discretise it first"
        )
    return step


def rate_parameter(alpha: float | Fraction, step: float | None) -> dict[str, float]:
    """Return what the decay rate is in a condition: ``alpha``, or ``contraction`` e^(-2 alpha T).

    V' <= -2 alpha V in continuous time, V(x+) <= e^(-2 alpha T) V(x) in discrete time.
    """
    if step is None:
        return {"alpha": float(alpha)}
    return {"contraction": float(np.exp(-2.0 * float(alpha) * step))}


def decay_parameter(alpha: float | Fraction, step: float | None) -> Parameter:
    """Return ``rate_parameter`` as a named number of an expression: alpha, or rho^2."""
    ((name, value),) = rate_parameter(alpha, step).items()
    return Parameter(name, value, r"\alpha" if step is None else r"\rho^2")


def corners_of(model: object) -> Indices | None:
    """Return (r, premises), which corner of each premise a rule takes; None without premises."""
    premises, rules = getattr(model, "premises", ()), getattr(model, "rules", ())
    if not premises:
        return None
    return np.array(rules, dtype=np.intp).reshape(len(rules), len(premises))


def number(name: str, value: object, *, at_least: float | None = None) -> float | Fraction:
    """Return a finite real number.

    Raises
    ------
    ModelError : not one, or below ``at_least``.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(float(value)):
        raise ModelError(f"{name} is {value!r}; a finite number is needed")
    if at_least is not None and value < at_least:
        raise ModelError(f"{name} is {value!r}; it must be at least {at_least:g}")
    return value if isinstance(value, Fraction) else float(value)


def positive_number(name: str, value: float) -> float:
    """Return a positive number.

    Raises
    ------
    ModelError : it is not one.
    """
    number_read = float(number(name, value))
    if number_read <= 0:
        raise ModelError(f"{name} is {number_read:g}; it must be positive")
    return number_read


def whole_number(name: str, value: object) -> int:
    """Return a whole number from 0 on.

    Raises
    ------
    ModelError : not one.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or value < 0:
        raise ModelError(f"{name} is {value!r}; a whole number from 0 is needed")
    return int(value)


def positive_vector(name: str, value: ArrayLike, size: int) -> Array:
    """Return (size,) positive numbers; one number stands for all.

    Raises
    ------
    ModelError : another length, or an entry that is not positive and finite.
    """
    vector = _numbers(name, value).astype(np.float64)
    if vector.shape not in ((), (size,)):
        raise ModelError(f"{name} has shape {vector.shape}; ({size},) or one number is needed")
    vector = np.broadcast_to(vector, (size,)).copy()
    if not np.all((vector > 0) & np.isfinite(vector)):
        bad = int(np.argmin((vector > 0) & np.isfinite(vector)))
        raise ModelError(f"{name}[{bad}] is {vector[bad]}; every entry must be positive and finite")
    return vector


def symmetric(name: str, value: ArrayLike, size: int, *, definite: bool) -> Array:
    """Return a symmetric weight (size, size), positive definite or semidefinite.

    Raises
    ------
    ModelError : shape, not finite, not symmetric (cvxpy would use half of it), or indefinite.
    """
    weight = _numbers(name, value).astype(np.float64)
    if weight.shape != (size, size):
        raise ModelError(f"{name} has shape {weight.shape}; ({size}, {size}) is needed")
    _finite(name, weight)
    gap = np.abs(weight - weight.T)
    if gap.max() > 1e-12 * max(np.abs(weight).max(), 1e-300):
        row, column = np.unravel_index(int(np.argmax(gap)), gap.shape)
        raise ModelError(
            f"{name} is not symmetric: entry [{row}, {column}] is {weight[row, column]:g}, "
            f"[{column}, {row}] is {weight[column, row]:g}; give ({name} + {name}') / 2 if that "
            "is what you mean"
        )
    weight = (weight + weight.T) / 2
    smallest = float(np.linalg.eigvalsh(weight)[0])
    if smallest < -1e-12 * np.abs(weight).max() or (definite and smallest <= 0):
        need = "positive definite" if definite else "positive semidefinite"
        raise ModelError(f"{name} has the eigenvalue {smallest:.6g}; it must be {need}")
    return weight


def _numbers(name: str, value: object) -> Array:
    try:
        if hasattr(value, "toarray"):
            raise TypeError("a sparse matrix; write .toarray() behind it")
        array = np.asarray(value)
        if array.dtype.kind not in "biufOUS":
            raise TypeError("complex entries" if np.iscomplexobj(array) else f"{array.dtype}")
        if array.dtype == object and any(entry is None for entry in array.flat):
            # numpy would make it not-a-number.
            raise TypeError("None in the place of a number")
        if array.dtype == object and all(isinstance(entry, Fraction) for entry in array.flat):
            return array
        return array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"{name} cannot be read as an array of real numbers ({error}); give nested lists of "
            "equal length or a numpy array"
        ) from error


def _finite(name: str, array: Array) -> None:
    size = np.abs(array.astype(np.float64))
    good = size <= LARGEST
    if not good.all():
        where = tuple(int(k) for k in np.argwhere(~good)[0])
        item = f"vertex {where[0] + 1} of {len(array)}: " if array.ndim == 3 else ""
        need = (
            f"entries above {LARGEST:g} overflow; take other units"
            if np.isfinite(size[where])
            else "every entry must be finite"
        )
        raise ModelError(f"{item}{name}{list(where[-2:])} is {array[where]}; {need}")


def _equal_sizes(B: Array) -> Array:
    """Return B stacked, in units of states and inputs in which its entries have similar size."""
    scaled = B
    for _ in range(20):
        row = np.abs(scaled).max(axis=(0, 2))[:, None]
        scaled = scaled / np.sqrt(np.where(row > 0, row, 1.0))
        column = np.abs(scaled).max(axis=(0, 1))
        scaled = scaled / np.sqrt(np.where(column > 0, column, 1.0))
    return np.asarray(scaled.reshape(-1, B.shape[2]))


def check_independent(B: Array, name: str) -> None:
    """Raise ModelError for an input, or output of C', without an effect of its own.

    ``B`` : (r, ., m), C' for ``name`` "C".
    """
    signal, column = ("output", "row") if name == "C" else ("input", "column")
    stacked = B.reshape(-1, B.shape[2])
    size = np.abs(stacked).max(axis=0)
    for k in np.flatnonzero(size == 0):
        raise ModelError(
            f"{signal} {k + 1} of {B.shape[2]}: its {column} of {name} is zero in every vertex, "
            f"so it does nothing; leave it out"
        )
    if B.shape[2] == 1:
        return
    # Columns of equal size are compared, so the answer does not depend on the units of the inputs.
    singular = np.linalg.svd(_equal_sizes(B), compute_uv=False)
    if len(singular) < B.shape[2] or singular[-1] <= 1e-12 * singular[0]:
        raise ModelError(
            f"{name}: rank {int((singular > 1e-12 * singular[0]).sum())} over all vertices, "
            f"but {B.shape[2]} {signal}s: one is a combination of the others; merge them"
        )


def fixed_mode(
    A: Array, B: Array, decay_rate: float, *, step: float | None = None
) -> tuple[int, complex, Array] | None:
    """Return (vertex, eigenvalue, left eigenvector) that no input moves, Re >= -decay_rate.

    By the Popov-Belevitch-Hautus test, [A - lambda I, B] without full rank, in floating point;
    None when none exists.

    ``step`` : sample time T in s of x+ = A x + B u, whose eigenvalues count when |z| >=
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


def too_slow(A: Array, fixed: tuple[int, complex], decay_rate: float, step: float | None) -> str:
    """Return in words that a fixed mode (vertex, eigenvalue) decays slower than asked."""
    vertex, eigenvalue = fixed
    slowness = -eigenvalue.real if step is None else float(-np.log(abs(eigenvalue)) / step)
    return (
        f"vertex {vertex + 1} of {len(A)}: no input moves the mode at {eigenvalue:.6g}, which "
        f"decays slower than {decay_rate:g} 1/s; ask for a decay rate below {slowness:.6g} 1/s"
    )


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
