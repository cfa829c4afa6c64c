"""Parts of the sentences on how fast winds may move, and on how fast actuators do."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.words.rounded import (
    at_least,
    at_most,
    range_around,
    range_within,
)

# The rates of which a sentence names the winds [m/s^2].
NAMED_RATES = tuple(map(Fraction, ("0.02", "0.05", "0.1", "0.2", "0.5", "1", "1.5", "2", "3", "5")))


def range_sentence(wind: Sequence[Fraction], rate: Sequence[Fraction], error: Fraction) -> str:
    """Return how fast an estimate may move in a range of winds.

    Parameters
    ----------
    wind, rate : nodes, and the estimate's rate there.
    error : of the estimate.
    """
    known = "known exactly" if error == 0 else f"known to {at_least(error, 3)} m/s"
    steps = [f"{at_least(min(rate), 3)} m/s^2 everywhere"]
    for named in NAMED_RATES:
        start = _from(wind, rate, named)
        if start is not None and named > min(rate):
            steps.append(f"{at_most(named, 3)} m/s^2 from {at_most(start, 6)} m/s on")
    winds = range_within(wind[0], wind[-1])
    return f"wind and estimate within {winds} m/s, {known}: at least {', '.join(steps)}"


def _from(wind: Sequence[Fraction], rate: Sequence[Fraction], named: Fraction) -> Fraction | None:
    """Return the least wind from which the rate is at least ``named`` up to the range's end."""
    if rate[-1] < named:
        return None
    for i in range(len(wind) - 2, -1, -1):
        low, high = rate[i : i + 2]
        if low < named:
            return wind[i] + (wind[i + 1] - wind[i]) * (named - low) / (high - low)
    return wind[0]


def beyond_words(within: Sequence[bool], winds: Sequence[tuple[Fraction, Fraction]]) -> str:
    """Return the winds of the cells that are not within a limit, adjacent cells joined."""
    joined: list[list[Fraction]] = []
    for inside, (low, high) in zip(within, winds, strict=True):
        if not inside and joined and joined[-1][1] == low:
            joined[-1][1] = high
        elif not inside:
            joined.append([low, high])
    return "".join(f", NOT for {range_around(low, high)} m/s" for low, high in joined)
