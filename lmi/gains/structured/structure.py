"""The structure of a law: zeros, outputs, shared gains; and the modes that it cannot move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.sums.summands import Member
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError

# An eigenvalue counts as a fixed mode if DRAWS random gains leave it unchanged, up to UNMOVED times
# the size of the vertex.
DRAWS, UNMOVED = 3, 1e-9


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Structure:
    """u = -sum_j h_j F_j C x with F_j zero off the pattern, and one F for each group of rules.

    Attributes
    ----------
    pattern : (m, p), True where F may differ from zero.
    C : (p, n), of full row rank.
    group : (r,), the number of the F that each rule uses, 0 ... groups - 1.
    """

    pattern: NDArray[np.bool_]
    C: Floats
    group: Indices

    @property
    def groups(self) -> int:
        """Return the number of different F."""
        return int(self.group.max()) + 1

    @property
    def rows(self) -> tuple[int, ...]:
        """Return the inputs with at least one free entry of F."""
        return tuple(int(k) for k in np.flatnonzero(self.pattern.any(axis=1)))

    @property
    def free(self) -> Structure:
        """Return a gain for each rule, without any structure."""
        m, n = len(self.pattern), self.C.shape[1]
        return Structure(
            pattern=np.ones((m, n), dtype=bool), C=np.eye(n), group=np.arange(len(self.group))
        )

    @property
    def member(self) -> Member:
        """Return which member of an unknown of ``groups`` appears in Theta_ij."""
        r = len(self.group)
        if self.groups == 1:
            return "first"
        if np.array_equal(self.group, np.arange(r)):
            return "gain"
        return np.broadcast_to(self.group, (r, r)).copy()

    def unknowns(self) -> tuple[Unknown, ...]:
        """Return the free entries of F, one unknown for each input with a free entry."""
        return tuple(
            Unknown(
                f"F{k + 1}",
                1,
                int(self.pattern[k].sum()),
                count=self.groups,
                latex=f"F_{{{k + 1}}}",
            )
            for k in self.rows
        )

    def assembled(self, rows: Sequence[Floats]) -> Floats:
        """Return F (groups, m, p) from the values of ``unknowns``; other entries are exactly 0."""
        F = np.zeros((self.groups, *self.pattern.shape))
        for k, row in zip(self.rows, rows, strict=True):
            F[:, k, self.pattern[k]] = row[:, 0]
        return F

    def gains(self, F: Floats) -> Floats:
        """Return K_j = F_j C, (r, m, n).

        Where a column of C or a row of F is zero, the entry of K_j is exactly zero.
        """
        return np.asarray((F @ self.C)[self.group])

    def projected(self, K: Floats, weight: Floats) -> Floats:
        """Return the F whose F C is nearest to the mean gain of each group, (groups, m, p).

        Nearest in |(F C - K) W^1/2|, row by row.  With the weight W = P^-1 the norm of a row is the
        largest difference of that input on x' P x <= 1.
        """
        F = np.zeros((self.groups, *self.pattern.shape))
        root = np.linalg.cholesky(weight)
        for g in range(self.groups):
            mean = K[self.group == g].mean(axis=0)
            for k in self.rows:
                measured = self.pattern[k]
                F[g, k, measured] = np.linalg.lstsq(
                    (self.C[measured] @ root).T, mean[k] @ root, rcond=None
                )[0]
        return F

    def slack_pattern(self) -> NDArray[np.bool_]:
        """Return (n, n), True where G may differ from zero; the first p of the states are C x.

        G_ab = 0 where some input depends on a but not on b.  Then F [I 0] G has the pattern of F,
        and zeros in all columns beyond the p-th; and M G^-1 has this pattern if M has it.
        """
        p, n = self.C.shape
        measured = np.zeros((len(self.pattern), n), dtype=bool)
        measured[:, :p] = self.pattern
        measured = measured[list(self.rows)]
        return np.asarray(~np.einsum("ka,kb->ab", measured, ~measured), dtype=bool)


def structure_of(
    sizes: tuple[int, int, int],
    pattern: ArrayLike | None,
    output: ArrayLike | None,
    shared: ArrayLike | None,
) -> Structure:
    """Return the checked structure of a law for r rules, n states, m inputs.

    Parameters
    ----------
    sizes : (r, n, m).
    pattern : (m, p), or None for no zeros.
    output : (p, n); None for the states.
    shared : (r,) labels; rules of one label share a gain. None gives each rule its own gain.

    Raises
    ------
    ModelError : shapes, entries that are not true or false, a pattern without a free entry,
        linearly dependent outputs.
    """
    r, n, m = sizes
    C = np.eye(n) if output is None else _outputs(output, n)
    p = len(C)
    return Structure(
        pattern=pattern_of(np.ones((m, p), dtype=bool) if pattern is None else pattern, m, p),
        C=C,
        group=_groups(shared, r),
    )


def pattern_of(pattern: ArrayLike, m: int, p: int) -> NDArray[np.bool_]:
    """Return the checked pattern, (m, p).

    Raises
    ------
    ModelError : its shape, entries that are not true or false, no free entry.
    """
    try:
        entries = np.asarray(pattern)
    except ValueError as error:
        raise ModelError(f"pattern cannot be read as an array ({error})") from error
    if entries.shape != (m, p):
        raise ModelError(
            f"pattern has shape {entries.shape}; ({m}, {p}) is needed, a row for each input and a "
            "column for each state or output: True where the law may look"
        )
    if entries.dtype != bool and not (
        entries.dtype.kind in "iuf" and np.isin(entries, (0, 1)).all()
    ):
        raise ModelError("pattern must be of True and False (or 1 and 0); it says where, not what")
    if not entries.any():
        raise ModelError(
            "pattern has no True, so the law sees nothing and u = 0; allow at least one entry"
        )
    return entries.astype(bool)


def _outputs(output: ArrayLike, n: int) -> Floats:
    try:
        C = np.array(output, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"output cannot be read as an array of numbers ({error})") from error
    if C.ndim != 2 or C.shape[1] != n or not len(C):
        raise ModelError(
            f"output has shape {C.shape}; (p, {n}) is needed, one C of y = C x for all vertices"
        )
    if not np.isfinite(C).all():
        raise ModelError("output has an entry that is not finite")
    # Rows of length one are compared, so that units of the outputs do not matter.
    rows = np.linalg.norm(C, axis=1)
    rank = int(np.linalg.matrix_rank(C / np.where(rows > 0, rows, 1.0)[:, None], tol=1e-12))
    if rank < len(C):
        raise ModelError(
            f"output has {len(C)} rows of rank {rank}: one is zero or a combination of others; "
            "leave it out"
        )
    return C


def _groups(shared: ArrayLike | None, r: int) -> Indices:
    if shared is None:
        return np.arange(r)
    labels = np.asarray(shared)
    if labels.shape != (r,):
        raise ModelError(
            f"shared has shape {labels.shape}; ({r},) labels are needed, one for each rule: rules "
            "of one label share a gain"
        )
    # Numbered in the order in which they come.
    _, first, group = np.unique(labels, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[group], dtype=np.intp)


def check_movable(
    A: Array,
    B: Array,
    structure: Structure,
    *,
    units: Floats,
    names: Sequence[str] = (),
    step: float | None = None,
) -> None:
    """Raise ModelError for a vertex with an undamped mode that no gain of the structure moves.

    A fixed mode is an eigenvalue of A_i - B_i F C for every F of the pattern.  With probability 1
    an eigenvalue that a few random F share is a fixed mode (Wang and Davison, 1973).

    Parameters
    ----------
    A, B : in states x = units xhat, inputs of order one.
    """
    rng = np.random.default_rng(0)
    C = structure.C * units
    C = C / np.linalg.norm(C, axis=1)[:, None]
    for vertex, (vertex_matrix, reach) in enumerate(zip(A, B, strict=True)):
        size = float(np.linalg.norm(vertex_matrix, 2)) or 1.0
        reach = reach * (size / (np.abs(reach).max() or 1.0))
        loops = [
            vertex_matrix
            - reach @ (structure.pattern * rng.standard_normal(structure.pattern.shape)) @ C
            for _ in range(DRAWS)
        ]
        values, vectors = np.linalg.eig(vertex_matrix)
        for value, vector in zip(values, vectors.T, strict=True):
            # A mode on the stability boundary counts as slow, although rounding may put it inside.
            slow = value.real >= -1e-12 * size if step is None else abs(value) >= 1 - 1e-12
            shifted = np.stack(loops) - value * np.eye(len(vertex_matrix))
            smallest_singular = np.linalg.svd(shifted, compute_uv=False)[:, -1].max()
            if slow and smallest_singular < UNMOVED * size:
                raise ModelError(_fixed(vertex, len(A), complex(value), vector * units, names))


def _fixed(vertex: int, count: int, value: complex, vector: Array, names: Sequence[str]) -> str:
    labels = names or tuple(f"x{k}" for k in range(1, len(vector) + 1))
    share = np.abs(vector) / np.abs(vector).max()
    state_names = ", ".join(labels[k] for k in np.argsort(-share, kind="stable") if share[k] > 1e-3)
    mode_text = f"{value:.6g}" if value.imag else f"{value.real:.6g}"
    return (
        f"vertex {vertex + 1} of {count}: the mode at {mode_text} (in {state_names}) does not "
        "decay and no gain of this pattern moves it: a fixed mode of the structure; allow an input "
        "that reaches it to see it"
    )
