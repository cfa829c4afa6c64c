r"""``running-rate``: in moving wind the turbine's loop as it runs keeps a set around its trim.

The loop is that of ``running-loop``; its distances are measured from the trim at the present wind
(``moving``).  V(xi, v) = xi'P(v) xi; P is stated at winds, and linear between them, so it is
continuous.  A cell lies between two neighbours a < b of these winds, and has a rate r of the wind,
a box, alpha above 0 and a share k of the residual, 0 < k < 1.  Its range of v_s - v may be divided
into pieces.
Exactly, for P and tau at a and at b, for sigma = -r and r, and for every pair of a piece of v_s - v
and a piece of the share of pitch, with the factors over these pieces

    -(2 xi'P xi' + 2 alpha xi'P xi + sigma xi'(P(b) - P(a)) xi / (b - a)
      - 2 alpha ((1 - k) (v'/r)^2 + k (rho/rho_max)^2) + sum tau_i (z_i^2 - w_i^2)) > 0

for all (xi, v', rho, w) but zero, and side^2 P > h'h for every side of the box.  The form is affine
in (P, tau) and in sigma, so it holds for all v of the cell and all |sigma| <= r.  While |v'| <= r,
V' <= 2 alpha (1 - V): no motion leaves V <= 1, and V - 1, where it is positive, cannot grow.  What
the rate limits carry over from cell to cell is shown to be gone in time (``carried``).

Evidence: as of ``running-loop``, but for ``decay_rate``; ``functions``, each of ``wind`` and ``P``
(pitch states in rad), and ``cells`` of ``wind``, ``wind_rate``, ``decay_rate``, ``residual_share``,
``sides``, ``schedule_cuts`` [m/s] where v_s - v has pieces, and ``multipliers``: for each pair of
pieces two by the factor's name, at a and at b; the pairs of the first piece of v_s - v come first.

Not promised: faster winds; a wind that passes through a range that no cell covers; what
``running-loop`` does not promise.

Derived in docs/running-rate.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.arithmetic.effort_ramp import share
from takagi.certificates.checker.kernel.reader import (
    increasing,
    listed,
    number,
    numbers,
    positive,
)
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.carried import (
    Passed,
    Room,
    carried_failures,
)
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.equations import rows, states
from takagi.certificates.checker.turbine.running_loop.factors import cut
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    Sides,
    Span,
)
from takagi.certificates.checker.turbine.running_loop.limits import limit_failure
from takagi.certificates.checker.turbine.running_loop.moving import (
    MOVING_FACTORS,
    drift,
    in_units,
    moving_equations,
    moving_factors,
)
from takagi.certificates.checker.turbine.running_loop.reach import squared_reaches
from takagi.certificates.checker.turbine.running_loop.rounded_definite import is_surely_definite
from takagi.certificates.checker.turbine.running_loop.running_claim import (
    MOST_PIECES,
    stated_winds,
)
from takagi.certificates.checker.turbine.running_loop.signals import Rows, decay_form
from takagi.certificates.checker.turbine.running_loop.stated import (
    MOST_CELLS,
    stated_functions,
    stated_loop,
)

# The most places at which the range of v_s - v is divided.
MOST_CUTS = 15


@dataclass(frozen=True)
class MovingCell:
    """One cell as the claim states it.

    ``ends`` are P at its two winds, pitch states in rad; of each pair of pieces there are two
    multipliers of each factor, one for each wind.  ``cuts`` divide the range of v_s - v [m/s].
    """

    winds: Span
    ends: tuple[Rows, Rows]
    wind_rate: Fraction
    decay: Fraction
    residual_share: Fraction
    sides: Sides
    multipliers: Sequence[Mapping[str, Sequence[Fraction]]]
    cuts: Sequence[Fraction] = ()

    @property
    def lags(self) -> list[Span | None]:
        """The pieces of v_s - v [m/s]; one that stands for the whole side where there is no cut."""
        if not self.cuts:
            return [None]
        ends = (-self.sides.schedule, *self.cuts, self.sides.schedule)
        return list(pairwise(ends))

    @classmethod
    def read(cls, stated: Any, functions: dict[Fraction, Rows], where: str) -> MovingCell:
        """Return it.

        Refused are numbers out of their ranges, an end without a function, and a function between
        the ends.
        """
        low, high = numbers(stated, "wind", where, 2)
        if not low < high:
            raise CertificateError(f"{where}.wind: the two winds must increase")
        if low not in functions or high not in functions:
            raise CertificateError(f"{where}.wind: no function is stated at an end of the cell")
        # What is proved is about P between the ends; a file with one more has another P(v).
        if any(low < wind < high for wind in functions):
            raise CertificateError(f"{where}.wind: a function is stated at a wind inside the cell")
        part = number(stated, "residual_share", where)
        if not 0 < part < 1:
            raise CertificateError(f"{where}.residual_share: a number between 0 and 1 is needed")
        sides = Sides.read(stated, where)
        cuts = _cuts(stated, sides, where) if "schedule_cuts" in stated else []
        most = MOST_PIECES * (len(cuts) + 1)
        pieces = []
        for i, row in enumerate(listed(stated, "multipliers", where, 1, most)):
            place = f"{where}.multipliers[{i}]"
            if not isinstance(row, dict) or not set(row) <= MOVING_FACTORS:
                raise CertificateError(f"{place}: numbers by the names of the factors are needed")
            pieces.append({name: numbers(row, name, place, 2) for name in row})
        if len(pieces) % (len(cuts) + 1):
            raise CertificateError(
                f"{where}.multipliers: {len(pieces)} rows; as many are needed for each of the "
                f"{len(cuts) + 1} pieces of the schedule wind"
            )
        return cls(
            winds=(low, high),
            ends=(functions[low], functions[high]),
            wind_rate=positive(stated, "wind_rate", where),
            decay=positive(stated, "decay_rate", where),
            residual_share=part,
            sides=sides,
            multipliers=pieces,
            cuts=cuts,
        )


@dataclass(frozen=True)
class Kept:
    """What is proved of one cell: bounds of the deviations from the trim, all squared but torque.

    Attributes
    ----------
    winds, wind_rate : the cell [m/s], and the largest |v'| in it [m/s^2].
    fastest : the largest omega* of the cell [rad/s].
    speed, pitch, estimate, schedule : squares of the half widths of the set in rotor speed [rad/s],
        pitch [rad], the observer's wind and the schedule wind [m/s].
    torque : a bound of the generator torque's deviation [N m].
    passed : the cell, and what its sets leave of its box at its two winds.
    """

    winds: Span
    wind_rate: Fraction
    fastest: Fraction
    speed: Fraction
    pitch: Fraction
    estimate: Fraction
    schedule: Fraction
    torque: Fraction
    passed: Passed


def check_running_rate(claim: Any, data: Any, where: str) -> Found:
    """Return the verdict on one claim, with what fails and where.

    Parameters
    ----------
    data : the whole file.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be; also an observer or filters
        that are not those of the certificate's ``controller``.
    """
    plant, law, machine = stated_loop(claim, data, where)
    functions = stated_functions(claim, states(machine), where)
    cells = [
        MovingCell.read(cell, functions, f"{where}.cells[{i}]")
        for i, cell in enumerate(listed(claim, "cells", where, 1, MOST_CELLS))
    ]
    winds = stated_winds(claim, cells, where)
    said = {"law": law, "winds": winds}
    kept, failures = [], []
    for stated in cells:
        found = examined(plant, law, machine, stated)
        if isinstance(found, str):
            failures.append((stated.winds, found))
        else:
            kept.append(found)
    if not failures:
        for low, high in winds:
            run = [one.passed for one in kept if low <= one.winds[0] and one.winds[1] <= high]
            failures += carried_failures(run)
    if failures:
        return Found(Verdict.UNDECIDED, "running_rate", said | {"failures": failures})
    proved = {"machine": machine, "kept": kept, "rated_speed": plant.rated_speed}
    return Found(Verdict.PROVED, "running_rate", said | proved)


def _cuts(stated: Any, sides: Sides, where: str) -> list[Fraction]:
    """Return where the range of v_s - v is divided [m/s]; refuses cuts outside the box."""
    count = len(listed(stated, "schedule_cuts", where, 1, MOST_CUTS))
    cuts = numbers(stated, "schedule_cuts", where, count)
    increasing([-sides.schedule, *cuts, sides.schedule], f"{where}.schedule_cuts")
    return cuts


def examined(plant: Plant, law: Law, machine: Machine, stated: MovingCell) -> Kept | str:
    """Return what is proved of one cell, or what is not."""
    try:
        cell = Cell(plant, law, machine, stated.winds, stated.sides)
        parts = [cell if lag is None else cell.piece(lag) for lag in stated.lags]
        spans = [moving_factors(part) for part in parts]
        if failure := limit_failure(cell):
            return failure
    except Refused as reason:
        return str(reason)
    low, high = (in_units(cell, P) for P in stated.ends)
    rooms: tuple[list[Room], list[Room]] = ([], [])
    for at_end, P in zip(rooms, (low, high), strict=True):
        for part, span in zip(parts, spans, strict=True):
            found = _room(part, span, P)
            if isinstance(found, str):
                return found
            at_end.append(found)
    each = len(stated.multipliers) // len(parts)
    for i, (part, span) in enumerate(zip(parts, spans, strict=True)):
        multipliers = stated.multipliers[each * i : each * (i + 1)]
        if failure := _rate_failure(part, span, stated, (low, high), multipliers):
            return failure
    return _kept(cell, stated, rooms)


def _room(cell: Cell, span: dict[str, Span], P: Rows) -> Room | str:
    """Return the squared half widths of the set and the bounds, or which side it may leave."""
    wanted = rows(cell, span)
    reached = squared_reaches(P, [h for h, _ in wanted.values()])
    if reached is None:
        return "P is not symmetric positive definite"
    found: Room = {}
    for (name, (_, bound)), square in zip(wanted.items(), reached, strict=True):
        if bound <= 0 or square >= bound**2:
            return f"the set leaves its box in {name.replace('_', ' ')}"
        found[name] = square, bound
    return found


def _rate_failure(
    cell: Cell,
    span: dict[str, Span],
    stated: MovingCell,
    ends: tuple[Rows, Rows],
    multipliers: Sequence[Mapping[str, Sequence[Fraction]]],
) -> str:
    """Return what fails in the inequality of a piece of the share of pitch, or nothing."""
    low, high = stated.winds
    moved = stated.wind_rate / (high - low)
    weights = (
        2 * stated.decay * (1 - stated.residual_share) / stated.wind_rate**2,
        2 * stated.decay * stated.residual_share,
    )
    for tau, held in zip(multipliers, cut(cell.share, len(multipliers)), strict=True):
        signals, rates = moving_equations(cell, span, held)
        if missing := [name for name in signals.names if name not in tau]:
            return f"there is no multiplier of the {missing[0]}"
        if min(min(pair) for pair in tau.values()) <= 0:
            return "a multiplier is not positive"
        for end, P in enumerate(ends):
            chosen = [tau[name][end] for name in signals.names]
            for rate in (moved, -moved):
                change = drift(*ends, rate)
                form = decay_form(signals, rates, P, chosen, stated.decay, change, weights)
                if not is_surely_definite(form):
                    return "the inequality of the set fails"
    return ""


def _kept(cell: Cell, stated: MovingCell, rooms: tuple[list[Room], list[Room]]) -> Kept:
    every = [*rooms[0], *rooms[1]]
    law, most = cell.law, {name: max(room[name][0] for room in every) for name in every[0]}
    fed = max(abs(law.inertia[j]) for j in cell.near) * cell.schedule_rate
    turned = share(-cell.efforts[0], law.overlap) * cell.sides.effort
    return Kept(
        winds=stated.winds,
        wind_rate=stated.wind_rate,
        fastest=max(cell.at(law.speed, v) for v in stated.winds),
        speed=most["speed"],
        pitch=most["pitch"] / cell.b0**2,
        estimate=most["estimate"],
        schedule=most["schedule"],
        torque=law.effort_torque * (turned + fed),
        passed=Passed(cell, rooms),
    )
