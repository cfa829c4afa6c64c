r"""What the conditions on a disturbed loop are made of, with Q = P^-1, M_j = K_j Q, u = -K x.

    continuous   G_ij = A_i Q - B_i M_j         x' in xhat = P x
    discrete     G_ij = (A_i - I) Q - B_i M_j   x+ - x
    both         Z_ij = C_i Q - D12_i M_j       z

as parts of Theta_ij; the decay of the undisturbed loop; limits.

In discrete time V(x+) - V(x) = 2 x' P (x+ - x) + (x+ - x)' P (x+ - x).  Sampled fast, x+ - x is a
share s of x, so small that a solver would lose it in x+; the rows of x are divided by sqrt(s), a
power of two.  Both are congruences: they change no inequality, and no relaxation of it.  In LaTeX
a bar stands for (A_i - I) / s, B_i / s, C_i / sqrt(s), D12_i / sqrt(s) and E_i / sqrt(s).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.argument_checks import corners_of
from takagi.lmi.condition.term import Array, Position
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, nearest_power
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.requirements.closed_loop import closed_loop, gain_member, gain_symbol
from takagi.lmi.sums.double_sum import DoubleSum, KnownBlock, SumPart

# Margin of Theta for a margin 1 of Q.  At the least gain Q tends to be singular, and the gains
# without bound; what margin there is should go to Q.
WEIGHT = 1e-2
BARS = "bars, in discrete time: A - I and B over s, C, D12 and E over its root, s a power of two"


def root_share(plant: DisturbedPlant) -> float:
    """Return sqrt(s), a power of two: how much of a state changes in a sample; 1 in continuous."""
    if plant.sample_time is None:
        return 1.0
    size = vertex_weight(motion(plant.A, plant.sample_time)) / 2
    return float(nearest_power(np.array([min(1.0, size) ** 0.5]))[0])


def motion_parts(
    plant: DisturbedPlant, Q: Unknown, M: Unknown, next_row: int
) -> tuple[SumPart, ...]:
    """Return He(G_ij) / s in the first block; in discrete time also what follows from it.

    Parameters
    ----------
    next_row : the block row of G_ij / sqrt(s) and, on the diagonal, -Q.
    """
    root, A = root_share(plant), motion(plant.A, plant.sample_time)
    if plant.sample_time is None:
        return _pair(Q, M, A, plant.B, ("A_{i}", "B_{i}"), (0, 0), with_transpose=True)
    names = (r"\bar A_{i}", r"\bar B_{i}")
    roots = (r"\sqrt s \bar A_{i}", r"\sqrt s \bar B_{i}")
    here = _pair(Q, M, A / root**2, plant.B / root**2, names, (0, 0), with_transpose=True)
    there = _pair(Q, M, A / root, plant.B / root, roots, (next_row, 0), with_transpose=False)
    return (*here, *there, own(Q, (next_row, next_row)))


def output_parts(
    plant: DisturbedPlant, Q: Unknown, M: Unknown, at: Position, *, by_share: bool = True
) -> tuple[SumPart, ...]:
    """Return Z_ij / sqrt(s) in a block of the first column, or Z_ij itself."""
    root, names = 1.0, ("C_{i}", "D^{12}_{i}")
    if by_share and plant.sample_time is not None:
        root = root_share(plant)
        names = (r"\bar C_{i}", r"\bar D^{12}_{i}")
    return _pair(Q, M, plant.C / root, plant.D12 / root, names, at, with_transpose=False)


def disturbance_parts(
    plant: DisturbedPlant, row: int, divisor: float = 1.0, latex: str = "E_{i}"
) -> tuple[KnownBlock, ...]:
    """Return E_i, divided by sqrt(s) or s, in the second block of a row."""
    return (KnownBlock(value=plant.E / divisor, at=(row, 1), latex=latex),)


def _pair(
    Q: Unknown,
    M: Unknown,
    free: Array,
    steered: Array,
    symbols: tuple[str, str],
    at: Position,
    with_transpose: bool,
) -> tuple[SumPart, SumPart]:
    eye = np.eye(Q.rows)[None]
    return (
        SumPart(
            unknown=Q,
            left=free,
            right=eye,
            at=at,
            plus_transpose=with_transpose,
            latex=(symbols[0], ""),
        ),
        SumPart(
            unknown=M,
            left=-steered,
            right=eye,
            at=at,
            plus_transpose=with_transpose,
            member=gain_member(M),
            latex=(f"-{symbols[1]}", ""),
            symbol=gain_symbol(M),
        ),
    )


def own(Q: Unknown, at: Position, factor: float = -1.0, latex: str = "-") -> SumPart:
    """Return factor Q in a block on the diagonal."""
    eye = np.eye(Q.rows)[None]
    return SumPart(unknown=Q, left=factor * eye, right=eye, at=at, latex=(latex, ""))


def sum_of(
    plant: DisturbedPlant,
    blocks: tuple[int, ...],
    parts: tuple[SumPart, ...],
    fixed: tuple[KnownBlock, ...],
    *,
    name: str = "",
) -> DoubleSum:
    """Return the double sum over the plant's rules."""
    return DoubleSum(
        rules=len(plant.A),
        blocks=blocks,
        parts=parts,
        fixed=fixed,
        name=name,
        weight=WEIGHT,
        corners=corners_of(plant),
    )


def decay_sum(plant: DisturbedPlant, Q: Unknown, M: Unknown) -> DoubleSum:
    """Return the sum that gives V' <= -2 alpha V, or V(x+) <= e^(-2 alpha T) V, without w."""
    loop = closed_loop(
        plant.A,
        plant.B,
        Q,
        M,
        weight=WEIGHT * root_share(plant) ** 2,
        discrete=plant.sample_time is not None,
        corners=corners_of(plant),
    )
    return replace(loop, name="decay")


def source_of(plant: DisturbedPlant, source: str) -> str:
    """Return the source, with what the bars in the formula stand for where there are some."""
    return source if plant.sample_time is None else f"{source}; {BARS}"
