r"""A plant with inputs, disturbances and a performance output: what norms of a design are about.

What the conditions on a disturbed loop are made of, with Q = P^-1, M_j = K_j Q, u = -K x.

    continuous   G_ij = A_i Q - B_i M_j         x' in xhat = P x
    discrete     G_ij = (A_i - I) Q - B_i M_j   x+ - x
    both         Z_ij = C_i Q - D12_i M_j       z

of which Theta_ij is made; the decay of the undisturbed loop; limits.

In discrete time V(x+) - V(x) = 2 x' P (x+ - x) + (x+ - x)' P (x+ - x).  Sampled fast, x+ - x is a
share s of x, so small that a solver would lose it in x+; the rows of x are divided by sqrt(s), a
power of two.  Both are congruences: they change no inequality, and no relaxation of it.  In LaTeX
a bar stands for (A_i - I) / s, B_i / s, C_i / sqrt(s), D12_i / sqrt(s) and E_i / sqrt(s).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.argument_checks import (
    check_stabilisable,
    corners_of,
    decay_parameter,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.statements import pose, positive_definite
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, nearest_power, state_units
from takagi.lmi.expressions.expression import Expression, Parameter, matrix
from takagi.lmi.gains.requirements.closed_loop import closed_loop, region_sums
from takagi.lmi.gains.requirements.limits import Limits, limit_lmis
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.premise import Premise

# Margin of Theta for a margin 1 of Q.  At the least gain Q tends to be singular, and the gains
# without bound; what margin there is should go to Q.
WEIGHT = 1e-2
BARS = "bars, in discrete time: A - I and B over s, C, D12 and E over its root, s a power of two"


def root_share(plant: DisturbedPlant) -> float:
    """Return sqrt(s), a power of two: how much of a state changes in a sample; 1 in continuous."""
    if plant.sample_time is None:
        return 1.0
    size = vertex_weight(motion(plant.A, plant.sample_time)) / 2
    return float(nearest_power(min(1.0, size) ** 0.5))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LoopBlocks:
    """The module's matrices of a disturbed loop, as expressions.

    Attributes
    ----------
    G : G_ij, over s in discrete time.
    next_G : G_ij over sqrt(s); None in continuous time.
    Z, output : Z_ij over sqrt(s), and Z_ij itself.
    E, entering : E_i over sqrt(s), and E_i over s.
    """

    G: Expression
    next_G: Expression | None
    Z: Expression
    output: Expression
    E: Expression
    entering: Expression

    @classmethod
    def of(cls, plant: DisturbedPlant, Q: Unknown, M: Unknown) -> LoopBlocks:
        """Return them for a plant; in continuous time s = 1."""
        share = root_share(plant)
        bar = r"\bar " * (plant.sample_time is not None)
        M_j = M.over("j")

        def moved(over: float, name: str) -> Expression:
            free, steered = motion(plant.A, plant.sample_time) / over, plant.B / over
            A_i = matrix(free, rf"{name}A_{{i}}", over="i")
            return A_i @ Q - matrix(steered, rf"{name}B_{{i}}", over="i") @ M_j

        def shown(over: float, bar: str) -> Expression:
            C_i = matrix(plant.C / over, rf"{bar}C_{{i}}", over="i")
            return C_i @ Q - matrix(plant.D12 / over, rf"{bar}D^{{12}}_{{i}}", over="i") @ M_j

        return cls(
            G=moved(share**2, bar),
            next_G=moved(share, rf"\sqrt s {bar}") if bar else None,
            Z=shown(share, bar),
            output=shown(1.0, ""),
            E=matrix(plant.E, "E_{i}", over="i"),
            entering=matrix(plant.E / share, rf"{bar}E_{{i}}", over="i"),
        )


def sum_of(plant: DisturbedPlant, theta: Expression, name: str = "") -> DoubleSum:
    """Return the double sum of Theta over the plant's rules."""
    statement = (theta << 0).named(name, weight=WEIGHT)
    return double_sum_of(statement, rules=len(plant.A), corners=corners_of(plant))


