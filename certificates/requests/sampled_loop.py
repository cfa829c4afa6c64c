"""Requests the loop with a law that runs every T seconds and holds its command."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.document.model_data import rounded_down, short
from takagi.certificates.requests.decay import common_function
from takagi.certificates.requests.invariant_ellipsoid import candidate_set
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import box_rows, largest_level, state_halves
from takagi.certificates.requests.request import Attempt, Request, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.analysis.sampled_loop import SampledFunction

DIGITS = (6, 9, 12)
# Degrees of the function to try, and the degree used to search the largest sample time.
DEGREES, HIGHEST = (2, 4), 8
# Fractions of the largest rate in continuous time: for a large set, and for any set.
OF_A_LARGE_SET, OF_ANY = (0.2, 0.05), (0.5, 0.1, 0.0)
# A large set's function is at least this share of that of continuous time.
LEAST_SHARE = 0.8
# For the search of the largest sample time: the shortest to try [s], the factor from one to the
# next, and the ratio of upper to lower bound at which bisection ends.
SHORTEST, STEP_FACTOR, CLOSE_RATIO = 1e-5, 2.0, 1.02
# Fractions of the sample time found, tried until the rounded numbers prove the claim.
BACK_OFF = (0.998, 0.99, 0.97, 0.9, 0.7)
# The level is lowered by this share, so that its rounding cannot leave the box.
SPARE = 1e-9


@dataclass(frozen=True, slots=True)
class SampledLoop(Request):
    """V = x'Px decreases from sample to sample; the command is held between them.

    Attributes
    ----------
    sample_time : T [s]; None takes the largest found.
    below : upper limit of that search [s]. A loop with a vibration may happen to decay at a
        sample time near the vibration's period, but not at half of it.
    """

    sample_time: float | None = None
    below: float = 60.0

    def __post_init__(self) -> None:
        for name, step in (("sample_time", self.sample_time), ("below", self.below)):
            if step is not None and not (np.isfinite(step) and 1e-9 <= step <= 1e6):
                raise ModelError(f"{name} = {step!r} was given; a number of seconds is needed")

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``sampled-loop``.

        Raises
        ------
        ModelError : a loop in discrete time, without gains, or of a blended plant.
        """
        _require_held_command(loop)
        answer = common_function(loop)
        rate = answer.decay_rate or 0.0
        if answer.P is None or rate <= 0:
            return self._undecided(loop, "no common function in continuous time")
        search = _Search(loop, np.asarray(answer.P), rate)
        claims = (
            search.largest(self.below) if self.sample_time is None else search.at(self.sample_time)
        )
        first = next(claims, None)
        if first is None:
            step = "any time" if self.sample_time is None else f"{self.sample_time:g} s"
            return self._undecided(loop, f"no function was found for a sample every {step}")
        return first_proved(loop, chain([first], claims), "candidate")

    def _undecided(self, loop: ClaimedLoop, why: str) -> Attempt:
        """Return a claim without evidence, for which the checker answers UNDECIDED."""
        n, m = loop.exact.order, loop.model.B.shape[2]
        functions = np.stack([np.eye(n + m)] * 2)
        return first_proved(
            loop, [(why, _claim(loop, np.eye(n), functions, self.sample_time or 1.0, 1.0, 0.0))]
        )


