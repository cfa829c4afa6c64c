r"""The LMIs of the peak-to-peak gain under parallel distributed compensation.

With Q = P^-1, M_j = K_j Q, u = -sum_j h_j K_j x, Z_ij = C_i Q - D12_i M_j, one alpha > 0, and
sigma = 2 alpha, or 1 - rho^2 with rho = e^(-alpha T),

    continuous   Theta_ij = [ He(G_ij) + sigma Q   E_i / sqrt(sigma) ]
                            [ .                    -I                ]

    discrete     Theta_ij = [ He(G_ij) + sigma Q   E_i / sqrt(sigma)   G_ij'              ]
                            [ .                    -I                  E_i' / sqrt(sigma) ]
                            [ .                    .                   -Q                 ]

    both           Phi_ij = [ -Q   Z_ij'    ]
                            [ .    -kappa I ]

with G_ij, and a scaling of the first two block rows, as in ``lmi.gains.disturbance.sums``.
sum_ij h_i h_j Theta_ij < 0 gives V' <= sigma (|w|^2 - V), or V(x+) <= rho^2 V + sigma |w|^2, for
V = x' P x: for |w| <= 1 nothing leaves x' P x <= 1, and a trajectory from x = 0 stays inside.
sum_ij h_i h_j Phi_ij < 0 gives |C x + D12 u|^2 <= kappa there, and
|z| <= sqrt(kappa) + max_i |D11_i|.

Source: Abedor, Nagpal, Poolla (1996), Int. J. Robust and Nonlinear Control 6; Boyd, El Ghaoui,
Feron, Balakrishnan (1994), sections 6.1.3 and 7.3, for one gain; Tanaka and Wang (2001).
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.analysis.disturbance.peak_condition import positive_rate
from takagi.lmi.condition.term import Condition, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.disturbance.disturbed_plant import (
    Disturbed,
    DisturbedPlant,
    Performance,
    plant_of,
)
from takagi.lmi.gains.disturbance.sums import (
    disturbance_parts,
    motion_parts,
    output_parts,
    own,
    root_share,
    source_of,
    sum_of,
)
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import Limits, limit_lmis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.sums.summands import KnownBlock, SumPart

SOURCE = (
    "Abedor, Nagpal, Poolla (1996); Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.3; "
    "Tanaka and Wang (2001)"
)


def peak_pdc_condition(
    model: Disturbed | DisturbedPlant,
    *,
    decay_rate: float,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    limits: Limits | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0, sum_ij h_i h_j Phi_ij < 0, Q > 0; kappa is least.

    Parameters
    ----------
    model, performance : the plant, as for ``peak_pdc``.
    decay_rate : alpha in 1/s, positive.  Not a parameter of the condition: it appears in a constant
        too, so another rate is another condition.
    relaxation : how the double sums are made LMIs; see ``relaxations``.
    limits : on inputs, states and gains, in the model's coordinates; those on the ellipsoid hold
        for |w| <= 1.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``Q``, ``M``, ``kappa``
    and those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, an unknown
        relaxation, a decay rate that is not positive.

    Source: Abedor, Nagpal, Poolla (1996); Boyd, El Ghaoui, Feron, Balakrishnan (1994), section
    6.1.3; Tanaka and Wang (2001).
    """
    pose = relaxation_named(relaxation)
    plant = plant_of(model, performance, sample_time)
    rate = positive_rate(decay_rate)
    r, n, m = plant.B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    kappa = Unknown("kappa", 1, 1, latex=r"\kappa")
    slack, invariant = pose(_loop(plant, Q, M, rate))
    more, output = pose(_output(plant, Q, M, kappa))
    own_unknowns, restrictions = limit_lmis(Q, M, limits)
    return Condition(
        name=f"peak-to-peak gain, {relaxation}",
        unknowns=(Q, M, kappa, *slack, *more, *own_unknowns),
        lmis=(positive(Q), *invariant, *output, *restrictions),
        objective={"kappa": np.ones((1, 1, 1))},
        source=source_of(plant, SOURCE),
    )


def _loop(plant: DisturbedPlant, Q: Unknown, M: Unknown, rate: float) -> DoubleSum:
    n, q = Q.rows, plant.E.shape[2]
    step, root = plant.sample_time, root_share(plant)
    sigma = 2.0 * rate if step is None else -float(np.expm1(-2.0 * rate * step))
    share = sigma / root**2
    latex = r"\sigma" if step is None else r"\tfrac{\sigma}s"
    # Divided so that the disturbance's block is I however slow the decay.
    shared, over = float(np.sqrt(share)), rf"\tfrac1{{\sqrt{{{latex}}}}}"
    first = f"{over} E_{{i}}" if step is None else rf"{over} \tfrac1{{\sqrt s}} \bar E_{{i}}"
    parts = (*motion_parts(plant, Q, M, 2), own(Q, (0, 0), share, latex))
    fixed = (
        *disturbance_parts(plant, 0, root**2 * shared, first),
        *(
            disturbance_parts(plant, 2, root * shared, rf"{over} \bar E_{{i}}")
            if step is not None
            else ()
        ),
        KnownBlock(value=-np.eye(q)[None], at=(1, 1), latex="-I"),
    )
    return sum_of(plant, (n, q) if step is None else (n, q, n), parts, fixed)


def _output(plant: DisturbedPlant, Q: Unknown, M: Unknown, kappa: Unknown) -> DoubleSum:
    n, p = Q.rows, plant.C.shape[1]
    bound = SumPart(unknown=kappa, left=-np.eye(p)[None], at=(1, 1), latex=("-", "I"))
    parts = (own(Q, (0, 0)), *output_parts(plant, Q, M, (1, 0), by_share=False), bound)
    return sum_of(plant, (n, p), parts, (), name="output")
