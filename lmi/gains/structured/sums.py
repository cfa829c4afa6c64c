r"""A closed loop u = -sum_j h_j K_j x in V = x' P x and K, both unknown: the inner convex step.

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

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.argument_checks import corners_of
from takagi.lmi.condition.term import Array, Position
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.structured.structure import Structure
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.summands import KnownBlock, SumPart
from takagi.models.arrays import Floats

Objective: TypeAlias = Literal["decay_rate", "cost", "hinf"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StructuredGains:
    """The gains K_j of a double sum: known ones, or unknown ones near them.

    Attributes
    ----------
    reference : L_j, (r, m, n).
    structure : the structure of the unknown gains, its C in the plant's states; None where
        K_j = L_j.
    unknowns : the free entries of the structure, in the coordinates of ``LocalUnits``.
    spread : s of the overbound; with a larger s K may move further, and P less.
    """

    reference: Floats
    structure: Structure | None = None
    unknowns: tuple[Unknown, ...] = ()
    spread: float = 1.0

    def parts(
        self, through: Array, at: Position, *, with_transpose: bool, factor: float
    ) -> list[SumPart]:
        """Return factor * through_i K_j in a block, as a part for each row of unknowns."""
        assert self.structure is not None
        return [
            SumPart(
                unknown=row,
                left=factor * through[:, :, [k]],
                right=self.structure.C[self.structure.pattern[k]][None],
                at=at,
                plus_transpose=with_transpose,
                member=self.structure.member,
            )
            for k, row in zip(self.structure.rows, self.unknowns, strict=True)
        ]


def loop_sum(
    plant: DisturbedPlant,
    objective: Objective,
    P: Unknown,
    gamma: Unknown | None,
    gains: StructuredGains,
) -> DoubleSum:
    """Return the module's double sum.

    Parameters
    ----------
    gamma : the unknown of the energy gain; None for the other objectives.
    gains : known gains give a sum in P alone; unknown ones that of the inner convex step at P = I.
    """
    n, m = plant.B.shape[1:]
    step = plant.sample_time is not None
    q = plant.E.shape[2] if objective == "hinf" else 0
    p = plant.C.shape[1] if objective != "decay_rate" else 0
    sizes = {"state": n, "disturbance": q, "next": n if step else 0, "output": p}
    sizes["step"] = m if gains.structure is not None else 0
    names = [name for name, size in sizes.items() if size]
    where = {name: k for k, name in enumerate(names)}
    motion_row = where["next" if step else "state"]
    parts, fixed = _motion(plant, objective, P, gains, motion_row, step)
    if objective == "hinf":
        assert gamma is not None
        eye = np.eye(n)[None]
        parts.append(
            SumPart(unknown=P, left=eye, right=plant.E, at=(motion_row, where["disturbance"]))
        )
        parts += [_minus(gamma, q, where["disturbance"]), _minus(gamma, p, where["output"])]
        fixed.append(KnownBlock(value=plant.D11, at=(where["output"], where["disturbance"])))
    elif objective == "cost":
        fixed.append(KnownBlock(value=-np.eye(p)[None], at=(where["output"],) * 2))
    if p:
        added_parts, added_blocks = _shown(plant, gains, (where["output"], 0))
        parts, fixed = parts + added_parts, fixed + added_blocks
    if gains.structure is not None:
        added_parts, added_blocks = _overbound(plant, P, gains, where["step"], motion_row)
        parts, fixed = parts + added_parts, fixed + added_blocks
    return DoubleSum(
        rules=len(plant.A),
        blocks=tuple(sizes[name] for name in names),
        parts=tuple(parts),
        fixed=tuple(fixed),
        corners=corners_of(plant),
    )


def _motion(
    plant: DisturbedPlant,
    objective: Objective,
    P: Unknown,
    gains: StructuredGains,
    motion_row: int,
    step: bool,
) -> tuple[list[SumPart], list[KnownBlock]]:
    """Return P G_ij, linear about (I, L), and the terms of V that are added to it."""
    eye = np.eye(P.rows)[None]
    steered = plant.B[:, None] @ gains.reference
    loop = plant.A[:, None] - steered
    parts = [
        SumPart(
            unknown=P, left=eye, right=_table(loop), at=(motion_row, 0), plus_transpose=not step
        )
    ]
    fixed = []
    if gains.structure is not None:
        parts += gains.parts(plant.B, (motion_row, 0), with_transpose=not step, factor=-1.0)
        symmetrised = steered if step else steered + steered.transpose(0, 1, 3, 2)
        fixed.append(KnownBlock(value=_table(symmetrised), at=(motion_row, 0)))
    decay = objective == "decay_rate"
    if step:
        rate = "contraction" if decay else None
        parts.append(SumPart(unknown=P, left=-eye, right=eye, parameter=rate))
        parts.append(SumPart(unknown=P, left=-eye, right=eye, at=(motion_row, motion_row)))
    elif decay:
        parts.append(SumPart(unknown=P, left=2.0 * eye, right=eye, parameter="alpha"))
    return parts, fixed


def _shown(
    plant: DisturbedPlant, gains: StructuredGains, at: Position
) -> tuple[list[SumPart], list[KnownBlock]]:
    """Return the output Z_ij, as parts and known blocks."""
    if gains.structure is None:
        output = plant.C[:, None] - plant.D12[:, None] @ gains.reference
        return [], [KnownBlock(value=_table(output), at=at)]
    parts = gains.parts(plant.D12, at, with_transpose=False, factor=-1.0)
    return parts, [KnownBlock(value=plant.C, at=at)]


def _overbound(
    plant: DisturbedPlant, P: Unknown, gains: StructuredGains, row: int, motion_row: int
) -> tuple[list[SumPart], list[KnownBlock]]:
    """Return the block row s B' (P - I) - (K - L) / s, with -2 I on its diagonal."""
    m, s = plant.B.shape[2], gains.spread
    reach = s * plant.B.transpose(0, 2, 1)
    eye, input_eye = np.eye(P.rows)[None], np.eye(m)[None]
    parts = [SumPart(unknown=P, left=reach, right=eye, at=(row, motion_row))]
    parts += gains.parts(input_eye, (row, 0), with_transpose=False, factor=-1.0 / s)
    gain_table = (
        np.broadcast_to(gains.reference[None], (len(reach), *gains.reference.shape)).copy() / s
    )
    fixed = [
        KnownBlock(value=-reach, at=(row, motion_row)),
        KnownBlock(value=_table(gain_table), at=(row, 0)),
        KnownBlock(value=-2.0 * input_eye, at=(row, row)),
    ]
    return parts, fixed


def _minus(gamma: Unknown, size: int, block: int) -> SumPart:
    return SumPart(unknown=gamma, left=-np.eye(size)[None], at=(block, block))


def _table(array: Array) -> Array:
    """Return (r, r, p, q), or (1, p, q) of a single rule, as a double sum takes it."""
    return array[0] if len(array) == 1 else array
