"""The returned answer: a candidate, a no, or neither, with how it was found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from takagi.lmi.condition.term import Condition
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.polynomials import PolynomialLyapunov


Status: TypeAlias = Literal["candidate", "infeasible", "unbounded", "unknown"]
RelaxationStatus: TypeAlias = Status | Literal["not tried", "bound"]


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
    note : why it was not tried, or where the condition of a bound was looked at.
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


@dataclass(frozen=True, slots=True)
class Try:
    """One call of a solver: what it said, and what the check of its numbers said."""

    solver: str
    status: str
    margin: float
    iterations: int
    seconds: float


@dataclass(frozen=True, slots=True)
class ObjectiveUnit:
    """What the objective of an answer's condition means in the user's units.

    shown = factor * objective^(1 / power) + offset: the condition is posed in units of order one,
    and some objectives are squares.

    Attributes
    ----------
    quantity : "gain" or "cost", as the answer or design names it.
    factor, power, offset : of the formula.
    """

    quantity: str
    factor: float
    power: int = 1
    offset: float = 0.0

    @classmethod
    def of(cls, quantity: str, quantity_of: Callable[[float], float]) -> ObjectiveUnit:
        """Return the unit of a function of the objective that has the formula's form."""
        offset = quantity_of(0.0)
        factor = quantity_of(1.0) - offset
        # Four times a square is twice its root.
        power = 2 if abs(quantity_of(4.0) - offset - 2.0 * factor) < abs(factor) else 1
        return cls(quantity, factor, power, offset)

    def objective(self, value: float) -> float:
        """Return the objective at which the quantity has this value.

        Raises
        ------
        ModelError : a value that no objective has.
        """
        root = (value - self.offset) / self.factor
        if not root > 0:
            range_text = (
                f"above {self.offset:g}, which a direct path adds" if self.offset else "positive"
            )
            raise ModelError(f"the {self.quantity} is {value:g}; it must be {range_text}")
        return root**self.power


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Answer(ShortRepr):
    """What floating point can say about a condition.  Nothing here is a proof.

    Attributes
    ----------
    status : "candidate", the unknowns were put back and every LMI held by eigenvalues, and where
        an optimum was asked for they are near it; "infeasible", multipliers that leave no unknowns
        of any size were found, exactly or with a margin for rounding; "unbounded", the objective
        falls without end; "unknown", none of these.
    P : (n, n) for V = x' P x with smallest eigenvalue of order 1 in balanced states, or the one
        that shows the gain; None unless a candidate, and where V depends on the memberships.
    lyapunov_function : P(h) for V = x' P(h) x, where that was asked for and found; else None.
    margin : the t up to which every LMI holds, in balanced states and relative to the LMI's
        weight; negative or zero when not a candidate.
    decay_rate : alpha in 1/s with V' <= -2 alpha V, recomputed from P; None unless a candidate.
    gain : upper bound on a norm from disturbance to output, recomputed from P; None unless a
        norm was asked for and a candidate found.
    bound : upper bound on the margin from the multipliers (on the decay rate, for
        ``max_decay_rate``), to solver accuracy.
    values : unknown -> (count, rows, cols), in the coordinates of ``condition``.
    multipliers : LMI -> (items, size, size), in the coordinates of ``condition``.
    coordinates : (n,) s: the condition is posed in x_k / s_k.
    condition : what was solved.
    feasible : as ``values``, where an optimum was asked for and not reached: they satisfy the
        condition, and the diagnosis compares the value they show with the bound; else empty.
    objective_unit : what the condition's objective means in the user's units; None where nothing
        is minimised.
    diagnosis : in words, which item binds and what to relax; empty for a candidate.
    note : in words, what is unusual about a candidate, such as very large entries; else empty.
    tries : every solver call, in order.
    """

    status: Status
    P: Floats | None = None
    margin: float
    lyapunov_function: PolynomialLyapunov | None = None
    decay_rate: float | None = None
    gain: float | None = None
    bound: float = np.inf
    values: Mapping[str, Floats] = field(default_factory=dict)
    multipliers: Mapping[str, Floats] = field(default_factory=dict)
    coordinates: Floats | None = None
    condition: Condition | None = None
    feasible: Mapping[str, Floats] = field(default_factory=dict)
    objective_unit: ObjectiveUnit | None = None
    diagnosis: str = ""
    note: str = ""
    tries: tuple[Try, ...] = ()

    @property
    def found(self) -> bool:
        """Return whether there is a candidate."""
        return self.status == "candidate"

    @property
    def solver(self) -> dict[str, object]:
        """Return the last try's solver, its own words, iterations, and the seconds of all."""
        if not self.tries:
            return {"name": "none", "status": "not called", "iterations": 0, "seconds": 0.0}
        last = self.tries[-1]
        return {
            "name": last.solver,
            "status": last.status,
            "iterations": last.iterations,
            "seconds": sum(attempt.seconds for attempt in self.tries),
            "tries": len(self.tries),
        }


class WithAnswer:
    """What the result of a search for gains takes from its ``answer``."""

    __slots__ = ()
    if TYPE_CHECKING:

        @property
        def answer(self) -> Answer: ...

    @property
    def status(self) -> Status:
        """Return "candidate", "infeasible" or "unknown", as of an ``Answer``."""
        return self.answer.status

    @property
    def found(self) -> bool:
        """Return whether there are gains."""
        return self.answer.found


class GainsWithAnswer(WithAnswer):
    """Gains and a quadratic function, or the reason why there are none."""

    __slots__ = ()
    if TYPE_CHECKING:

        @property
        def gains(self) -> Floats | None: ...

        @property
        def P(self) -> Floats | None: ...

    @property
    def K(self) -> Floats | None:
        """Return the gains, as ``gains``."""
        return self.gains

    def require(self) -> tuple[Floats, Floats]:
        """Return (gains, P).

        Raises
        ------
        ModelError : there are none; the message is the diagnosis.
        """
        if self.gains is None or self.P is None:
            raise ModelError(f"no gains were found ({self.status}): {self.answer.diagnosis}")
        return self.gains, self.P


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Design(ShortRepr, GainsWithAnswer):
    """Gains with the Lyapunov function they were found with.

    Attributes
    ----------
    gains : (r, m, n) for u = -sum_i h_i K_i x; of an observer (r, n, p); None unless found.
    P : (n, n), V = x' P x; None unless found.
    decay_rate : alpha in 1/s that was asked for and holds: V' <= -2 alpha V.
    margin : as in ``Answer``.
    relaxation : name of the double-sum relaxation.
    answer : how it was found; its condition is in balanced states and inputs.
    cost : bound on the mean quadratic cost, from P; None unless one was asked for and found.
    ladder : what was tried, in order, where the relaxation was "auto"; else empty.
    """

    gains: Floats | None = None
    P: Floats | None = None
    decay_rate: float
    margin: float
    relaxation: str
    answer: Answer
    cost: float | None = None
    ladder: tuple[RelaxationResult, ...] = ()

    @property
    def gain(self) -> float | None:
        """Return the bound on a norm from disturbance to output; None unless asked and found."""
        return self.answer.gain
