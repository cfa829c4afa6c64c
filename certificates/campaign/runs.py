"""Thousands of random runs of the certified loop, inside the certified class or beyond it.

A simulation is not a proof. Without a violation, the theorem, its proof and its implementation
agree in all runs tried; one violation shows that one of the three is wrong.  Run number n of a seed
is the same whatever the number of runs, of processes, or of runs to a task.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.campaign.motion import (
    BOUNDS,
    EVENTS,
    PLAYERS,
    TOLERANCE,
    CertifiedLoop,
    certified_loop,
    run,
)
from takagi.certificates.sweep.tasks import Result, Task, Tell, run_tasks
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean

DURATION = 60.0
MOST_RUNS, LARGEST = 10_000_000, 1000.0
# Runs to a task: about a second of work.
TOGETHER = 250
# The kinds of consecutive runs.
KINDS = tuple(kind for kind, count in enumerate(PLAYERS) for _ in range(count))
# Written digits of a number.
DIGITS = 8
# What ``--beyond`` knows, and the members of the loop that it multiplies or replaces.
REQUESTS: Mapping[str, tuple[str, ...]] = {
    "wind": ("wind_error", "wind_rate"),
    "wind-error": ("wind_error",),
    "wind-rate": ("wind_rate",),
    "start": (),
    "inertia": ("inertia",),
    "wake": ("wake",),
}
# The requests that ``--beyond all`` stands for.
STANDARD = (
    *("wind=1.5", "wind=3", "wind=10", "wind-error=5", "wind-rate=5", "start=4"),
    *("inertia=0.8:1.2", "inertia=0.5:2", "wake=3"),
)


@dataclass(frozen=True, slots=True)
class Beyond:
    """How far a campaign goes beyond the certified class, as ``--beyond`` asks for it.

    Kinds: ``wind``, ``wind-error``, ``wind-rate`` : the class of every cell, times a number.
    ``start`` : starts with V up to it.  ``inertia`` : from LOW to HIGH of nominal.  ``wake`` : up
    to this share of the frozen wake's additional effectiveness.  Empty: inside the class.
    """

    kind: str = ""
    numbers: tuple[float, ...] = (1.0,)

    @property
    def name(self) -> str:
        """The request, such as ``wind=3``."""
        numbers = ":".join(f"{number:g}" for number in self.numbers)
        return f"{self.kind}={numbers}" if self.kind else "inside"

    def loop(self, loop: CertifiedLoop) -> CertifiedLoop:
        """Return the loop with this class and these plants; its bounds are the certificate's."""
        if self.kind == "inertia":
            return loop._replace(inertia=np.array(self.numbers))
        changed = REQUESTS.get(self.kind, ())
        return loop._replace(**{name: self.numbers[0] * getattr(loop, name) for name in changed})


INSIDE = Beyond()


def beyond_of(text: str) -> Beyond:
    """Return the value for a request ``3``, ``wind=3``, ``start=4``, ``inertia=0.8:1.2``, ...

    Raises
    ------
    ModelError : another kind, or a number that is not positive.
    """
    kind, _, value = text.rpartition("=")
    kind = kind.strip() or "wind"
    if kind not in REQUESTS:
        raise ModelError(
            f"--beyond {text}: {kind!r} is not one of {', '.join(REQUESTS)}"
            f"{did_you_mean(kind, REQUESTS)}; write wind=3 or inertia=0.8:1.2"
        )
    try:
        numbers = tuple(float(number) for number in value.split(":"))
    except ValueError:
        numbers = ()
    if len(numbers) != 1 + (kind == "inertia") or not 0 < numbers[0] <= numbers[-1] <= LARGEST:
        needed = "two numbers, LOW:HIGH," if kind == "inertia" else "one number"
        raise ModelError(
            f"--beyond {text}: {needed} above 0 and up to {LARGEST:g} is needed after {kind}="
        )
    if kind == "start" and numbers[0] <= 1:
        raise ModelError(
            f"--beyond {text}: starts up to V = {numbers[0]:g} are within the certificate; give a "
            "number above 1, or leave --beyond out"
        )
    return Beyond(kind, numbers)


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """The runs of a campaign, in arrays of one column a run.

    Attributes
    ----------
    beyond : ``INSIDE``, or how far the runs go beyond the certified class.
    duration : of every run [s].
    share : (bounds, n), and events : name -> (n,), as ``motion.run`` writes them.
    """

    loop: CertifiedLoop
    beyond: Beyond
    duration: float
    seed: int
    share: Floats
    events: Mapping[str, Floats]

    @property
    def runs(self) -> int:
        """The number of runs."""
        return len(self.share[0])

    @property
    def broken(self) -> NDArray[np.bool_]:
        """(bounds, n) true where the run exceeded the bound."""
        return np.asarray(self.share > 1 + TOLERANCE)

    @property
    def violations(self) -> int:
        """The number of runs that exceeded a bound."""
        return int(np.count_nonzero(self.broken.any(axis=0)))

    @property
    def overspeed(self) -> Floats:
        """The largest excess of rotor speed over rated of each run [%]."""
        speed = self.loop.top_speed + self.share[BOUNDS.index("rotor speed")] * self.loop.peaks[0]
        return np.asarray(100 * (speed / self.loop.rated_speed - 1))


