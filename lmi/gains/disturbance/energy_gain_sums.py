r"""The LMIs of the energy gain (H-infinity norm) under parallel distributed compensation.

With Q = P^-1, M_j = K_j Q, u = -sum_j h_j K_j x, and Z_ij = C_i Q - D12_i M_j,

    continuous   Theta_ij = [ He(G_ij)   E_i        Z_ij'    ]
                            [ .          -gamma I   D11_i'   ]
                            [ .          .          -gamma I ]

    discrete     Theta_ij = [ He(G_ij)   E_i        G_ij'   Z_ij'    ]
                            [ .          -gamma I   E_i'    D11_i'   ]
                            [ .          .          -Q      0        ]
                            [ .          .          .       -gamma I ]

with G_ij and a scaling of the first block row as in ``lmi.gains.disturbance.sums``.
sum_ij h_i h_j Theta_ij < 0 is, by a congruence with diag(P, I, ...) and a Schur complement, the
bounded real lemma: V', or V(x+) - V(x), is at most gamma |w|^2 - |z|^2 / gamma for V = x' P x.

Where limits are to hold on x' P x <= 1 the size of V matters.  Then the second block is -I and the
last -gamma^2 I, so V' <= |w|^2 - |z|^2 / gamma^2: from rest, x' P x <= 1 for all disturbances of an
energy of at most 1.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5, for one gain; Tanaka and Wang
(2001), for the double sum.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.argument_checks import number, rate_parameter
from takagi.lmi.condition.term import Condition, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.disturbance.disturbed_plant import (
    Disturbed,
    DisturbedPlant,
    Performance,
    plant_of,
)
from takagi.lmi.gains.disturbance.sums import (
    decay_sum,
    disturbance_parts,
    motion_parts,
    output_parts,
    root_share,
    source_of,
    sum_of,
)
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import Limits, limit_lmis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.sums.summands import KnownBlock, SumPart

SOURCE = "Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5; Tanaka and Wang (2001)"


def hinf_pdc_condition(
    model: Disturbed | DisturbedPlant,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    limits: Limits | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0 and Q > 0; the objective is gamma.

    Parameters
    ----------
    model, performance : the plant, as for ``hinf_pdc``.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    decay_rate : alpha in 1/s of the undisturbed loop, a double sum of its own where positive.
    limits : on inputs, states and gains, in the model's coordinates; those on the ellipsoid hold
        for disturbances of an energy of at most 1, and the objective is then gamma^2.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``Q``, ``M``, and
    ``gamma`` (``gamma2``, its square, with limits on the ellipsoid), and those of the relaxation.
    Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, an unknown
        relaxation.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5; Tanaka and Wang (2001).
    """
    pose = relaxation_named(relaxation)
    plant = plant_of(model, performance, sample_time)
    alpha = number("decay_rate", decay_rate)
    r, n, m = plant.B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    level = limits is not None and limits.level
    gamma = Unknown("gamma2", 1, 1, latex=r"\gamma^2") if level else _gamma()
    slack, sums = pose(_loop(plant, Q, M, gamma, unit_energy=level))
    more, decay = pose(decay_sum(plant, Q, M)) if alpha > 0 else ((), ())
    own_unknowns, restrictions = limit_lmis(Q, M, limits)
    return Condition(
        name=f"energy gain, {relaxation}",
        unknowns=(Q, M, gamma, *slack, *more, *own_unknowns),
        lmis=(positive(Q), *sums, *decay, *restrictions),
        objective={gamma.name: np.ones((1, 1, 1))},
        parameters=rate_parameter(alpha, plant.sample_time) if alpha > 0 else {},
        source=source_of(plant, SOURCE),
    )


def _gamma() -> Unknown:
    return Unknown("gamma", 1, 1, latex=r"\gamma")


def _loop(
    plant: DisturbedPlant, Q: Unknown, M: Unknown, gamma: Unknown, *, unit_energy: bool
) -> DoubleSum:
    """Return the module's double sum; with -I for w, and -gamma I for z alone, on request."""
    n, q, p = Q.rows, plant.E.shape[2], plant.C.shape[1]
    step = plant.sample_time
    # The states, their disturbance, the next states where there are such, the output.
    blocks = (n, q, p) if step is None else (n, q, n, p)
    last = len(blocks) - 1
    parts: tuple[SumPart, ...] = (
        *motion_parts(plant, Q, M, 2),
        *output_parts(plant, Q, M, (last, 0)),
        _minus(gamma, p, last),
    )
    fixed = [
        *disturbance_parts(plant, 0, root_share(plant), "E_{i}" if step is None else r"\bar E_{i}"),
        *(disturbance_parts(plant, 2) if step is not None else ()),
        KnownBlock(value=plant.D11, at=(last, 1), latex="D^{11}_{i}"),
    ]
    if unit_energy:
        fixed.append(KnownBlock(value=-np.eye(q)[None], at=(1, 1), latex="-I"))
    else:
        parts = (*parts, _minus(gamma, q, 1))
    return sum_of(plant, blocks, parts, tuple(fixed))


def _minus(gamma: Unknown, size: int, block: int) -> SumPart:
    return SumPart(unknown=gamma, left=-np.eye(size)[None], at=(block, block), latex=("-", "I"))
