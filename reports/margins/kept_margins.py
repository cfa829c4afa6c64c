"""Margins as constraints of a design: the settings nearest to those asked whose loop keeps them.

The loop is the one of ``running_margins``, with gains found wind by wind.  It is measured at all
winds first.  Where a margin is missed, the levers of ``design_levers`` are moved:

    1. all together, to the least share of their ranges (in eighths) at which every margin is kept;
    2. then back one by one, each as far as the margins allow.

Both look at the winds and plants where margins were least; the result is then measured at all
winds, and what is missed there is looked at too.  A margin is taken to grow with the share.  Where
it does not, the search may end beyond the least change, but never with a margin that is missed:
what is returned was measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from takagi.certificates.design.turbine.effort_sharing_gains import (
    wind_by_wind_law,
    wind_observer_design,
)
from takagi.certificates.design.turbine.result import speed_filter
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import law_words
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.margins.design_levers import (
    LEVERS,
    effort_of,
    free_levers,
    lever_changes,
    positioned,
)
from takagi.reports.margins.running_loop import NoEquilibrium, PlantChoice, RunningLoops
from takagi.reports.margins.running_over_wind import (
    RunningMargins,
    plant_modes,
    require_sampling,
    running_margins,
)
from takagi.reports.margins.running_search import searched_margins, wind_ranges
from takagi.reports.margins.thresholds import AskedMargins, failed, measured, modes_met, shares_of

# Positions of a lever, and how often all winds are measured.
EIGHTHS = 8
ROUNDS = 4
# The search measures winds and plants whose margin is up to this factor above the least one.
NEAR = 1.3

Tell = Callable[..., None]
Place = tuple[float, PlantChoice]  # wind [m/s], plant


@dataclass(frozen=True, slots=True, eq=False)
class KeptMargins:
    """Settings whose loop keeps what is asked; ``notes`` say what was changed and measured."""

    settings: DesignSettings
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class NoMargins:
    """No settings in range keep what is asked; ``reason`` says where, by how much, what helps."""

    reason: str


def settings_with_margins(
    turbine: Turbine,
    settings: DesignSettings,
    asked: AskedMargins,
    *,
    given: Collection[str] = (),
    tell: Tell | None = None,
) -> KeptMargins | NoMargins:
    """Return settings whose loop has the margins, found before the long work.

    Parameters
    ----------
    settings : where the search begins; they are returned as they are if they keep the margins.
    given : options of the command line that were given: their numbers are not changed.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : another law; gains that would be moved again (one-step); a sampling too slow for
        tower or torsion; a wind that the observer cannot estimate; no gains at some wind.
    """
    check_margins_asked(turbine, settings, asked)
    turbine = derated(turbine, settings.torque_setpoint, speed_setpoint=settings.speed_setpoint)
    loops = _Loops(turbine, asked, wind_observer_design(turbine, settings).observer)
    search = MarginSearch(loops, settings, given, tell or _silent)
    return search.result()


def check_margins_asked(turbine: Turbine, settings: DesignSettings, asked: AskedMargins) -> None:
    """Refuse what no search can answer: another law, one-step gains, a sampling too slow.

    Raises
    ------
    ModelError : says what was asked, and what to do.
    """
    if settings.law != "coherent":
        raise ModelError(
            f"margins were asked for with the {law_words(settings.law)}; they belong to the "
            "effort-sharing law, whose gains are known before the long work"
        )
    if settings.synthesis != "two-step":
        raise ModelError(
            "margins were asked for with gains found in one step, which moves them after the "
            "margins were measured; leave --one-step and --objective out"
        )
    require_sampling(asked.sample, plant_modes(validation_plant(turbine)))
    if asked.computing > asked.sample:
        raise ModelError(
            f"margins: computing {asked.computing * 1e3:g}ms was given with sample "
            f"{asked.sample * 1e3:g}ms; a program computes for at most one sample"
        )


class _Loops:
    """The loop of settings, at places or at all winds; gains are found once for each effort."""

    def __init__(self, turbine: Turbine, asked: AskedMargins, observer: WindObserver) -> None:
        self.turbine, self.asked, self.observer = turbine, asked, observer
        self._laws: dict[object, EffortSharingLaw] = {}

    def _of(self, settings: DesignSettings) -> RunningLoops:
        key = (effort_of(settings), settings.wind_filter)
        if key not in self._laws:
            self._laws[key] = wind_by_wind_law(self.turbine, settings)[1]
        return RunningLoops.of(
            self.turbine,
            self._laws[key],
            self.observer,
            speed_filter=speed_filter(settings),
            sample_time=self.asked.sample,
            computation_time=self.asked.computing,
        )

    def everywhere(
        self, settings: DesignSettings
    ) -> tuple[Sequence[RunningMargins], tuple[float, ...]]:
        """Return the margins at all winds, and the winds without rest."""
        found = searched_margins(self._of(settings))
        return found.rows, found.none

    def least(self, settings: DesignSettings, places: Collection[Place]) -> float:
        """Return the least margin over what is asked at some places; -inf where there is none."""
        least, loops = math.inf, self._of(settings)
        for wind in sorted({wind for wind, _ in places}):
            plants = [plant for at, plant in sorted(places) if at == wind]
            try:
                rows = running_margins(loops, [wind], plants=plants)
            except NoEquilibrium:
                return -math.inf
            least = min(least, *(_share(row, self.asked) for row in rows))
        return least


@dataclass(frozen=True, slots=True, eq=False)
class MarginSearch:
    """The search from settings on, over loops that can be measured; ``given`` are not moved."""

    loops: _Loops
    start: DesignSettings
    given: Collection[str]
    tell: Tell

    def result(self) -> KeptMargins | NoMargins:
        """Return settings that keep what is asked at all winds, or why there are none."""
        asked = self.loops.asked
        settings, places = self.start, set[Place]()
        first: tuple[str, ...] = ()
        met: tuple[str, ...] = ()
        for turn in range(ROUNDS):
            self.tell("margins of the loop that runs, all winds")
            rows, none = self.loops.everywhere(settings)
            if none:
                winds = wind_ranges(none, [*none, *(row.wind for row in rows)])
                return NoMargins(
                    f"margins: the loop has no rest at {winds}, and none can be measured there; "
                    "change the overlap or the pitch effectiveness share"
                )
            below = failed(rows, asked)
            if not turn:
                first, met = below, modes_met(rows)
            if not below:
                return self._kept(settings, first, rows)
            places |= _places(rows, asked)
            moved = self._moved(places)
            if moved is None:
                return self._none(first, below if turn else (), met)
            settings = moved
        return self._none(first, failed(self.loops.everywhere(settings)[0], asked), met)

    def _moved(self, places: set[Place]) -> DesignSettings | None:
        """Return the least moved settings that keep the margins at the places; None for none."""
        levers = free_levers(self.given)

        def keep(positions: Sequence[int]) -> bool:
            settings = positioned(self.start, levers, tuple(k / EIGHTHS for k in positions))
            try:
                return self.loops.least(settings, places) >= 1
            except ModelError:
                return False  # no gains with these numbers

        def least(low: int, high: int, kept: Callable[[int], bool], step: str) -> int:
            """Return the least position in (low, high] that keeps, where ``high`` does."""
            while high - low > 1:
                self.tell(f"margins of the loop that runs, {step}")
                middle = (low + high) // 2
                low, high = (low, middle) if kept(middle) else (middle, high)
            return high

        if not levers:
            return None
        self.tell("margins of the loop that runs, calmest numbers")
        together = next((k for k in (EIGHTHS // 2, EIGHTHS) if keep([k] * len(levers))), None)
        if together is None:
            return None
        low = 0 if together == EIGHTHS // 2 else EIGHTHS // 2
        all_of = least(low, together, lambda k: keep([k] * len(levers)), "calmer numbers")
        positions = [all_of] * len(levers)
        for place in reversed(range(len(levers))):

            def alone(k: int, place: int = place) -> bool:
                return keep([*positions[:place], k, *positions[place + 1 :]])

            step = f"{levers[place].name} put back"
            positions[place] = least(-1, positions[place], alone, step)
        return positioned(self.start, levers, tuple(k / EIGHTHS for k in positions))

    def _kept(
        self, settings: DesignSettings, first: tuple[str, ...], rows: Sequence[RunningMargins]
    ) -> KeptMargins:
        lines = measured(rows, self.loops.asked, "with gains found wind by wind")
        moved = lever_changes(self.start, settings)
        if not moved:
            return KeptMargins(settings, lines)
        told = f"changed to keep the margins asked: {', '.join(moved)}; before, {'; '.join(first)}"
        return KeptMargins(settings, (told, *lines))

    def _none(
        self, first: tuple[str, ...], last: tuple[str, ...], met: tuple[str, ...]
    ) -> NoMargins:
        names = [lever.name for lever in free_levers(self.given)]
        looked = f"; no {', '.join(names)} in range keeps what is asked" if names else ""
        ended = f"; with the calmest that was tried {'; '.join(last)}" if last else ""
        held = {name for lever in LEVERS for name in lever.options} & set(self.given)
        fixed = [f"--{one.replace('_', '-')}" for one in sorted(held)]
        freed = f", leave {', '.join(fixed)} free" if fixed else ""
        return NoMargins(
            f"margins: {'; '.join(first)}{looked}{ended}; ask for less, sample or compute "
            f"faster{freed}, or give a band-stop (--torsion-filter) or a larger pitch "
            f"effectiveness share (--pitch-effectiveness-share){''.join(f'; {one}' for one in met)}"
        )


def _places(rows: Sequence[RunningMargins], asked: AskedMargins) -> set[Place]:
    """Return, plant by plant, where each kind of margin is least and nearly missed."""
    found: dict[tuple[object, ...], tuple[float, Place]] = {}
    for row in rows:
        for kind, share in shares_of(row, asked).items():
            key, place = (kind, row.inertia, row.wake), (row.wind, (row.inertia, row.wake))
            if share < NEAR and share < found.get(key, (math.inf, place))[0]:
                found[key] = (share, place)
    return {place for _, place in found.values()}


def _share(row: RunningMargins, asked: AskedMargins) -> float:
    return min(shares_of(row, asked).values())


def _silent(step: str, done: float | None = None) -> None:
    """Ignore a message on progress."""