def run_campaigns(
    certificate: Path,
    folder: Path,
    classes: Sequence[Beyond],
    *,
    runs: int,
    duration: float = DURATION,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> list[Campaign]:
    """Return the random runs of a certificate's loop, for each class.

    Parameters
    ----------
    certificate : file with a claim of kind ``coherent-loop``.
    folder, workers, scheduler, tell : see ``run_tasks``.
    runs : of each campaign;  seed : the same one gives the same runs.

    Raises
    ------
    ModelError : no such claim; numbers that make no sense; what ``run_tasks`` refuses.
    OSError : a result cannot be written.
    """
    require_numbers(runs, duration, seed)
    text = certificate.read_bytes()
    fixed = {"certificate": hashlib.sha256(text).hexdigest(), "duration": duration, "seed": seed}
    loop, campaigns, starts = _loop(text), [], range(0, runs, TOGETHER)
    inputs = [
        {"beyond": [beyond.kind, list(beyond.numbers)], "from": n, "to": min(n + TOGETHER, runs)}
        for beyond in classes
        for n in starts
    ]
    results, _ = run_tasks(
        [Task(f"{__name__}:some_runs", text, {**fixed, **each}) for each in inputs],
        folder,
        workers=workers,
        scheduler=scheduler,
        tell=tell,
    )
    error = next((result["error"] for result in results if "error" in result), None)
    if error is not None:
        raise ModelError(f"random runs could not be made: {error}")
    for i, beyond in enumerate(classes):
        group = results[i * len(starts) : (i + 1) * len(starts)]
        share, events = (
            np.concatenate([np.array(result[name], float) for result in group], axis=1)
            for name in ("share", "events")
        )
        by_name = dict(zip(EVENTS, events, strict=True))
        campaigns.append(Campaign(loop, beyond, duration, seed, share, by_name))
    return campaigns


def require_numbers(runs: int, duration: float, seed: int) -> None:
    """Refuse numbers of a campaign that make no sense: what was given, and what is needed."""
    if not 1 <= runs <= MOST_RUNS:
        raise ModelError(f"{runs} runs were asked for; 1 to {MOST_RUNS} are possible")
    if not 0 < duration < math.inf:
        raise ModelError(f"a duration of {duration:g} s was asked for; it must be above 0")
    if seed < 0:
        raise ModelError(f"seed {seed} was given; 0 or more is needed")


def some_runs(certificate: bytes, inputs: Mapping[str, Any]) -> Result:
    """Return a task's result: some runs, with None in place of nan."""
    beyond, numbers = Beyond(*inputs["beyond"]), range(inputs["from"], inputs["to"])
    loop = beyond.loop(_loop(certificate))
    level = beyond.numbers[0] if beyond.kind == "start" else 1.0
    share, events = np.empty((len(numbers), len(BOUNDS))), np.empty((len(numbers), len(EVENTS)))
    for i, n in enumerate(numbers):
        draw = np.random.default_rng([inputs["seed"], n])
        run(loop, draw, KINDS[n % len(KINDS)], level, inputs["duration"], share[i], events[i])
    return {"share": [_plain(row) for row in share.T], "events": [_plain(row) for row in events.T]}


@lru_cache(maxsize=1)
def _loop(certificate: bytes) -> CertifiedLoop:
    """Return the loop of a certificate's text; read once in each process."""
    return certified_loop(json.loads(certificate))


def _plain(values: Floats) -> list[float | None]:
    return [float(f"{x:.{DIGITS}g}") if math.isfinite(x) else None for x in values.tolist()]
