r"""``schedule-rate``: in moving wind the turbine's loop keeps a set around the trim at v_s.

v_s is the schedule wind, at which the law reads its tables.  The claim is about schedule winds
above rated wind (``schedule_cell``).  V(xi, v_s) = xi'P(v_s) xi; P is stated at schedule winds and
linear between them.  A cell lies between two neighbours a < b of these winds, and has a rate r of
the wind, a box, alpha above 0 and a share 0 < k < 1.  Exactly, for P and tau at a and at b and for
sigma = -s and s, s = estimate / tau_f >= |v_s'|,

    -(2 xi'P xi' + 2 alpha xi'P xi + sigma xi'(P(b) - P(a)) xi / (b - a)
      - 2 alpha ((1 - k) (v'/r)^2 + k (rho/rho_max)^2) + sum tau_i (z_i^2 - w_i^2)) > 0

for all (xi, v', rho, w) but zero, and side^2 P > h'h for every side of the box.  Then
V' <= 2 alpha (1 - V) while |v'| <= r, and no motion leaves V <= 1 while v_s is in a cell.
v_s stays in the cells while the wind is farther from the
first and from the last schedule wind than D = v - v_s may be there.

Evidence: as of ``running-loop``, but for ``decay_rate`` and with ``winds``, one range of the wind
for each range of cells without a gap; ``functions``, each of ``wind`` and ``P``, and ``cells`` of
``wind``, ``wind_rate``, ``decay_rate``, ``residual_share``, ``sides`` and ``multipliers``, two by
the factor's name, at a and at b.

Not promised: faster winds; a wind outside ``winds``; what ``running-loop`` does not promise.

Derived in docs/schedule-rate.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import (
    listed,
    member,
    number,
    numbers,
    positive,
)
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.equations import states
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    Span,
)
from takagi.certificates.checker.turbine.running_loop.moving import drift
from takagi.certificates.checker.turbine.running_loop.reach import squared_reaches
from takagi.certificates.checker.turbine.running_loop.rounded_definite import is_surely_definite
from takagi.certificates.checker.turbine.running_loop.signals import Rows, decay_form
from takagi.certificates.checker.turbine.running_loop.stated import (
    MOST_CELLS,
    stated_functions,
    stated_loop,
)
from takagi.certificates.checker.turbine.scheduled_loop.schedule_cell import ScheduleCell
from takagi.certificates.checker.turbine.scheduled_loop.schedule_inputs import ScheduleSides
from takagi.certificates.checker.turbine.scheduled_loop.schedule_limits import (
    schedule_limit_failure,
)
from takagi.certificates.checker.turbine.scheduled_loop.schedule_loop import (
    SCHEDULE_FACTORS,
    schedule_equations,
    schedule_factors,
    schedule_rows,
)


@dataclass(frozen=True)
class StatedScheduleCell:
    """One cell as the claim states it.

    ``ends`` are P at its two schedule winds; of each factor there are two multipliers, one for each
    of them.
    """

    winds: Span
    ends: tuple[Rows, Rows]
    wind_rate: Fraction
    decay: Fraction
    residual_share: Fraction
    sides: ScheduleSides
    multipliers: Mapping[str, Sequence[Fraction]]

    @classmethod
    def read(
        cls, stated: Any, functions: Mapping[Fraction, Rows], where: str
    ) -> StatedScheduleCell:
        """Return it.

        Refused are numbers out of their ranges, an end without a function, and a function between
        the ends.
        """
        low, high = numbers(stated, "wind", where, 2)
        if not low < high:
            raise CertificateError(f"{where}.wind: the two winds must increase")
        if low not in functions or high not in functions:
            raise CertificateError(f"{where}.wind: no function is stated at an end of the cell")
        # What is proved is about P between the ends; a file with one more has another P(v_s).
        if any(low < wind < high for wind in functions):
            raise CertificateError(f"{where}.wind: a function is stated at a wind inside the cell")
        part = number(stated, "residual_share", where)
        if not 0 < part < 1:
            raise CertificateError(f"{where}.residual_share: a number between 0 and 1 is needed")
        place, row = f"{where}.multipliers", member(stated, "multipliers", where)
        if not isinstance(row, dict) or not set(row) <= SCHEDULE_FACTORS:
            raise CertificateError(f"{place}: numbers by the names of the factors are needed")
        return cls(
            winds=(low, high),
            ends=(functions[low], functions[high]),
            wind_rate=positive(stated, "wind_rate", where),
            decay=positive(stated, "decay_rate", where),
            residual_share=part,
            sides=ScheduleSides.read(stated, where),
            multipliers={name: numbers(row, name, place, 2) for name in row},
        )


@dataclass(frozen=True)
class KeptAtSchedule:
    """What is proved of one cell: squares of the largest deviations from the trim at v_s.

    Attributes
    ----------
    winds, wind_rate : the cell's schedule winds [m/s], and the largest |v'| in it [m/s^2].
    fastest : the reference speed of the cell [rad/s].
    speed, pitch, estimate : of the rotor's speed [rad/s], pitch [rad], and the observer's wind less
        v_s [m/s].
    wind : of v - v_s, at the two ends [m/s].
    """

    winds: Span
    wind_rate: Fraction
    fastest: Fraction
    speed: Fraction
    pitch: Fraction
    estimate: Fraction
    wind: tuple[Fraction, Fraction]


def check_schedule_rate(claim: Any, data: Any, where: str) -> Found:
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
        StatedScheduleCell.read(cell, functions, f"{where}.cells[{i}]")
        for i, cell in enumerate(listed(claim, "cells", where, 1, MOST_CELLS))
    ]
    runs = _runs(cells, where)
    winds = [
        _range(claim, i, where)
        for i in range(len(listed(claim, "winds", where, len(runs), len(runs))))
    ]
    said = {"law": law, "winds": winds}
    kept, failures = [], []
    for run, ends in zip(runs, winds, strict=True):
        found, why = examined_run(plant, law, machine, run, ends)
        kept.append(found)
        failures += why
    if failures:
        return Found(Verdict.UNDECIDED, "schedule_rate", said | {"failures": failures})
    proved = {"machine": machine, "kept": kept, "rated_speed": plant.rated_speed}
    return Found(Verdict.PROVED, "schedule_rate", said | proved)


def _runs(cells: Sequence[StatedScheduleCell], where: str) -> list[list[StatedScheduleCell]]:
    """Return the cells by ranges without a gap; refuses cells that overlap or are not in order."""
    found = [[cells[0]]]
    for i, cell in enumerate(cells[1:], start=1):
        end = found[-1][-1].winds[1]
        if cell.winds[0] < end:
            raise CertificateError(f"{where}.cells[{i}].wind: the cells must be in order, apart")
        if cell.winds[0] == end:
            found[-1].append(cell)
        else:
            found.append([cell])
    return found


def _range(claim: Any, place: int, where: str) -> Span:
    """Return a range of the wind that the claim states."""
    row = claim["winds"][place]
    low, high = numbers({"winds": row}, "winds", f"{where}.winds[{place}]", 2)
    if not low < high:
        raise CertificateError(f"{where}.winds[{place}]: the two winds must increase")
    return low, high


def examined_run(
    plant: Plant, law: Law, machine: Machine, run: Sequence[StatedScheduleCell], winds: Span
) -> tuple[list[KeptAtSchedule], list[tuple[Span, str]]]:
    """Return what is proved of cells without a gap, and the cells that fail with the reason.

    Parameters
    ----------
    winds : the range in which the wind stays.
    """
    kept: list[KeptAtSchedule] = []
    failures: list[tuple[Span, str]] = []
    cells: list[ScheduleCell] = []
    for stated in run:
        try:
            cells.append(ScheduleCell(plant, law, machine, stated.winds, stated.sides))
        except Refused as reason:
            failures.append((stated.winds, str(reason)))
    if failures:
        return kept, failures
    lead = lead_of(cells)
    for cell, stated in zip(cells, run, strict=True):
        found = examined(cell, stated, lead)
        if isinstance(found, str):
            failures.append((stated.winds, found))
        else:
            kept.append(found)
    if not failures:
        first, last = kept[0], kept[-1]
        for end, square in (
            (winds[0] - first.winds[0], first.wind[0]),
            (last.winds[1] - winds[1], last.wind[1]),
        ):
            if end <= 0 or end**2 <= square:
                failures.append((winds, "the schedule wind may leave the cells"))
    return kept, failures


def lead_of(cells: Sequence[ScheduleCell]) -> Span:
    """Return the range of the pitch lead over all cells that the schedule wind may pass."""
    return min(cell.lead[0] for cell in cells), max(cell.lead[1] for cell in cells)


def examined(cell: ScheduleCell, stated: StatedScheduleCell, lead: Span) -> KeptAtSchedule | str:
    """Return what is proved of one cell, or what is not."""
    try:
        if failure := schedule_limit_failure(cell, lead):
            return failure
        span = schedule_factors(cell, lead)
    except Refused as reason:
        return str(reason)
    wanted = schedule_rows(cell, span)
    reached: list[dict[str, Fraction]] = []
    for P in stated.ends:
        squares = squared_reaches(P, [h for h, _ in wanted.values()])
        if squares is None:
            return "P is not symmetric positive definite"
        for (name, (_, bound)), square in zip(wanted.items(), squares, strict=True):
            if bound <= 0 or square >= bound**2:
                return f"the set leaves its box in {name.replace('_', ' ')}"
        reached.append(dict(zip(wanted, squares, strict=True)))
    if failure := _set_failure(cell, span, stated):
        return failure
    most = {name: max(one[name] for one in reached) for name in reached[0]}
    return KeptAtSchedule(
        winds=stated.winds,
        wind_rate=stated.wind_rate,
        fastest=cell.speed,
        speed=most["speed"],
        pitch=most["pitch"],
        estimate=most["estimate"],
        wind=(reached[0]["wind"], reached[1]["wind"]),
    )


def _set_failure(cell: ScheduleCell, span: Mapping[str, Span], stated: StatedScheduleCell) -> str:
    """Return what fails in the inequality of the set, or nothing."""
    signals, rates = schedule_equations(cell, span)
    tau = stated.multipliers
    if missing := [name for name in signals.names if name not in tau]:
        return f"there is no multiplier of the {missing[0]}"
    if min(min(pair) for pair in tau.values()) <= 0:
        return "a multiplier is not positive"
    low, high = stated.winds
    decay, part = stated.decay, stated.residual_share
    weights = 2 * decay * (1 - part) / stated.wind_rate**2, 2 * decay * part
    for end, P in enumerate(stated.ends):
        chosen = [tau[name][end] for name in signals.names]
        for sign in (1, -1):
            change = drift(*stated.ends, sign * cell.schedule_rate / (high - low))
            form = decay_form(signals, rates, P, chosen, decay, change, weights)
            if not is_surely_definite(form):
                return "the inequality of the set fails"
    return ""
