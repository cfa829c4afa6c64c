r"""What the conditions on a disturbed loop are made of, with Q = P^-1, M_j = K_j Q, u = -K x.

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

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.argument_checks import corners_of, decay_parameter
from takagi.lmi.condition.statements import pose, positive_definite
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, nearest_power
from takagi.lmi.expressions.expression import Expression, Parameter, matrix
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.requirements.closed_loop import closed_loop, region_sums
from takagi.lmi.gains.requirements.limits import Limits, limit_lmis
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named

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
