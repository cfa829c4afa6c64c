"""Parallel distributed compensation: one gain a rule, one Lyapunov function for all."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.gains.decay.condition import Controlled, DecayRequest, decay_request
from takagi.lmi.gains.decay.design import design_at
from takagi.lmi.gains.decay.relaxation_search import (
    Goal,
    RelaxationSearch,
    design_at_largest,
    search_relaxations,
)
from takagi.lmi.gains.requirements.limits import GivenLimits
from takagi.lmi.gains.zero_gains import warns_of_zero_gains
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.errors import ModelError


@warns_of_zero_gains
def pdc(
    model: Controlled,
    *,
    decay_rate: Goal = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    region: EigenvalueRegion | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with V' <= -2 alpha V, V = x' P x.

    In discrete time V(x+) <= e^(-2 alpha T) V(x).  First the largest margin (of very many pairs: at
    least half of it) decides whether there are gains; then, at half that margin, those of least
    input effort are taken.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    decay_rate : alpha in 1/s that must hold; or "max", for the largest.  That needs bounded gains
        (gain_bound, or input_limit with initial_box), for without a bound there
        may be no largest; the gains are designed 1e-4 below it.
    relaxation : "common-gain", "wang-tanaka-griffin" (all pairs), "tanaka-wang", "tuan",
        "kim-lee", "liu-zhang" or "polya-<d>", roughly from cheap to rich; "product-<d>" or
        "product-liu-zhang" where premises are known.  "auto" tries one after another, and takes
        the first that has gains (of decay rate "max": of the largest rate).
    input_limit : (m,) with |u_k| <= input_limit_k wherever x' P x <= 1.
    initial_box : (n,) half-widths, 0 for a state at rest; the box lies inside x' P x <= 1.
    state_box : (n,) half-widths, inf for none; x' P x <= 1 lies inside the box.  In discrete time
        nothing is said of a plant between its samples.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition: "max" is the
        largest rate that this condition has, gains of that norm may do better.
    scales : (n,) engineering range of each state; None takes the boxes, or balances.
    sample_time : T in s of x+ = A x + B u; None takes the model's own.
    region : where all eigenvalues lie while the memberships stand still, an
        ``EigenvalueRegion``; in 1/s, of
        x+ = A x without unit.  Of moving memberships it says what its quadratic function does.

    Returns a ``Design``; without gains its answer says which rules bind and what to relax.  The
    answer's ``decay_rate`` is what its unknowns show, at least what was asked for; of "max", its
    ``bound`` is a rate that there are no gains for, to solver accuracy: next to the design's,
    further off where the rates between were not settled, inf where no rate was ruled out (in
    discrete time a loop may reach zero in one step: rates end where V falls by 1e-8 in a sample).
    With "auto" ``ladder`` says what was tried.  Gains that do nothing beside the plant itself bring
    a ``ZeroGainsWarning``.  Nothing is proved here.

    Raises ModelError: shapes, numbers, an unknown relaxation, inputs that are dependent or do
    nothing, a vertex with an unstable mode that no input moves, "max" without bounded gains.

    Source: Tanaka and Wang (2001), chapter 3.
    """
    if relaxation != "auto":
        relaxation_named(relaxation)
    largest = isinstance(decay_rate, str) and decay_rate == "max"
    goal: Goal = "max" if largest else float(number("decay_rate", decay_rate))
    limits = GivenLimits(
        input_limit=input_limit,
        initial_box=initial_box,
        state_box=state_box,
        gain_bound=gain_bound,
        scales=scales,
        sample_time=sample_time,
        region=region,
    )
    task = decay_request(model, limits, decay_rate=0.0 if goal == "max" else goal)
    unbounded = task.limits.inputs is None or task.limits.initial is None
    if goal == "max" and task.limits.gain is None and unbounded:
        raise ModelError(
            'decay_rate is "max", but nothing bounds the gains, so there may be no largest decay '
            "rate; give gain_bound, or input_limit with initial_box"
        )
    if relaxation == "auto":
        return _first_gains(task, goal)
    if goal == "max":
        return design_at_largest(task, relaxation)
    return design_at(task, goal, relaxation)


def _first_gains(task: DecayRequest, goal: Goal) -> Design:
    search = search_relaxations(task, goal)
    best = search.best
    if best is None:
        best = search.designs[-1] if search.no is None else search.no
        reason = _why_none(search, best)
        best = replace(best, relaxation="auto", answer=replace(best.answer, diagnosis=reason))
    return replace(best, ladder=tuple(search.results))


def _why_none(search: RelaxationSearch, last: Design) -> str:
    if search.no is not None:
        return last.answer.diagnosis
    tried = [design.relaxation for design in search.designs]
    not_tried = [result.relaxation for result in search.results if result.status == "not tried"]
    skipped_text = f" (not tried: {', '.join(not_tried)})" if not_tried else ""
    names = ", ".join(tried)
    return f"no gains by any of {names}{skipped_text}; of the last, {last.answer.diagnosis}"
