r"""The loop of given gains as a double sum with one quadratic function; nothing here solves it.

With G_ij = A_i - B_i K_j and V = x' P x,

    continuous   Theta_ij = He(P G_ij) + 2 alpha P
    discrete     Theta_ij = [ -rho^2 P   *  ]
                            [ P G_ij     -P ],     rho = e^(-alpha T)

If sum_ij h_i h_j Theta_ij < 0 for all memberships, then V' <= -2 alpha V, or V(x+) <= rho^2 V(x).
A relaxation replaces the sum by LMIs.  Each relaxation is sufficient; the richer, the less
conservative.

Source: Tanaka, Ikeda and Wang (1998), IEEE Trans. Fuzzy Systems 6(2), theorems 1 and 2; Tanaka and
Wang (2001), sections 2.3 and 3.2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.loop_pairs import gain_stack
from takagi.lmi.argument_checks import (
    corners_of,
    input_stack,
    number,
    rate_parameter,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.term import Array, Condition, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.gains.decay.condition import Controlled, theta_weight
from takagi.lmi.gains.requirements.requirements import Requirements, requirements_of
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.membership_shape import with_overlap
from takagi.lmi.sums.relaxations import Relaxation, relaxation_named
from takagi.lmi.sums.summands import SumPart
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GivenLoop:
    """G_ij = A_i - B_i K_j, with the known bounds of the memberships.

    Attributes
    ----------
    G : (r, r, n, n), in the states xhat of x = s xhat.
    gains : (r, m, n), in the model's units.
    sample_time : T in s; None for continuous time.
    corners : as in ``DoubleSum``.
    known : bounds on products of memberships, number of active rules.
    s : (n,), scales of the states.
    """

    G: Array
    gains: Array
    sample_time: float | None
    corners: Corners | None
    known: Requirements
    s: Floats

    @property
    def scheduled(self) -> bool:
        """Return whether the gains differ between the rules."""
        return bool((self.gains != self.gains[:1]).any())

    def scaled(self, scales: ArrayLike | None) -> GivenLoop:
        """Return the loop in states of order one: every number is multiplied by a power of two."""
        n = self.G.shape[2]
        G = self.G.astype(np.float64)
        s = state_units(motion(G.reshape(-1, n, n), self.sample_time), scales)
        return replace(self, G=G * s / s[:, None], s=self.s * s)

    def double_sum(self, P: Unknown, alpha: float) -> DoubleSum:
        """Return the module's Theta_ij."""
        r, _, n, _ = self.G.shape
        one = np.eye(n)
        every = np.broadcast_to(one, (r, r, n, n))
        discrete = self.sample_time is not None
        moved = SumPart(
            unknown=P,
            left=every,
            right=self.G,
            at=(1, 0) if discrete else (0, 0),
            plus_transpose=not discrete,
            latex=("", "G_{{i}{j}}"),
        )
        if discrete:
            rest = [
                SumPart(
                    unknown=P,
                    left=-one[None],
                    right=one[None],
                    parameter="contraction",
                    latex=(r"-\rho^2", ""),
                ),
                SumPart(unknown=P, left=-one[None], right=one[None], at=(1, 1), latex=("-", "")),
            ]
        else:
            rest = [
                SumPart(
                    unknown=P,
                    left=2.0 * one[None],
                    right=one[None],
                    parameter="alpha",
                    latex=(r"2\alpha", ""),
                )
            ]
        return DoubleSum(
            rules=r,
            blocks=(n, n) if discrete else (n,),
            parts=(moved, *rest),
            weight=theta_weight(self.G.reshape(-1, n, n), alpha, self.sample_time),
            corners=self.corners,
        )

    def condition(self, decay_rate: float, relaxation: str | Relaxation) -> Condition:
        """Return the LMIs at a decay rate."""
        name = relaxation if isinstance(relaxation, str) else ""
        pose = relaxation if callable(relaxation) else relaxation_named(relaxation)
        P = Unknown("P", self.G.shape[2], self.G.shape[2], symmetric=True)
        loop, more, bounds = with_overlap(
            self.double_sum(P, decay_rate),
            self.known.overlap,
            active_rules=self.known.active_rules,
        )
        slack, lmis = pose(loop)
        return Condition(
            name=", ".join(part for part in ("loop of given gains", name) if part),
            unknowns=(P, *more, *slack),
            lmis=(positive(P), bounded(P), *lmis, *bounds),
            parameters=rate_parameter(decay_rate, self.sample_time),
            source="Tanaka, Ikeda and Wang (1998), theorems 1 and 2; Tanaka and Wang (2001)",
        )


def given_loop(
    model: Controlled,
    gains: ArrayLike,
    *,
    overlap: ArrayLike | None = None,
    active_rules: int | None = None,
    sample_time: float | None = None,
) -> GivenLoop:
    """Return the loop in the model's own units; arguments as for ``closed_loop_decay``.

    Raises
    ------
    ModelError : shapes, numbers, inputs that are dependent or do nothing, a sample time that is not
        positive or not the model's, bounds that no memberships satisfy.
    """
    A = vertex_stack(model)
    B = input_stack(model, A)
    r, n, m = B.shape
    K = gain_stack(gains, r, m, n)
    known = requirements_of(
        r, n, m, region=None, uncertainty=None, overlap=overlap, active_rules=active_rules
    )
    return GivenLoop(
        G=np.asarray(A[:, None] - B[:, None] @ K[None]),
        gains=np.asarray(K),
        sample_time=sample_time_of(model, sample_time),
        corners=corners_of(model),
        known=known,
        s=np.ones(n),
    )


def closed_loop_condition(
    model: Controlled,
    gains: ArrayLike,
    *,
    decay_rate: float = 0.0,
    relaxation: str | Relaxation = "wang-tanaka-griffin",
    overlap: ArrayLike | None = None,
    active_rules: int | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0 for given gains by one relaxation, with P > 0.

    Parameters
    ----------
    model, gains, overlap, active_rules, sample_time : as for ``closed_loop_decay``.
    decay_rate : alpha in 1/s.
    relaxation : name of a relaxation, see ``relaxations``; or a function that poses the sum.

    Returns
    -------
    The condition, in the model's coordinates as they are.  Nothing is solved.

    Raises
    ------
    ModelError : as ``closed_loop_decay``.

    Source: Tanaka, Ikeda and Wang (1998), theorems 1 and 2; Tanaka and Wang (2001), section 3.2.
    """
    loop = given_loop(
        model, gains, overlap=overlap, active_rules=active_rules, sample_time=sample_time
    )
    return loop.condition(float(number("decay_rate", decay_rate)), relaxation)
