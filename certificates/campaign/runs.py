"""Thousands of random runs of the certified loop, compared with the certificate.

A simulation is not a proof. Without a violation, the theorem, its proof and its implementation
agree in all runs tried; one violation shows that one of the three is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.campaign.batch import Records, run_batch
from takagi.certificates.campaign.bounds import BOUNDS
from takagi.certificates.campaign.loop import CertifiedLoop, certified_loop
from takagi.certificates.campaign.outside import INSIDE, Beyond
from takagi.models.errors import ModelError

Tell = Callable[[str, float], None]

DURATION = 60.0
# A ratio may exceed 1 by this, because steps are finite. Every campaign measures how far steps half
# as long change a ratio (``Records.halving``), and must stay below this.
TOLERANCE = 1e-4
# A step is this fraction of the pitch drive's time constant, the smallest in the loop.
STEP_SHARE = 0.1
# Number of runs that are advanced together, chosen so that their arrays fit in the CPU cache.
TOGETHER = 2500
MOST_RUNS = 10_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """The runs of a campaign; ``records`` has one column per run.

    Attributes
    ----------
    beyond : ``INSIDE``, or how far the runs go beyond the certified class.
    step : the longest step [s];  duration : of every run [s].
    """

    loop: CertifiedLoop
    beyond: Beyond
    duration: float
    step: float
    seed: int
    tolerance: float
    records: Records

    @property
    def runs(self) -> int:
        """The number of runs."""
        return len(self.records.start_wind)

    @property
    def broken(self) -> NDArray[np.bool_]:
        """(bounds, n) true where the run exceeded the bound."""
        return np.asarray(np.isfinite(self.records.broken_at))

    @property
    def violations(self) -> int:
        """The number of runs that exceeded a bound or left the coefficient table."""
        lost = np.isfinite(self.records.lost_at)
        return int(np.count_nonzero(self.broken.any(axis=0) | lost))

    @property
    def coarse(self) -> bool:
        """Whether steps half as long change a share by more than the tolerance."""
        return float(self.records.halving.max()) > self.tolerance

    def largest(self, bound: str) -> float:
        """Return the largest share of a bound that any run used; nan if none was asked."""
        row = self.records.share[BOUNDS.index(bound)]
        return float(np.nanmax(row)) if np.any(~np.isnan(row)) else float("nan")


def require_numbers(runs: int, duration: float, seed: int) -> None:
    """Refuse numbers of a campaign that make no sense; see ``run_campaign``.

    Raises
    ------
    ModelError : says what was given, and what is needed.
    """
    if not 1 <= runs <= MOST_RUNS:
        raise ModelError(f"{runs} runs were asked for; 1 to {MOST_RUNS} are possible")
    if not 0 < duration < np.inf:
        raise ModelError(f"a duration of {duration:g} s was asked for; it must be above 0")
    if seed < 0:
        raise ModelError(f"seed {seed} was given; 0 or more is needed")


def run_campaign(
    document: Mapping[str, Any],
    *,
    runs: int = 10_000,
    duration: float = DURATION,
    seed: int = 0,
    beyond: Beyond = INSIDE,
    tell: Tell | None = None,
) -> Campaign:
    """Return what random runs of the loop of a certificate did, compared with its bounds.

    Parameters
    ----------
    document : a certificate with a claim of kind ``coherent-loop``, as plain data (its JSON).
    runs : number of runs;  duration : of each [s].
    seed : the same one gives the same runs.
    beyond : how far to go beyond the certified class; the default stays inside.
    tell : called with a text and the fraction that is done.

    Raises
    ------
    ModelError : no such claim; numbers that make no sense.
    """
    require_numbers(runs, duration, seed)
    loop = certified_loop(document)
    step = STEP_SHARE * loop.pitch_lag
    sizes = [min(TOGETHER, runs - begun) for begun in range(0, runs, TOGETHER)]
    found = []
    for i, size in enumerate(sizes):

        def told(part: float, before: int = sum(sizes[:i]), size: int = size) -> None:
            if tell is not None:
                tell(f"{beyond.name}: {runs} runs", (before + part * size) / runs)

        found.append(
            run_batch(
                loop,
                size,
                np.random.default_rng([seed, i]),
                duration=duration,
                longest_step=step,
                tolerance=TOLERANCE,
                beyond=beyond,
                tell=told,
            )
        )
    return Campaign(loop, beyond, duration, step, seed, TOLERANCE, _joined(found))


def _joined(found: list[Records]) -> Records:
    columns = {
        field.name: np.concatenate([getattr(each, field.name) for each in found], axis=-1)
        for field in fields(Records)
        if field.name != "halving"
    }
    return Records(**columns, halving=np.max([each.halving for each in found], axis=0))
