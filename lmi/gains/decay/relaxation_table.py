"""The ladder of relaxations as a table: the cost and the result of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from takagi.lmi.answer import Design
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.uncertainty import Uncertainty
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.decay.pdc import require_bounded_gains
from takagi.lmi.gains.decay.relaxation_search import (
    Goal,
    default_relaxations,
    goal_of,
    search_relaxations,
)
from takagi.lmi.gains.decay.request import decay_request
from takagi.lmi.gains.requirements.given_limits import GivenLimits
from takagi.lmi.relaxation_result import RelaxationResult
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.errors import ModelError

HEADS = (
    "relaxation",
    "status",
    "LMIs",
    "variables",
    "width",
    "time [s]",
    "margin",
    "rate [1/s]",
    "note",
)


@dataclass(frozen=True, slots=True, eq=False)
class Ladder:
    """Relaxations of one design, in the order in which they were tried.

    Attributes
    ----------
    results : one each; "any relaxation" is the condition at single blends, which each implies.
    best : the design of the largest decay rate that was asked for, by the cheapest relaxation that
        has it; None without gains.
    """

    results: tuple[RelaxationResult, ...]
    best: Design | None

    @property
    def rows(self) -> tuple[Mapping[str, object], ...]:
        """Return the table, one mapping from the heads for each relaxation."""
        return tuple(dict(zip(HEADS, _cells(result), strict=True)) for result in self.results)

    def __str__(self) -> str:
        lines = [HEADS, *(tuple(_text(cell) for cell in _cells(result)) for result in self.results)]
        widths = [max(len(line[k]) for line in lines) for k in range(len(HEADS))]
        # Numbers to the right, words to the left.
        left = {0, 1, len(HEADS) - 1}
        return "\n".join(
            "  ".join(
                cell.ljust(wide) if k in left else cell.rjust(wide)
                for k, (cell, wide) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        )


def relaxation_ladder(
    model: Controlled,
    *,
    decay_rate: Goal = 0.0,
    relaxations: Sequence[str] | None = None,
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    initial_ball: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    region: EigenvalueRegion | None = None,
    uncertainty: Uncertainty | None = None,
    overlap: ArrayLike | None = None,
    active_rules: int | None = None,
) -> Ladder:
    """Return, for each relaxation, its size, its time, and what it has: gains, or the largest rate.

    Parameters
    ----------
    decay_rate : alpha in 1/s, then a row says whether the relaxation has gains; or "max", then how
    fast they
        can be, for bounded gains (see ``pdc``).
    relaxations : by name, in the order in which they are tried; None takes all that apply, by
        the work of one iteration of the solver, Polya's up to degree 8.
    model and the others : as for ``pdc``.

    A relaxation that is too large, by an estimate made before it is posed, is left out, and its row
    reports that; so is one that another relaxation, or the condition at single blends, has settled
    by a theorem.

    Not promised: that a relaxation without gains has none in exact arithmetic (``rigorous_no`` of a
    single design may prove that); times are those of one run.

    Raises
    ------
    ModelError : as ``pdc``; no relaxations, or one twice.
    """
    names = None if relaxations is None else checked_names(relaxations)
    goal = goal_of(decay_rate)
    given = GivenLimits(
        input_limit=input_limit,
        initial_box=initial_box,
        initial_ball=initial_ball,
        state_box=state_box,
        gain_bound=gain_bound,
        scales=scales,
        sample_time=sample_time,
        region=region,
        uncertainty=uncertainty,
        overlap=overlap,
        active_rules=active_rules,
    )
    task = decay_request(model, given, decay_rate=0.0 if goal == "max" else goal)
    if goal == "max":
        require_bounded_gains(task)
    done = search_relaxations(
        task, goal, default_relaxations(task) if names is None else names, stop=False
    )
    return Ladder(tuple(done.results), done.best)


def checked_names(relaxations: Sequence[str]) -> tuple[str, ...]:
    """Return the relaxations that were named.

    Raises
    ------
    ModelError : none, an unknown one, or one twice.
    """
    names = (relaxations,) if isinstance(relaxations, str) else tuple(relaxations)
    if not names:
        raise ModelError("relaxations is empty; name at least one, or leave it out")
    for place, name in enumerate(names):
        relaxation_named(name)
        if name in names[:place]:
            raise ModelError(f"relaxations: {name!r} is named twice; name each once")
    return names


def _cells(result: RelaxationResult) -> tuple[object, ...]:
    tried = result.status != "not tried"
    return (
        result.relaxation,
        result.status,
        result.lmis,
        result.variables,
        result.width,
        result.seconds if tried else None,
        result.margin if tried else None,
        result.decay_rate,
        result.note,
    )


def _text(cell: object) -> str:
    if cell is None:
        return "-"
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)
