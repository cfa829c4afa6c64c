"""One batch of runs, all advanced together: inputs, steps that end at wind nodes, and records.

A run has its own clock.  Its step ends where its schedule wind reaches a node of the tables. Within
a step all tables are therefore linear, and the uncertainty class is that of one cell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.campaign.bounds import (
    BOUNDS,
    DECAYS,
    RunEquilibrium,
    decay_shares,
    run_equilibrium,
    shares,
)
from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.certificates.campaign.motion import (
    At,
    Cells,
    Demand,
    Drive,
    at_wind,
    blowing,
    demanded,
    error_state,
    step,
)
from takagi.certificates.campaign.outside import Beyond
from takagi.certificates.campaign.plants import drawn_starts, inertia_factors, wake_fits
from takagi.certificates.campaign.winds import PLAYERS, DisturbanceShares, Player, Seen
from takagi.models.arrays import Floats

Tell = Callable[[float], None]

# One run in this many is advanced a second time, with steps half as long and the same inputs.
HALVED_EACH = 20
# At the start the pitch drive may be at its rate limit and leave it within one step, where the
# derivative is not smooth. So the steps of the first time constants of the drive are shorter.
EARLY_LAGS, EARLY_PARTS = 2.0, 8


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """What n runs did.

    Attributes
    ----------
    player : index into ``PLAYERS``;  start_wind [m/s];  start_value : V at the start;
        kappa : nominal over true inertia.
    share : (bounds, n) the largest share of each bound; nan where a bound is not claimed.
    late_share : the same, in the second half of the run only, when the effect of the start has
        decayed.
    broken_at : (bounds, n) time at which it was first exceeded [s], inf if never.
    broken_wind : (bounds, n) schedule wind at that time [m/s], nan if never.
    lost_at : (n,) time at which the coefficient table was left [s]; the run ends there.
    end_value : V at the end.
    halving : (bounds,) the largest difference that steps half as long make to a share.
    """

    player: Cells
    start_wind: Floats
    start_value: Floats
    kappa: Floats
    share: Floats
    late_share: Floats
    broken_at: Floats
    broken_wind: Floats
    lost_at: Floats
    end_value: Floats
    halving: Floats


class _Batch:
    """The state of a batch of runs; its arrays are replaced at every step."""

    def __init__(
        self, loop: CertifiedLoop, beyond: Beyond, count: int, draw: np.random.Generator
    ) -> None:
        self.loop, self.wake_share = beyond.loop(loop), beyond.wake
        start = drawn_starts(self.loop, count, draw, level=beyond.start)
        self.state, self.cell, self.at = start
        self.player = _assigned(count, draw)
        self.slices = [np.flatnonzero(self.player == i) for i in range(len(PLAYERS))]
        makers = [maker for maker, _ in PLAYERS.values()]
        self.players: list[Player] = [
            make(self.loop, len(own), draw) for make, own in zip(makers, self.slices, strict=True)
        ]
        self.kappa = inertia_factors(self.loop.inertia, count, draw)
        self.fits = wake_fits(loop).astype(np.float64)
        self.clock, self.last = np.zeros(count), np.zeros(count)
        self.drive = self._drive(DisturbanceShares(*np.zeros((4, count))))
        self.lost_at = np.full(count, np.inf)

    def answered(self) -> DisturbanceShares:
        """Ask every player about its own runs."""
        found = np.zeros((4, len(self.clock)))
        for play, own in zip(self.players, self.slices, strict=True):
            if len(own):
                seen = Seen(
                    self.clock[own],
                    self.last[own],
                    self.state[:, own],
                    self.at.of(own),
                    self.drive.of(own),
                )
                found[:, own] = play(seen)
        return DisturbanceShares(*found)

    def turn(self) -> None:
        """Apply the players' answers; a run at a node enters the next cell."""
        answer, loop = self.answered(), self.loop
        up = (self.at.wind >= loop.wind[self.cell + 1]) & (answer.rate > 0)
        down = (self.at.wind <= loop.wind[self.cell]) & (answer.rate < 0)
        last = len(loop.wind) - 2
        self.cell = np.where(up, np.minimum(self.cell + 1, last), self.cell)
        self.cell = np.where(down, np.maximum(self.cell - 1, 0), self.cell)
        # The law limits its schedule wind to the range of its tables.
        outward = (self.at.wind >= loop.wind[-1]) & (answer.rate > 0)
        outward |= (self.at.wind <= loop.wind[0]) & (answer.rate < 0)
        self.drive = self._drive(answer._replace(rate=np.where(outward, 0.0, answer.rate)))

    def _drive(self, answer: DisturbanceShares) -> Drive:
        k, (low, high) = self.cell, self.loop.power
        return Drive(
            k,
            answer.error * self.loop.wind_error[k],
            answer.rate * self.loop.wind_rate[k],
            self.kappa,
            answer.wake * self.wake_share * self.fits[k],
            low + answer.power * (high - low),
        )

    def ahead(self, longest: float, until: float) -> tuple[Floats, At]:
        """Return each run's next step [s] and the schedule at its end."""
        rate, wind = self.drive.rate, self.at.wind
        node = np.where(rate > 0, self.loop.wind[self.cell + 1], self.loop.wind[self.cell])
        reach = np.divide(node - wind, rate, out=np.full(len(wind), np.inf), where=rate != 0)
        early = self.clock < EARLY_LAGS * self.loop.pitch_lag
        duration = np.minimum(np.where(early, longest / EARLY_PARTS, longest), until - self.clock)
        duration = np.where(np.isfinite(self.lost_at), 0.0, duration)
        meets = reach <= duration
        duration = np.where(meets, reach, duration)
        end = np.where(meets, node, wind + duration * rate)
        return duration, at_wind(self.loop, self.cell, end)

    def inside_table(self) -> NDArray[np.bool_]:
        wind = blowing(self.at, self.drive)
        return self.loop.surface.inside(
            self.loop.rotor_radius * self.state[0] / wind, self.state[1]
        )