def disturbed_condition(
    plant: DisturbedPlant,
    Q: Unknown,
    M: Unknown,
    sums: Sequence[DoubleSum],
    *statements: LMI,
    relaxation: str,
    decay_rate: float | Fraction = 0.0,
    limits: Limits | None,
    minimise: Unknown,
    unknowns: tuple[Unknown, ...],
    name: str,
    source: str,
) -> Condition:
    """Pose Q > 0, the double sums, the statements, what is asked of the loop without w, limits.

    Parameters
    ----------
    decay_rate : alpha > 0 in 1/s of V' <= -2 alpha V, or V(x+) <= e^(-2 alpha T) V, without w; 0
        asks for none.
    unknowns : those that come first among the solver's variables, behind Q and M.
    name, source : of the condition, without its relaxation.
    """
    relaxed = relaxation_named(relaxation)
    step = plant.sample_time
    rate: tuple[Parameter, ...] = ()
    decay: tuple[LMI, ...] = ()
    if decay_rate > 0:
        rate = (decay_parameter(decay_rate, step),)
        weight = WEIGHT * root_share(plant) ** 2
        loop = closed_loop(
            plant.A,
            plant.B,
            Q,
            M,
            weight=weight,
            discrete=step is not None,
            corners=corners_of(plant),
        )
        decay = relaxed(replace(loop, name="decay"))[1]
    if plant.region is not None:
        parts = region_sums(plant.A, plant.B, Q, M, plant.region, corners=corners_of(plant))
        decay += tuple(lmi for part in parts for lmi in relaxed(part)[1])
    return pose(
        positive_definite(Q),
        *(lmi for double_sum in sums for lmi in relaxed(double_sum)[1]),
        *statements,
        *decay,
        *limit_lmis(Q, M, limits)[1],
        minimise=minimise,
        unknowns=(Q, M, *unknowns),
        parameters=rate,
        name=f"{name}, {relaxation}",
        source=source if step is None else f"{source}; {BARS}",
    )


# (C1, D12, D11), each (r, ., .) or (., .); None, or left out, for zero.
Performance: TypeAlias = Sequence[ArrayLike | None]


@runtime_checkable
class Disturbed(Protocol):
    """What a design against disturbances reads of a model; E may be absent, then it says so."""

    @property
    def A(self) -> Array: ...

    @property
    def B(self) -> Array: ...


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DisturbedPlant:
    """x' or x+ = sum_i h_i (A_i x + B_i u + E_i w), z = sum_i h_i (C_i x + D12_i u + D11_i w).

    Attributes
    ----------
    A, B, E : (r, n, n), (r, n, m), (r, n, q).
    C, D12, D11 : (r, p, n), (r, p, m), (r, p, q).
    sample_time : T in s; None for continuous time.
    premises, rules : the model's, for relaxations that know products of memberships.
    region : of the undisturbed loop's eigenvalues, in 1/s and continuous time; None for none.
    """

    A: Floats
    B: Floats
    E: Floats
    C: Floats
    D12: Floats
    D11: Floats
    sample_time: float | None
    premises: Sequence[Premise] = ()
    rules: Sequence[tuple[int, ...]] = ()
    region: EigenvalueRegion | None = None

    @property
    def reaching(self) -> DisturbedPlant:
        """Return the plant with as few inputs as move the states in the same ways.

        Inputs that only differ in what they cost are one input where that does not matter.
        """
        stacked = self.B.reshape(-1, self.B.shape[2])
        size = np.abs(stacked).max(axis=0)
        _, singular, vectors = np.linalg.svd(stacked / np.where(size > 0, size, 1.0))
        rank = int((singular > 1e-12 * singular[0]).sum())
        if rank == self.B.shape[2]:
            return self
        merged = vectors[:rank].T / np.where(size > 0, size, 1.0)[:, None]
        return replace(self, B=self.B @ merged, D12=self.D12 @ merged)

    def in_units(
        self, T: Floats, tau: Floats, *, rate: float, disturbance: float, output: float
    ) -> DisturbedPlant:
        """Return it in x = T xhat, u = tau uhat, w and z in units of theirs, time in 1 / rate."""
        return replace(
            self,
            A=np.asarray(np.linalg.solve(T, self.A @ T) / rate, dtype=np.float64),
            B=np.asarray(np.linalg.solve(T, self.B * tau) / rate, dtype=np.float64),
            E=np.asarray(np.linalg.solve(T, self.E) * (disturbance / rate), dtype=np.float64),
            C=self.C @ T / output,
            D12=self.D12 * tau / output,
            D11=self.D11 * (disturbance / output),
            region=None if self.region is None else self.region.slowed(rate),
        )

    def fed_back(self, K: Floats) -> DisturbedPlant:
        """Return the plant whose input is counted from -K x, the same K (m, n) in every rule."""
        return replace(self, A=self.A - self.B @ K, C=self.C - self.D12 @ K)


