"""One relaxation in a search: its cost and its result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

RelaxationStatus: TypeAlias = Literal["candidate", "infeasible", "unknown", "not tried", "bound"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxationResult:
    """One relaxation of a double sum, tried or not; or what no relaxation exceeds.

    Attributes
    ----------
    relaxation : its name; "any relaxation" for the condition at single blends, which each implies.
    status : as of an ``Answer``; "not tried", when it is too large or already settled; "bound",
        for a condition at single blends that does not rule gains out.
    lmis : number of LMIs that it makes of the double sum, those of its slack included.
    variables : gains and slack, in numbers; without the Lyapunov function.
    width : size of the largest LMI.
    seconds : to pose and solve it.
    margin : as of an ``Answer``; -inf when none exists.
    decay_rate : alpha in 1/s that its gains show, or that none exceeds where it is a bound; None
        without either.
    note : its result, or why it was not tried.
    """

    relaxation: str
    status: RelaxationStatus
    lmis: int
    variables: int
    width: int
    seconds: float = 0.0
    margin: float = -np.inf
    decay_rate: float | None = None
    note: str = ""

    @property
    def found(self) -> bool:
        """Return whether it has gains."""
        return self.status == "candidate"