def run_batch(
    loop: CertifiedLoop,
    count: int,
    draw: np.random.Generator,
    *,
    duration: float,
    longest_step: float,
    tolerance: float,
    beyond: Beyond,
    tell: Tell,
) -> Records:
    """Return what ``count`` random runs of ``duration`` seconds did.

    Parameters
    ----------
    longest_step : [s]; a step may be shorter, never longer.
    tolerance : a bound counts as broken above 1 + tolerance.
    tell : called from time to time with the fraction that is done.
    """
    batch = _Batch(loop, beyond, count, draw)
    book = _Book(batch, tolerance, duration / 2)
    halved = _Halved(batch)
    turns = 0
    while True:
        batch.turn()
        seconds, end = batch.ahead(longest_step, duration)
        after, demand = step(loop, batch.state, batch.at, end, batch.drive, seconds)
        book.enter(demand)
        halved.compare(book.now)
        if not seconds.any():
            return book.records(halved.most)
        halved.advance(end, seconds)
        batch.state, batch.at, batch.last = after, end, seconds
        batch.clock = batch.clock + seconds
        turns += 1
        if turns % 50 == 0:
            tell(float(batch.clock.mean()) / duration)


class _Book:
    """The largest ratios and first violations recorded while a batch runs."""

    def __init__(self, batch: _Batch, tolerance: float, late: float) -> None:
        self.batch, self.tolerance, self.late_from = batch, tolerance, late
        count = len(batch.clock)
        self.now = np.zeros((len(BOUNDS), count))
        self.most = np.full((len(BOUNDS), count), -np.inf)
        self.late = np.full((len(BOUNDS), count), -np.inf)
        self.broken_at = np.full((len(BOUNDS), count), np.inf)
        self.broken_wind = np.full((len(BOUNDS), count), np.nan)
        self.start_wind = batch.at.wind
        self.calm = batch.slices[list(PLAYERS).index("calm")]
        self.rest: RunEquilibrium | None = None
        self.start_value: Floats | None = None

    def enter(self, demand: Demand) -> None:
        """Compare the present state with every bound."""
        batch, loop = self.batch, self.batch.loop
        xi = error_state(loop, batch.state, batch.at, demand)
        self.now[: -len(DECAYS)] = shares(loop, batch.state, xi, demand)
        self.now[-len(DECAYS) :] = -np.inf
        own = self.calm
        if len(own):
            drive = batch.drive.of(own)
            if self.rest is None:
                at = batch.at.of(own)
                self.rest = run_equilibrium(loop, at, drive, xi[:, own])
            self.now[-len(DECAYS) :, own] = decay_shares(
                loop, self.rest, drive, xi[:, own], batch.clock[own]
            )
        if self.start_value is None:
            self.start_value = self.now[0].copy()
        lost = ~batch.inside_table() & np.isinf(batch.lost_at)
        batch.lost_at = np.where(lost, batch.clock, batch.lost_at)
        np.maximum(self.most, self.now, out=self.most)
        late = batch.clock >= self.late_from
        np.maximum(self.late, np.where(late, self.now, -np.inf), out=self.late)
        new = (self.now > 1 + self.tolerance) & np.isinf(self.broken_at)
        if new.any():
            self.broken_at[new] = np.broadcast_to(batch.clock, new.shape)[new]
            self.broken_wind[new] = np.broadcast_to(batch.at.wind, new.shape)[new]

    def records(self, halving: Floats) -> Records:
        batch = self.batch
        return Records(
            player=batch.player,
            start_wind=self.start_wind,
            start_value=self.now[0] if self.start_value is None else self.start_value,
            kappa=batch.kappa,
            share=np.where(np.isneginf(self.most), np.nan, self.most),
            late_share=np.where(np.isneginf(self.late), np.nan, self.late),
            broken_at=self.broken_at,
            broken_wind=self.broken_wind,
            lost_at=batch.lost_at,
            end_value=self.now[0].copy(),
            halving=halving,
        )


