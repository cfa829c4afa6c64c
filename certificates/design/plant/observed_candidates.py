r"""Gains and observer of a law with measured outputs, judged beside LQR with a Kalman filter.

Where nothing is asked, gains by LMIs and LQR's at rest are each paired with Kalman filters of the
plant at rest for

    states pushed over half their ranges in one time constant of LQR,
    outputs off by 100, 30 or 10 % of their sizes,

and the former also with observers by LMIs.  Of a pair a user sees the set of starts that is proved
at the rate of the design, the time in which the plant with the observer settles from the ends of
that set's axes (inputs cut), and how far the loop is from losing stability at rest: the disk margin
at the inputs

    alpha = min over w of 2 / sigma_max((I - H)(I + H)^-1),
    H(j w) = K (j w - A + B K + L C)^-1 L C (j w - A)^-1 B.

Those pairs are good enough whose set is at least as large as that of LQR with its Kalman filter,
and which settle at most 1.2 times as late from the same starts.  Of these the one with the largest
margin is taken; of several with 0.75 (a phase margin of 41 degrees) the fastest with about the
largest set.

Sources: Bryson and Ho (1975), Applied Optimal Control, section 5.2, for the weights; Seiler,
Packard and Gahinet (2020), An Introduction to Disk Margins, IEEE Control Systems 40(5), for alpha.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.plant.candidates import (
    DIGITS,
    EQUAL,
    SLOWER,
    Contest,
    ends_of_axes,
    horizon_of,
    regulator_gain,
    slowest_rate,
)
from takagi.certificates.design.plant.gain_task import (
    FoundGains,
    rounded_gains,
    weights_at_rest,
)
from takagi.models.arrays import Floats
from takagi.models.laws.pdc import OutputFeedback, PdcLaw

if TYPE_CHECKING:
    from takagi.lmi import Design

OUTPUT_SHARES = (1.0, 0.3, 0.1)
NEARLY_BEST = 0.8  # share of the largest set, at which the slowest of LQR's fast filters is taken
# With more states or matrices the sets of all pairs take longer than a few seconds.
MOST_STATES, MOST_LOOPS = 6, 64
ENOUGH = 0.75  # disk margin, beyond which more is not sought
FREQUENCIES = np.logspace(-3, 3, 301)  # over the rate of the gains


@dataclass(frozen=True, slots=True, eq=False)
class ObserverPair:
    """Gains and an observer, with what a user sees of the two.

    Attributes
    ----------
    gains : with the notes about them.
    K, L : (r, m, n) and (r or 1, n, p), rounded as they are judged.
    P : (2 n, 2 n), of the set {z' P z <= 1} of states and estimates.
    starts : (2 n, n), of z = N x at the start.
    note : which observer it is.
    observer : its LMIs; None for a Kalman filter.
    """

    gains: FoundGains
    K: Floats
    L: Floats
    P: Floats
    starts: Floats
    note: str
    observer: Design | None

    @property
    def shape(self) -> Floats:
        """(n, n), of the set of starts {x' shape x <= 1}."""
        return np.asarray(self.starts.T @ self.P @ self.starts)

    @property
    def size(self) -> float:
        """The n-th root of the volume of the set of starts, over that of the unit ball."""
        return float(np.exp(-0.5 * np.linalg.slogdet(self.shape)[1] / len(self.shape)))


def kalman_gains(contest: Contest, C: Floats) -> Iterator[tuple[str, Floats]]:
    """Yield words and L (1, n, p) of Kalman filters of the plant at rest, slowest first.

    Parameters
    ----------
    C : (p, n), of the measured outputs at rest.
    """
    step = contest.task.model.sample_time
    A, B = contest.at_rest
    rate = slowest_rate(A - B @ contest.regulator, step)
    time = 1 / rate if step is None else 1 / (rate * step)
    outputs = np.abs(C) @ contest.sizes
    for share in OUTPUT_SHARES:
        sizes = time**0.5 / contest.sizes, 1 / (share * outputs * time**0.5)
        L = regulator_gain(A.T, C.T, *sizes, step)
        if L is not None:
            words = f"observer: a Kalman filter for outputs off by {share:.0%} of their sizes"
            yield words, rounded_gains(L.T[None], DIGITS)


def best_pair(
    contest: Contest,
    pairs: Sequence[ObserverPair],
    regulators: Sequence[ObserverPair],
    rows: tuple[int, ...],
    *,
    at_estimate: bool,
) -> ObserverPair | None:
    """Return the pair to be proved; None where LQR has no set with any of its filters.

    Parameters
    ----------
    pairs : of other gains and observers.
    regulators : LQR at rest with its Kalman filters, the slowest first; also candidates.
    rows, at_estimate : of the observers, as in ``OutputFeedback``.
    """
    judge = _Judge(contest, rows, at_estimate)
    times = [judge.time(pair, pair) for pair in regulators]
    if not np.isfinite(min(times, default=np.inf)):
        return None
    largest = max(pair.size for pair in regulators)
    beside = next(
        pair
        for pair, time in zip(regulators, times, strict=True)
        if (pair.size >= NEARLY_BEST * largest and time <= SLOWER * min(times))
        or time == min(times)
    )
    candidates = (*pairs, *regulators)
    large = [pair for pair in candidates if pair.size >= (1 - EQUAL) * beside.size]
    large.sort(key=judge.margin, reverse=True)
    for _, equal in groupby(large, key=judge.margin):
        fast = {
            pair: time
            for pair in equal
            if (time := judge.time(pair, pair)) <= SLOWER * (1 + EQUAL) * judge.time(beside, pair)
        }
        if fast:
            least_size = NEARLY_BEST * max(pair.size for pair in fast)
            return min((pair for pair in fast if pair.size >= least_size), key=lambda p: fast[p])
    return beside


@dataclass(frozen=True, slots=True, eq=False)
class _Judge:
    contest: Contest
    rows: tuple[int, ...]
    at_estimate: bool

    def time(self, law: ObserverPair, starts: ObserverPair) -> float:
        """Return the settling time [s] of a law from the set of another."""
        model = self.contest.task.model
        ends, reach = ends_of_axes(starts.shape)
        rest = np.zeros(len(model.states)), np.zeros(len(model.inputs))
        feedback = OutputFeedback(PdcLaw(model, law.K, *rest), law.L, self.rows, self.at_estimate)
        A, B, C, K, L = self._matrices(law)
        joint = np.block([[A, -B @ K], [L @ C, A - B @ K - L @ C]])
        horizon = horizon_of([joint], model.sample_time)
        times = self.contest.motions.settling_times(feedback, law.starts @ ends, reach, horizon)
        return float(times.max())

    def _matrices(self, law: ObserverPair) -> tuple[Floats, ...]:
        """Return A, B, C, K and L at rest."""
        A, B = self.contest.at_rest
        h = weights_at_rest(self.contest.task.model)
        C = np.tensordot(h, self.contest.task.model.C[:, list(self.rows)], axes=1)
        L = law.L[0] if len(law.L) == 1 else np.tensordot(h, law.L, axes=1)
        return A, B, C, np.tensordot(h, law.K, axes=1), L

    def margin(self, law: ObserverPair) -> float:
        """Return the disk margin at the inputs, at rest, or what is enough of it."""
        A, B, C, K, L = self._matrices(law)
        step, eye = self.contest.task.model.sample_time, np.eye(len(A))
        rate = np.abs(np.linalg.eigvals(A - B @ K)).max()
        w = FREQUENCIES * rate if step is None else np.linspace(0, np.pi, 301)[1:]
        s = (1j * w if step is None else np.exp(1j * w))[:, None, None]
        loop = K @ np.linalg.solve(s * eye - (A - B @ K - L @ C), L) @ C
        loop = loop @ np.linalg.solve(s * eye - A, B + 0 * s)
        one = np.eye(len(K))
        gain = np.linalg.norm((one - loop) @ np.linalg.inv(one + loop), 2, (1, 2)).max()
        return min(float(2 / gain), ENOUGH)
