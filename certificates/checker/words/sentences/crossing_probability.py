"""The sentence of a proved claim of kind ``crossing-probability``."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kinds.crossing_probability import Crossing
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import about, deviations
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly


def said(
    name: str,
    loop: PolytopicLoop,
    asked: Crossing,
    pieces: int,
    horizon: Fraction,
    probability: Fraction,
) -> tuple[str, str]:
    """Return name and sentence."""
    many = f" ({pieces} pieces of them)" if pieces > 1 else ""
    constant = f" with constant weights{many}: parameters do not change with time"
    along = about(loop) + (constant if loop.rules > 1 else "")
    given = asked.way == "disturbances"
    model = "the model's disturbance" if given else "w added to u"
    alone = ", without the model's disturbance" if not given and loop.E else ""
    return name, (
        f"the probability that |y| reaches {at_most(asked.limit, 6)} within "
        f"{at_least(horizon, 6)} s is at most {at_most(probability, 6)}, from x = 0 at the start, "
        f"along {along}; y = {_signal(asked, loop)}; {model} is "
        f"{_noise(asked, loop)}{alone}; the loop is linear, and no plant's box is claimed"
        f"{deviations(loop, 'x' + ('w' if given else ''))}"
    )


def _signal(asked: Crossing, loop: PolytopicLoop) -> str:
    """Return y as a sum of states."""
    pairs = [(asked.row[0, k], state) for k, state in enumerate(loop.states)]
    return " + ".join(
        state if factor == 1 else f"{exactly(factor)} {state}" for factor, state in pairs if factor
    )


def _noise(asked: Crossing, loop: PolytopicLoop) -> str:
    """Return which w_k are white noise, with their intensities, and which are at rest."""
    own = loop.disturbances if asked.way == "disturbances" else loop.inputs
    names = own or tuple(f"w_{k + 1}" for k in range(len(asked.noise)))
    sizes = list(zip(names, asked.noise, strict=True))
    noise = [f"{at_least(size, 6)}^2 for {name}" for name, size in sizes if size]
    still = [f"{name} is at rest" for name, size in sizes if not size]
    return ", ".join([f"white noise, independent, of intensity {', '.join(noise)}", *still])