class _Halved:
    """A repetition of some runs with half the step length and the same inputs."""

    def __init__(self, batch: _Batch) -> None:
        self.batch = batch
        self.own = np.arange(0, len(batch.clock), HALVED_EACH)
        self.state = batch.state[:, self.own]
        self.most = np.zeros(len(BOUNDS))

    def compare(self, now: Floats) -> None:
        """Record how far the ratios to the bounds differ."""
        loop, at, drive = self.batch.loop, self._at(self.batch.at), self._drive()
        demand = demanded(loop, self.state, at, drive)
        xi = error_state(loop, self.state, at, demand)
        found = shares(loop, self.state, xi, demand)
        apart = np.abs(found - now[: len(found), self.own]).max(axis=1)
        self.most[: len(found)] = np.maximum(self.most[: len(found)], apart)

    def advance(self, end: At, seconds: Floats) -> None:
        """Take two half steps."""
        loop, at, drive = self.batch.loop, self._at(self.batch.at), self._drive()
        half, last = seconds[self.own] / 2, self._at(end)
        middle = at_wind(loop, drive.cell, (at.wind + last.wind) / 2)
        between, _ = step(loop, self.state, at, middle, drive, half)
        self.state, _ = step(loop, between, middle, last, drive, half)

    def _at(self, at: At) -> At:
        return at.of(self.own)

    def _drive(self) -> Drive:
        return self.batch.drive.of(self.own)


def _assigned(count: int, draw: np.random.Generator) -> Cells:
    """Return the player of each run, in the players' shares, at random places."""
    weights = np.array([share for _, share in PLAYERS.values()])
    edges = np.round(np.cumsum(weights) / weights.sum() * count).astype(int)
    player = np.searchsorted(edges, np.arange(count), side="right")
    return draw.permutation(player)
