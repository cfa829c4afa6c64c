"""Stability, decay and regions of a given loop."""

from __future__ import annotations

from functools import partial

import numpy as np

from catalogue.entry import FEW, SQUARES, Case, Entry, Sizes, plant
from takagi.lmi import (
    Condition,
    EigenvalueRegion,
    NormBounded,
    attraction_level_condition,
    common_lyapunov_condition,
    d_stability_condition,
    fuzzy_lyapunov_condition,
    polynomial_lyapunov_condition,
    robust_lyapunov_condition,
)

P = "n*(n+1)/2"


def _common(sizes: Sizes, step: float | None) -> Condition:
    return common_lyapunov_condition(plant(sizes, step))


def _region(sizes: Sizes) -> Condition:
    region = (
        EigenvalueRegion.half_plane(1)
        & EigenvalueRegion.disc(9)
        & EigenvalueRegion.sector(np.pi / 6)
    )
    return d_stability_condition(plant(sizes), region)


def _bounded(sizes: Sizes, step: float | None) -> Condition:
    block = NormBounded(np.eye(sizes.n)[:, :2] / 16, np.eye(sizes.n)[:2] / 16)
    # Slow vertices: the condition then measures the blocks in units of one.
    return robust_lyapunov_condition(plant(sizes).A / 4, block, sample_time=step)


def _polynomial(sizes: Sizes, step: float | None, form: str) -> Condition:
    return polynomial_lyapunov_condition(plant(sizes, step), form=form)  # type: ignore[arg-type]


def _fuzzy(sizes: Sizes, step: float | None) -> Condition:
    return fuzzy_lyapunov_condition(plant(sizes, step), rate_bounds=np.inf if step else 1.0)


def _level(sizes: Sizes) -> Condition:
    return attraction_level_condition(
        ["-x2", "x1 + (x1**2 - 1)*x2"], "1.5*x1**2 - x1*x2 + x2**2", states=["x1", "x2"]
    )


LEVEL = Entry(
    title="Level of a polynomial function inside the region of attraction",
    question="Which level set of a polynomial $V$ lies in the region of attraction of $x' = f(x)$?",
    call="attraction_level",
    builder="attraction_level_condition",
    use=(
        "For polynomial equations, without a box or a model: $V$ is positive, and $r\\,(V - "
        "c) - \\lambda \\dot V$ and $\\lambda$ are sums of squares for a known weight $r \\ge 0$. "
        "Where $r$ is 0 away from 0, LaSalle's theorem has to decide; else only "
        "`invariant_level` is given. `proved` rests on exact arithmetic. Continuous time only."
    ),
    cases=(
        Case(
            title="Continuous time, van der Pol's oscillator, $\\lambda$ of degree 2",
            pose=_level,
            lmis="4",
            variables="55",
            where="$p_{kij}$, $q_k$ are the coefficients of the monomial $x^k$",
            sizes=SQUARES,
        ),
    ),
)

COMMON = Entry(
    title="Common quadratic Lyapunov function",
    question="Does one $V = x^\\top P x$ decay at a given rate along every blend of the vertices?",
    call="common_lyapunov",
    builder="common_lyapunov_condition",
    use=(
        "The first thing to ask of a closed loop. The memberships may move in any way. No "
        "common $P$ does not mean unstable. `max_decay_rate` finds the largest $\\alpha$, a "
        "generalised eigenvalue."
    ),
    cases=(
        Case(title="Continuous time", pose=partial(_common, step=None), lmis="r + 2", variables=P),
        Case(
            title="Discrete time",
            pose=partial(_common, step=0.1),
            lmis="r + 2",
            variables=P,
        ),
    ),
)

REGION = Entry(
    title="Eigenvalues in a region (D-stability)",
    question="Does every frozen blend have all its eigenvalues in a region of the complex plane?",
    call="d_stability",
    builder="d_stability_condition",
    use=(
        "Half-planes, strips, discs, sectors, ellipses, parabolas, any LMI region, and "
        "intersections by `&`. It is about constant memberships; for varying ones only the "
        "decay rate follows."
    ),
    cases=(
        Case(
            title="For the region Re z < -1, |z| < 9, |arg(-z)| < 30°",
            pose=_region,
            lmis="3*r + 2",
            variables=P,
        ),
    ),
)

