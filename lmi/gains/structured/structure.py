"""Which measurements each input may use, and the double sums of a convex step.

A closed loop u = -sum_j h_j K_j x in V = x' P x and K, both unknown: the inner convex step.

With G_ij = A_i - B_i K_j and Z_ij = C_i - D12_i K_j, P in the place of Q = P^-1,

    decay rate   He(P G_ij) + 2 alpha P                             V' <= -2 alpha V
    cost         [ He(P G_ij)  Z_ij' ; .  -I ]                      V' <= -|z|^2
    energy gain  [ He(P G_ij)  P E_i  Z_ij' ; .  -gamma I  D11_i' ; .  .  -gamma I ]

and in discrete time, by a Schur complement of V(x+), with - P in the place of He(P G_ij) (- rho^2 P
for the decay rate), and one more block row [P G_ij, P E_i, -P].

They are affine in P for a given K, and affine in K for a given P.  For both unknown at once, near
P = I and K = L (any P is I in suitable states),

    P B K = P B L + B (K - L) + (P - I) B (K - L).

With U = B' (P - I) and W = K - L the last term, wherever it appears in Theta, is

    -He(U' W) = |s U - W / s|^2 / 2 - |s U + W / s|^2 / 2 <= |s U - W / s|^2 / 2,    s > 0.

The bound becomes a block row [s U - W / s] with -2 I on the diagonal.  A solution of these LMIs
satisfies the bilinear inequalities.  If (I, L) satisfies the bilinear ones it also satisfies the
LMIs, as U = W = 0 there; so no step is worse than its start.

Source: derived here; Dinh, Gumussoy, Michiels, Diehl (2012), IEEE Trans. Automatic Control 57(6),
for the convex-concave decomposition of bilinear matrix inequalities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.argument_checks import corners_of, decay_parameter
from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, He, block, identity, matrix, placement
from takagi.lmi.expressions.piece import turned
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
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

    def of_gain(self, row: Unknown) -> Expression:
        """Return the member that K_j has of an unknown row, one for each group."""
        if self.groups == 1:
            return row.as_expression()
        r = len(self.group)
        each = np.array_equal(self.group, np.arange(r))
        members = self.group[None] if each else np.broadcast_to(self.group, (r, r))
        return row.members(members, row.symbol.removesuffix("}") + "{j}}")

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

    ``A``, ``B`` : in states x = units xhat, inputs of order one.
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


Objective: TypeAlias = Literal["decay_rate", "cost", "hinf"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StructuredGains:
    """The gains K_j of a double sum: known ones, or unknown ones near them.

    Attributes
    ----------
    reference : L_j, (r, m, n).
    structure : the structure of the unknown gains, its C in the plant's states; None where
        K_j = L_j.
    unknowns : the free entries of the structure, in the coordinates of ``local_units``.
    spread : s of the overbound; with a larger s K may move further, and P less.
    """

    reference: Floats
    structure: Structure | None = None
    unknowns: tuple[Unknown, ...] = ()
    spread: float = 1.0

    @property
    def K_j(self) -> Expression:
        """Return the unknown gain, row by row."""
        assert self.structure is not None
        columns = np.eye(self.reference.shape[1])
        C, pattern = self.structure.C, self.structure.pattern
        rows = [
            placement(columns[:, [k]]) @ self.structure.of_gain(row) @ placement(C[pattern[k]])
            for k, row in zip(self.structure.rows, self.unknowns, strict=True)
        ]
        return sum(rows[1:], rows[0])


def loop_sum(
    plant: DisturbedPlant, objective: Objective, P: Unknown, gamma: Unknown, gains: StructuredGains
) -> DoubleSum:
    """Return the module's double sum.

    ``gamma`` : the unknown of the energy gain; unused for the other objectives.
    ``gains`` : known gains give a sum in P alone; unknown ones that of the inner convex step at P =
    I.
    """
    step = plant.sample_time is not None
    rate = decay_parameter(0.0, 1.0 if step else None)
    moved = "next" if step else "state"
    motion, output = _motion(plant, P, gains), _shown(plant, gains)
    cells: dict[tuple[str, str], object] = {}
    if step:
        cells["state", "state"] = -rate * P if objective == "decay_rate" else -P
        cells["next", "state"], cells["next", "next"] = motion, -P
    else:
        decay = objective == "decay_rate"
        cells["state", "state"] = He(motion) + 2 * rate * P if decay else He(motion)
    if objective == "hinf":
        q, p = plant.E.shape[2], plant.C.shape[1]
        cells[moved, "disturbance"] = P @ matrix(plant.E, "E_{i}", over="i")
        cells["disturbance", "disturbance"] = -gamma * identity(q)
        cells["output", "disturbance"] = matrix(plant.D11, "D^{11}_{i}", over="i")
        cells["output", "output"] = -gamma * identity(p)
    elif objective == "cost":
        cells["output", "output"] = -identity(plant.C.shape[1])
    if objective != "decay_rate":
        cells["output", "state"] = output
    if gains.structure is not None:
        s, L = gains.spread, gains.reference
        reach = matrix(s * turned(plant.B), r"s B_{i}^\top", over="i")
        # s B' (P - I) - (K - L) / s
        pushed, turned_gain = (
            reach @ P - reach,
            matrix(L / s, "L_{j} / s", over="j") - gains.K_j / s,
        )
        if step:
            cells["step", "next"], cells["step", "state"] = pushed, turned_gain
        else:
            cells["step", "state"] = pushed + turned_gain
        cells["step", "step"] = -2 * identity(plant.B.shape[2])
    names = [
        name for name in ("state", "disturbance", "next", "output", "step") if (name, name) in cells
    ]
    rows = [[cells.get((a, b), None if (b, a) in cells else 0) for b in names] for a in names]
    theta = block(rows) << 0
    return double_sum_of(theta, rules=len(plant.A), corners=corners_of(plant))


def _motion(plant: DisturbedPlant, P: Unknown, gains: StructuredGains) -> Expression:
    """Return P G_ij, linear about (I, L)."""
    steered = plant.B[:, None] @ gains.reference
    loop = P @ matrix(plant.A[:, None] - steered, "(A_{i} - B_{i} L_{j})", over="ij")
    if gains.structure is None:
        return loop
    B_i = matrix(plant.B, "B_{i}", over="i")
    return loop - B_i @ gains.K_j + matrix(steered, "B_{i} L_{j}", over="ij")


def _shown(plant: DisturbedPlant, gains: StructuredGains) -> Expression:
    """Return the output Z_ij."""
    if gains.structure is None:
        output = plant.C[:, None] - plant.D12[:, None] @ gains.reference
        return matrix(output, "(C_{i} - D^{12}_{i} L_{j})", over="ij")
    D12_i = matrix(plant.D12, "D^{12}_{i}", over="i")
    return matrix(plant.C, "C_{i}", over="i") - D12_i @ gains.K_j