def plant_of(
    model: Disturbed | DisturbedPlant,
    performance: Performance | None = None,
    sample_time: float | None = None,
) -> DisturbedPlant:
    """Return the plant that a model and a performance output make.

    Parameters
    ----------
    model : A (r, n, n), B (r, n, m), and the disturbance's E (r, n, q).  Without ``performance``
        the output is the model's, z = C x + D u, with nothing direct from w to z.
    performance : (C1, D12, D11) of z = C1 x + D12 u + D11 w, each (r, ., .) or (., .); D12 and D11
        may be None or left out.
    sample_time : T in s where the model cannot say; see ``sample_time_of``.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, an input that does
        nothing, a path that is zero.
    """
    if isinstance(model, DisturbedPlant):
        return model
    A = vertex_stack(model).astype(np.float64)
    r, n = A.shape[:2]
    B = getattr(model, "B", None)
    if B is None or 0 in np.shape(B):
        raise ModelError("the model has no input; B is needed, (r, n, m)")
    B = _stack("B", B, (r, n, np.shape(B)[-1]))
    E = getattr(model, "E", None)
    if E is None or 0 in np.shape(E):
        raise ModelError(
            "the model has no disturbance; E is needed, (n, q) or one for each vertex (E = B for a "
            "disturbance that comes in with the input)"
        )
    E = _stack("E", E, (r, n, np.shape(E)[-1]))
    C, D12, D11 = _outputs(model, performance, (r, n, B.shape[2], E.shape[2]))
    _check_inputs(B, D12)
    if not (E.any() or D11.any()) or not (C.any() or D12.any() or D11.any()):
        name = "E" if not E.any() else "C1"
        raise ModelError(
            f"{name} is zero at every vertex, so nothing is to be kept small; the gain is 0"
        )
    return DisturbedPlant(
        A=A,
        B=B,
        E=E,
        C=C,
        D12=D12,
        D11=D11,
        sample_time=sample_time_of(model, sample_time),
        premises=tuple(getattr(model, "premises", ())),
        rules=tuple(getattr(model, "rules", ())),
    )


def check_reachable(plant: DisturbedPlant, names: Sequence[str] = ()) -> None:
    """Raise ModelError for a vertex with an undamped mode that no input moves."""
    step = plant.sample_time
    s = state_units(plant.A, None, step=step)
    A, B = plant.A * s / s[:, None], plant.B / s[:, None]
    B = B / np.maximum(np.linalg.norm(B, axis=(0, 1)), 1e-300)
    check_stabilisable(A, B, units=s, names=tuple(names), step=step)


def _check_inputs(B: Floats, D12: Floats) -> None:
    """Raise ModelError for an input without an effect of its own on the states and the output."""
    effect = np.concatenate([B, D12], axis=1).reshape(-1, B.shape[2])
    size = np.abs(effect).max(axis=0)
    for k in np.flatnonzero(size == 0):
        raise ModelError(
            f"input {k + 1} of {len(size)}: its columns of B and D12 are zero in every vertex, so "
            "it does nothing; leave it out"
        )
    singular = np.linalg.svd(effect / size, compute_uv=False)
    if len(singular) < len(size) or singular[-1] <= 1e-12 * singular[0]:
        raise ModelError(
            f"B and D12 have rank {int((singular > 1e-12 * singular[0]).sum())} over all vertices, "
            f"but {len(size)} inputs: one is a combination of the others; merge them"
        )


def _outputs(
    model: object, performance: Performance | None, sizes: tuple[int, int, int, int]
) -> tuple[Floats, Floats, Floats]:
    r, n, m, q = sizes
    if performance is None:
        output_matrices: list[ArrayLike | None] = [
            getattr(model, "C", None),
            getattr(model, "D", None),
            None,
        ]
        names = ("C", "D", "D11")
    else:
        if not isinstance(performance, (tuple, list)) or not 1 <= len(performance) <= 3:
            raise ModelError("performance must be (C1, D12, D11), or its first one or two")
        output_matrices = [*performance, *[None] * (3 - len(performance))]
        names = ("C1", "D12", "D11")
    if output_matrices[0] is None or 0 in np.shape(output_matrices[0]):
        raise ModelError(
            f"there is no output to keep small; {names[0]} is needed, (p, n) or one for each vertex"
        )
    p = np.shape(output_matrices[0])[-2] if np.ndim(output_matrices[0]) > 1 else 0
    shapes = ((r, p, n), (r, p, m), (r, p, q))
    C, D12, D11 = (
        np.zeros(shape)
        if value is None or (not np.size(value) and name == "D")
        else _stack(name, value, shape)
        for name, value, shape in zip(names, output_matrices, shapes, strict=True)
    )
    return C, D12, D11


def _stack(name: str, value: ArrayLike, shape: tuple[int, int, int]) -> Floats:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"{name} cannot be read as an array of numbers ({error}); give nested lists of equal "
            "length or a numpy array"
        ) from error
    if array.shape not in (shape, shape[1:]):
        raise ModelError(
            f"{name} has shape {array.shape}; {shape} is needed, or {shape[1:]} for the same in "
            "every vertex"
        )
    if not np.isfinite(array).all():
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ModelError(f"{name}{list(where)} is {array[where]}; every entry must be finite")
    return np.array(np.broadcast_to(array, shape))
