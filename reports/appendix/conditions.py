"""The matrix inequalities of a design, typeset from the conditions that were solved."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from takagi.certificates.claims.turbine.largest_wind_error import EffortSharingCandidate
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.typeset import latex
from takagi.reports.appendix.tex import Tex, escape


def conditions_context(design: TurbineDesign) -> dict[str, object]:
    """Return every condition as a list of labelled formulas, with a remark on its symbols."""
    return {"conditions": list(_conditions(design))}


def laid_out(condition: Condition) -> list[tuple[Tex, Tex]]:
    r"""Return (label, formula) per line of ``lmi.condition.typeset.latex``.

    A label may be as long as a sentence.  To the left of a block matrix it would push the matrix
    off the page, so each label is set above its formula.
    """
    body = latex(condition)
    body = body.removeprefix("\\begin{align*}\n").removesuffix("\n\\end{align*}")
    lines = []
    for line in body.split(" \\\\\n"):
        label, formula = line.split(r" \quad & ", 1)
        words = label.removeprefix(r"\text{").removesuffix("}").removesuffix(":")
        lines.append((escape(words), Tex(formula)))
    return lines if not condition.objective else [_one_line(*lines[:2]), *lines[2:]]


def _one_line(cost: tuple[Tex, Tex], unknowns: tuple[Tex, Tex]) -> tuple[Tex, Tex]:
    return cost[0], Tex(rf"{cost[1]} \quad\text{{over}}\quad {unknowns[1]}")


def _conditions(design: TurbineDesign) -> Iterator[dict[str, object]]:
    for region in (design.regional.partial, design.regional.full):
        yield _entry(
            f"Gains of the {region.region} region",
            region.condition,
            "Scaled states and input; $Q = P^{-1}$, $M_i = K_i Q$, $u = -\\sum_i h_i K_i x$. "
            "$\\kappa$ only bounds the unknowns, $\\bar x_k$ is the half width of the model's box, "
            "$\\bar u_k$ and $\\bar r$ are actuator limits, $c$ selects the pitch deviation where "
            "a rate is bounded and is zero otherwise. $B$ is the same in all rules, so the double "
            "sum over rules reduces to these inequalities.",
        )
    yield _entry("Gains of the wind observer", _observer(design), _OBSERVER)
    if design.effort_sharing_law is not None and design.effort is not None:
        yield _entry("Gains of the effort-sharing law", _effort(design), _EFFORT)
    if design.candidate is not None and design.candidate.P is not None:
        yield _entry(
            "Joint analysis of the blended loop", _invariance(design.candidate), _INVARIANCE
        )


_OBSERVER = (
    "The dual problem: $A_i$ and $B_j$ stand for the transposes of the error system's matrix and "
    "output matrix, and $L = Q^{-1} M^\\top$ is the observer's gain."
)
_EFFORT = (
    "One such problem per wind node, in states and effort divided by their ranges; $A_i$, $B_i$ "
    "are the loop $\\dot e = a e - G u$, $\\dot x_I = -e$ at the extreme values of $a$ and of the "
    "inertia. The trace of $W$ is the mean cost over the unit sphere, times the number of states."
)
_INVARIANCE = (
    "$\\alpha_k$ is fixed while $P$ and $\\eta$ are sought, then improved in turn; $k$ runs over "
    "the corners of all wind cells. The solver sees a growing subset of the corners, and every "
    "corner is looked at before $P$ is accepted. Here floating point only proposes: the rounded "
    "$P$ of the certificate is proved separately, in exact arithmetic."
)


def _entry(title: str, condition: Condition, remark: str) -> dict[str, object]:
    return {
        "title": title,
        "source": condition.source,
        "lines": laid_out(condition),
        "remark": Tex(remark),
    }


def _observer(design: TurbineDesign) -> Condition:
    from takagi.lmi.gains.observer import observer_condition

    return observer_condition(
        design.observer.model, decay_rate=design.observer.decay_rate, relaxation="common-gain"
    )


def _effort(design: TurbineDesign) -> Condition:
    """Return the guaranteed-cost condition of the first wind node; all nodes share its form."""
    from takagi.lmi.gains.cost.regulator import guaranteed_cost_condition
    from takagi.lmi.turbine.effort import EffortSettings

    if design.effort is None:
        raise ValueError("a design without effort gains has no guaranteed-cost condition")
    asked = design.settings.effort or EffortSettings()
    stiffness = design.effort.stiffness[0]
    A = [[[a, 0.0], [-1.0, 0.0]] for a in stiffness for _ in asked.inertia]
    B = [[[-1 / inertia], [0.0]] for _ in stiffness for inertia in asked.inertia]
    return guaranteed_cost_condition(np.array(A), np.array(B))


def _invariance(candidate: EffortSharingCandidate) -> Condition:
    """Return the invariance condition over all corners, at the claim's winds and multipliers."""
    from takagi.lmi.analysis.invariant_ellipsoid import invariant_ellipsoid_condition
    from takagi.models.laws.effort_sharing.loop_cell import loop_vertices

    corners = [loop_vertices(cell) for cell in candidate.cells]
    d = [
        v.fixed + candidate.wind_error[k] * v.per_wind_error
        for k, v in enumerate(corners)
    ]  # fmt: skip
    box = candidate.box
    e, z, y = (float(b) for b in (box.speed_error, box.effort_lag, box.speed_signal))
    return invariant_ellipsoid_condition(
        np.concatenate([v.A for v in corners]),
        np.concatenate(d),
        np.repeat(candidate.multipliers, [len(v.A) for v in corners]),
        np.array([[1 / e, 0, 0], [0, 1 / z, 0], [1 / y, 0, -1 / y]]),
    )