def _claim(
    loop: ClaimedLoop, P: Floats, functions: Floats, step: float, level: float, rate: float
) -> dict[str, Any]:
    return {
        "name": f"sampled loop of {loop.model.name or 'the model'} every {step:g} s",
        "kind": "sampled-loop",
        "sample_time": step,
        "decay_rate": rate,
        "level": level,
        "P": P.tolist(),
        "functions": functions.tolist(),
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """The search region of the functions: near P of continuous time, with ``rate`` [1/s]."""

    loop: ClaimedLoop
    P: Floats
    rate: float

    def at(self, step: float) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield (words, claim) at a sample time, the best first."""
        has_box = len(box_rows(self.loop)) > 0
        large_set_shape = candidate_set(self.loop, None, None, None)[1] if has_box else None
        for share in OF_A_LARGE_SET if large_set_shape is not None else ():
            yield from self._claims(step, large_set_shape, share, DEGREES[0], LEAST_SHARE)
        for degree in (*DEGREES, HIGHEST):
            for share in OF_ANY:
                yield from self._claims(step, self.P, share, degree, 0.0)

    def largest(self, below: float) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield (words, claim) at about the largest sample time, then at smaller ones."""
        low = self._longest(below)
        for share in BACK_OFF if low else ():
            step = rounded_down(share * low, 3)
            for words, claim in self._claims(step, self.P, 0.0, HIGHEST, 0.0):
                yield words, claim | {"name": f"{claim['name']}, the largest time found"}

    def _longest(self, below: float) -> float:
        """Return about the largest sample time for which a function is found; 0 for none."""

        def holds(step: float) -> bool:
            return self._function(step, self.P, 0.0, HIGHEST) is not None

        low = below / STEP_FACTOR
        while not holds(low):
            low /= STEP_FACTOR
            if low < SHORTEST:
                return 0.0
        high = STEP_FACTOR * low
        while high > CLOSE_RATIO * low:
            middle = float(np.sqrt(low * high))
            low, high = (middle, high) if holds(middle) else (low, middle)
        return low

    def _claims(
        self, step: float, shape: Floats | None, share: float, degree: int, least_share: float
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        rate = rounded_down(share * self.rate, 3)
        shape = self.P if shape is None else shape
        candidate = self._function(step, shape, rate, degree, least_share)
        if candidate is None:
            return
        for digits in DIGITS:
            P = short(candidate.P, digits)
            functions = np.array([short(function, digits) for function in candidate.functions])
            level = self._level(P, functions)
            words = f"a sample every {step:g} s, rate {rate:g} 1/s, degree {degree}"
            claim = _claim(self.loop, P, functions, step, level, rate)
            yield f"{words}, to {digits} digits", claim

    def _function(
        self, step: float, shape: Floats, rate: float, degree: int, least_share: float = 0.0
    ) -> SampledFunction | None:
        from takagi.lmi.analysis.sampled_loop import sampled_function

        model, gains = self.loop.model, self.loop.gains
        assert gains is not None
        return sampled_function(
            model.A,
            model.B,
            np.unique(gains, axis=0),
            step,
            near_function=shape,
            degree=degree,
            decay_rate=rate,
            smallest=least_share,
        )

    def _level(self, P: Floats, functions: Floats) -> float:
        """Return about the largest level whose set lies in the box, at samples and between them."""
        if not len(box_rows(self.loop)) or np.linalg.eigvalsh(P)[0] <= 0:
            return 1.0
        halves = state_halves(self.loop)
        level = largest_level(self.loop, P)
        for function in functions:
            if np.linalg.eigvalsh(function)[0] <= 0:
                continue
            reach = np.diag(np.linalg.inv(function))[: len(halves)] / halves**2
            if reach.max() > 0:
                level = min(level, float((1 - SPARE) / reach.max()))
        return rounded_down(level)


def _require_held_command(loop: ClaimedLoop) -> None:
    if loop.gains is None:
        raise ModelError("a sample time is about u = -K x that is held; give gains")
    if loop.sample_time is not None:
        raise ModelError(
            f"model {loop.model.name!r} is in discrete time, with a sample every "
            f"{loop.sample_time:g} s: its claims are about the sampled loop already"
        )
    if "blending" in loop.model_data:
        raise ModelError(
            f"model {loop.model.name!r} has an effort that the law integrates: a claim about a "
            "command that is held does not cover it yet; leave the sample time out"
        )
    if "references" in (loop.gains_data or {}):
        raise ModelError(
            f"the law of model {loop.model.name!r} integrates what follows its references, once in "
            "a sample: a claim about a command that is held does not cover it yet; leave the "
            "sample time out"
        )
