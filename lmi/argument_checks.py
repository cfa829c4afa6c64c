"""Checks of the arguments of conditions on entry: vertices, inputs, rates, weights."""

from __future__ import annotations

from fractions import Fraction
from numbers import Integral, Real
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.term import Array
from takagi.models.arrays import Indices
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
    _check_independent(B.astype(np.float64), letter)
    return B


def sample_time_of(model: object, sample_time: float | None = None) -> float | None:
    """Return the sample time T in s of a discrete-time model; None for continuous time.

    Parameters
    ----------
    sample_time : where the model is an array and cannot say; must agree with a model that can.

    Raises
    ------
    ModelError : not positive, or not the model's own.
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


def _check_independent(B: Array, letter: str) -> None:
    signal, column = ("input", "column") if letter == "B" else ("output", "row")
    stacked = B.reshape(-1, B.shape[2])
    size = np.abs(stacked).max(axis=0)
    for k in np.flatnonzero(size == 0):
        raise ModelError(
            f"{signal} {k + 1} of {B.shape[2]}: its {column} of {letter} is zero in every vertex, "
            f"so it does nothing; leave it out"
        )
    # Columns of equal size are compared, so the answer does not depend on the units of the inputs.
    singular = np.linalg.svd(_equal_sizes(B), compute_uv=False)
    if len(singular) < B.shape[2] or singular[-1] <= 1e-12 * singular[0]:
        raise ModelError(
            f"{letter} has rank {int((singular > 1e-12 * singular[0]).sum())} over all vertices, "
            f"but {B.shape[2]} {signal}s: one is a combination of the others; merge them"
        )