NORM_BOUNDED = Entry(
    title="Norm-bounded uncertainty",
    question=(
        "Does one quadratic function decay for every blend and every "
        "$\\lVert\\Delta_k\\rVert \\le 1$ in $A_i + \\sum_k D_{ki} \\Delta_k E_{ki}$?"
    ),
    call="robust_lyapunov",
    builder="robust_lyapunov_condition",
    use=(
        "The $\\Delta_k$ may be any functions of time and state. `pdc(..., uncertainty=...)` "
        "designs gains for it. For one block with the same $D$ or the same $E$ at all vertices "
        "a no excludes every $P$; otherwise it excludes $P$ with these multipliers."
    ),
    cases=(
        Case(
            title="Continuous time, one block",
            pose=partial(_bounded, step=None),
            lmis="2*r + 2",
            variables=f"{P} + r",
            where=(
                "$D$ or $E$ is the same in all rules there is one multiplier a rule, as here; else "
                "one for all, and $r + 3$ LMIs"
            ),
        ),
        Case(
            title="Discrete time, one block",
            pose=partial(_bounded, step=0.1),
            lmis="2*r + 2",
            variables=f"{P} + r",
            shown=False,
        ),
    ),
)

POLYNOMIAL = Entry(
    title="Polynomial Lyapunov function for constant parameters",
    question="Is every blend stable, with $P(h)$ a polynomial in constant memberships?",
    call="polynomial_lyapunov",
    builder="polynomial_lyapunov_condition",
    use=(
        "With growing `degree` and `polya` every stable family is found. It says nothing of "
        "varying memberships. A model with premises has a simplex for each of them."
    ),
    cases=(
        Case(
            title="Continuous time, degree 1",
            pose=partial(_polynomial, step=None, form="direct"),
            lmis="2*r + r*(r+1)/2",
            variables=f"r*{P}",
            where="each coefficient of the polynomial in $h$ is an LMI",
        ),
        Case(
            title="Continuous time, dilated form",
            pose=partial(_polynomial, step=None, form="dilated"),
            lmis="3*r",
            variables=f"r*{P} + 2*n*n",
            shown=False,
        ),
        Case(
            title="Discrete time, degree 1",
            pose=partial(_polynomial, step=0.1, form="direct"),
            lmis="2*r + r*(r+1)/2",
            variables=f"r*{P}",
            shown=False,
        ),
        Case(
            title="Discrete time, dilated form",
            pose=partial(_polynomial, step=0.1, form="dilated"),
            lmis="3*r",
            variables=f"r*{P} + n*n",
            shown=False,
        ),
    ),
)

FUZZY = Entry(
    title="Fuzzy Lyapunov function with bounded rates",
    question="Does $V = x^\\top P(h) x$ decay while the rates of the memberships are bounded?",
    call="fuzzy_lyapunov",
    builder="fuzzy_lyapunov_condition",
    use=(
        "Where there is no common $P$, and bounds on $\\lvert\\dot z_k\\rvert$ (with premises) "
        "or $\\lvert\\dot h_i\\rvert$ (without) are known; `inf` for none. In discrete time "
        "steps may be free. The bounds are assumptions about the loop: check that it keeps "
        "them. `relaxation`, `form` and `rates` choose among published forms."
    ),
    cases=(
        Case(
            title="Continuous time, two rules",
            pose=partial(_fuzzy, step=None),
            variables=f"r*{P}",
            where=(
                "$\\dot P(h)$ is taken at every corner of the rates: $2^k$ for $k$ premises, more "
                "with every rule"
            ),
            sizes=FEW,
        ),
        Case(
            title="Discrete time, steps of any size, two rules",
            pose=partial(_fuzzy, step=0.1),
            variables=f"r*{P}",
            sizes=FEW,
            shown=False,
        ),
    ),
)

ENTRIES = (COMMON, REGION, NORM_BOUNDED, POLYNOMIAL, FUZZY, LEVEL)
