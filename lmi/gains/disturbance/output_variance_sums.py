r"""The LMIs of the output's variance (H2 norm) under parallel distributed compensation.

With Q = P^-1, M_j = K_j Q, u = -sum_j h_j K_j x, Z_ij = C_i Q - D12_i M_j, G_ij and a scaling of
the first block row as in ``lmi.gains.disturbance.sums``,

    continuous   Theta_ij = [ He(G_ij)   Z_ij' ]          [ W_i   E_i' ]
                            [ .          -I    ],         [ .     Q    ]  > 0

    discrete     Theta_ij = [ He(G_ij)   G_ij'   Z_ij' ]  [ W_i   E_i'   D11_i' ]
                            [ .          -Q      0     ]  [ .     Q      0      ]  > 0
                            [ .          .       -I    ], [ .     .      I      ]

and trace W_i < nu at every vertex, nu least.  sum_ij h_i h_j Theta_ij < 0 gives V' <= -|z|^2, or
V(x+) - V(x) <= -|z|^2, without w for V = x' P x, and W_i > E_i' P E_i (+ D11_i' D11_i).  So the
mean of |z|^2 is at most nu for white noise, as in
``takagi.lmi.analysis.disturbance.output_variance``, which says what that means where the
memberships vary.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4, for one gain; Scherer
and Weiland (2000), Linear Matrix Inequalities in Control; Tanaka and Wang (2001), the double sum.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.analysis.disturbance.output_variance import infinite_variance
from takagi.lmi.argument_checks import number, rate_parameter
from takagi.lmi.condition.term import LMI, Condition, Constant, Term, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.disturbance.disturbed_plant import (
    Disturbed,
    DisturbedPlant,
    Performance,
    plant_of,
)
from takagi.lmi.gains.disturbance.sums import (
    WEIGHT,
    decay_sum,
    motion_parts,
    output_parts,
    source_of,
    sum_of,
)
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import Limits, limit_lmis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.sums.summands import KnownBlock
from takagi.models.errors import ModelError

SOURCE = (
    "Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4; Tanaka and Wang (2001)"
)


def h2_pdc_condition(
    model: Disturbed | DisturbedPlant,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    limits: Limits | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose the module's LMIs and Q > 0; the objective is nu, the bound on the mean of |z|^2.

    Parameters
    ----------
    model, performance : the plant, as for ``h2_pdc``.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    decay_rate : alpha in 1/s of the undisturbed loop, a double sum of its own where positive.
    limits : on the gains only; the size of V is that of the cost, so there is no ellipsoid whose
        level could be chosen.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``Q``, ``M``, ``W``,
    ``nu`` and those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, an unknown
        relaxation, a feed-through of white noise in continuous time, limits on the ellipsoid.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4.
    """
    pose = relaxation_named(relaxation)
    plant = plant_of(model, performance, sample_time)
    why = infinite_variance(plant.D11, plant.sample_time)
    if limits is not None and limits.level:
        why = "limits on the ellipsoid x' P x <= 1 do not go with a variance; give a gain bound"
    if why:
        raise ModelError(why)
    alpha = number("decay_rate", decay_rate)
    r, n, m = plant.B.shape
    q = plant.E.shape[2]
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    W = Unknown("W", q, q, symmetric=True, count=r)
    nu = Unknown("nu", 1, 1, latex=r"\nu")
    slack, sums = pose(_loop(plant, Q, M))
    more, decay = pose(decay_sum(plant, Q, M)) if alpha > 0 else ((), ())
    own_unknowns, restrictions = limit_lmis(Q, M, limits)
    return Condition(
        name=f"output variance, {relaxation}",
        unknowns=(Q, M, W, nu, *slack, *more, *own_unknowns),
        lmis=(positive(Q), *sums, _entering(plant, Q, W), _total(W, nu), *decay, *restrictions),
        objective={"nu": np.ones((1, 1, 1))},
        parameters=rate_parameter(alpha, plant.sample_time) if alpha > 0 else {},
        source=source_of(plant, SOURCE),
    )


def _loop(plant: DisturbedPlant, Q: Unknown, M: Unknown) -> DoubleSum:
    n, p = Q.rows, plant.C.shape[1]
    blocks = (n, p) if plant.sample_time is None else (n, n, p)
    last = len(blocks) - 1
    one = KnownBlock(value=-np.eye(p)[None], at=(last, last), latex="-I")
    return sum_of(
        plant,
        blocks,
        (*motion_parts(plant, Q, M, 1), *output_parts(plant, Q, M, (last, 0))),
        (one,),
    )


def _entering(plant: DisturbedPlant, Q: Unknown, W: Unknown) -> LMI:
    """Pose W_i > E_i' P E_i, or W_i > E_i' P E_i + D11_i' D11_i in discrete time."""
    r, n, q = plant.E.shape
    one, noise = np.eye(n)[None], np.eye(q)[None]
    p = plant.D11.shape[1]
    constants = [Constant(value=plant.E.transpose(0, 2, 1), at=(0, 1), latex=r"E_{i}^\top")]
    direct = plant.sample_time is not None and bool(plant.D11.any())
    if direct:
        constants += [
            Constant(value=plant.D11.transpose(0, 2, 1), at=(0, 2), latex=r"{D^{11}_{i}}^\top"),
            Constant(value=np.eye(p)[None], at=(2, 2), latex="I"),
        ]
    return LMI(
        name="noise",
        blocks=(q, n, p) if direct else (q, n),
        terms=(
            Term(
                unknown=W,
                left=noise,
                right=noise,
                members=np.arange(r),
                symbol=rf"{W.symbol}_{{i}}",
            ),
            Term(unknown=Q, left=one, right=one, at=(1, 1)),
        ),
        constants=tuple(constants),
        count=r,
        weight=WEIGHT,
        index=rf"i = 1, \dots, {r}",
    )


def _total(W: Unknown, nu: Unknown) -> LMI:
    """Pose nu > trace W_i."""
    r, q = W.count, W.rows
    rule, k = np.divmod(np.arange(r * q), q)
    row = np.eye(q)[k][:, None, :]
    return LMI(
        name="variance",
        blocks=(1,),
        terms=(
            Term(unknown=nu, left=np.ones((1, 1, 1))),
            Term(
                unknown=W,
                left=-row,
                right=row.transpose(0, 2, 1),
                items=rule,
                members=rule,
                latex=(r"-\sum_k e_k^\top", "e_k"),
                symbol=rf"{W.symbol}_{{i}}",
            ),
        ),
        count=r,
        weight=WEIGHT,
        index=rf"i = 1, \dots, {r}",
    )
