"""The meaning of a better or worse figure in one or two words: "faster", "a smaller set"."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from takagi.reports.baseline.comparison import BOX, GainSize, Moved

# How the name of a figure begins -> the word where it is better, and where it is worse.
_WORDS: tuple[tuple[str, str, str], ...] = (
    ("decay rate", "faster", "slower"),
    ("common decay rate", "faster", "slower"),
    ("settling time", "faster", "slower"),
    ("volume of the set", "larger set", "smaller set"),
    ("reach along", "larger set", "smaller set"),
    ("overshoot", "smaller overshoot", "larger overshoot"),
    ("overspeed", "smaller overspeed", "larger overspeed"),
    ("gain", "weaker effect of the disturbance", "stronger effect of the disturbance"),
    ("norm", "weaker effect of the disturbance", "stronger effect of the disturbance"),
    ("energy bound", "larger disturbance withstood", "smaller disturbance withstood"),
    ("bound on disturbance", "larger disturbance withstood", "smaller disturbance withstood"),
    ("wind error", "larger wind error withstood", "smaller wind error withstood"),
    ("error of the estimate", "larger wind error withstood", "smaller wind error withstood"),
    ("wind rate", "faster wind withstood", "slower wind withstood"),
    ("rate of the wind", "faster wind withstood", "slower wind withstood"),
    ("rates of weights", "faster weights allowed", "slower weights allowed"),
    ("relative rounding", "more room to round the gains", "not as much room to round the gains"),
    ("absolute rounding", "more room to round the gains", "not as much room to round the gains"),
    ("enlargement", "more room beyond the box", "not as much room beyond the box"),
    ("limit of input", "smaller commands", "larger commands"),
    ("limit of rate", "slower commands", "faster commands"),
    ("torque step", "calmer actuators", "busier actuators"),
    ("largest", "calmer actuators", "busier actuators"),
    ("sample time", "longer sample time allowed", "shorter sample time needed"),
    ("inertia", "more plants covered", "fewer plants covered"),
    ("frozen wake", "more plants covered", "fewer plants covered"),
    ("speed overlap", "larger overlap", "smaller overlap"),
    ("torque overlap", "larger overlap", "smaller overlap"),
)
# Relative change of a figure that rounding on another processor may cause.
ROUNDING = 1e-3
# A ratio of gains nearer to 1 than this is not mentioned.
_ALIKE = 0.005


def word_of(moved: Moved) -> str:
    """Return what a change means, such as ``"slower"``; empty where nothing has changed."""
    if not moved.change:
        return ""
    better = moved.change > 0
    if moved.claim == BOX:
        return "wider box" if better else "narrower box"
    for start, good, bad in _WORDS:
        if moved.figure.startswith(start):
            return good if better else bad
    return "better" if better else "worse"


def verdict(moved: Sequence[Moved], gains: Iterable[GainSize]) -> str:
    """Return on the whole what got better and what worse, in one phrase.

    A figure that got worse within the tolerance counts too, because the phrase is about the
    direction of the change; changes within rounding do not count.
    """
    found = [(one.change > 0, word_of(one)) for one in moved if not _alike(one)]
    good = list(dict.fromkeys(word for better, word in found if better))
    bad = list(dict.fromkeys(word for better, word in found if not better))
    if good and bad:
        told = f"partly better ({', '.join(good)}), partly worse ({', '.join(bad)})"
    elif good:
        told = f"better ({', '.join(good)})"
    elif bad:
        told = f"worse ({', '.join(bad)})"
    else:
        told = "no figure changed"
        told += f" by more than {100 * ROUNDING:g} %" if any(one.change for one in moved) else ""
    sizes = gain_words(gains)
    return f"{told}; {sizes}" if sizes else told


def gain_words(gains: Iterable[GainSize]) -> str:
    """Return how the largest gains compare; empty where they are alike or cannot be compared."""
    ratios = [one.ratio for one in gains if one.ratio is not None]
    if not ratios or all(abs(ratio - 1) < _ALIKE for ratio in ratios):
        return ""
    low, high = min(ratios), max(ratios)
    if low > 1 - _ALIKE:
        return f"larger gains, up to {high:.3g} times"
    if high < 1 + _ALIKE:
        return f"smaller gains, down to {low:.3g} times"
    return f"gains from {low:.3g} to {high:.3g} times the old ones"


def _alike(moved: Moved) -> bool:
    return bool(-ROUNDING <= moved.change <= ROUNDING)
