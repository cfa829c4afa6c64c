"""The sentence of a proved claim of kind ``exit-probability``."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kinds.exit_probability import NoisyMotion
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.ellipsoid_size import rounded_size
from takagi.certificates.checker.words.loop_words import (
    about,
    deviations,
    granted,
    in_which_sense,
    unforeseeing,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(
    name: str,
    loop: PolytopicLoop,
    moved: NoisyMotion,
    start: Fraction,
    horizon: Fraction,
    probability: Fraction,
) -> tuple[str, str]:
    """Return name and sentence."""
    begins = f"x'Px <= {at_least(start, 6)}" if start else "x = 0"
    model = "the model's disturbance" if moved.way == "disturbances" else "w added to u"
    alone = ", without the model's disturbance" if moved.way == "inputs" and loop.E else ""
    return name, (
        f"the probability that x'Px reaches 1 within {at_least(horizon, 6)} s is at most "
        f"{at_most(probability, 6)}, from {begins} at the start, along {about(loop)}"
        f"{unforeseeing(loop)}; {model} is {_parts(moved, loop)}"
        f"{in_which_sense(loop, moved.E)}{alone}{granted(loop, disturbances_too=False)}"
        f"; the set is x'Px <= 1{_inside(loop)}"
        f"{rounded_size(moved.P, Fraction(1), loop.states)}"
        f"{deviations(loop, 'x' + ('w' if moved.way == 'disturbances' else ''))}"
    )


def _inside(loop: PolytopicLoop) -> str:
    """Return that the set lies in the model's box, if the model has one."""
    return ", inside the model's box" if while_valid(loop) else ""


def _parts(moved: NoisyMotion, loop: PolytopicLoop) -> str:
    """Return which w_k are white noise, with their intensities, and which are bounded."""
    own = loop.disturbances if moved.way == "disturbances" else loop.inputs
    names = own or tuple(f"w_{k + 1}" for k in range(len(moved.noise)))
    sizes = list(zip(names, moved.noise, moved.bounds, strict=True))
    noise = [f"{at_least(size, 6)}^2 for {name}" for name, size, _ in sizes if size]
    held = [f"{name} moves by at most {at_least(b, 6)}" for name, _, b in sizes if b]
    still = [f"{name} is at rest" for name, size, b in sizes if not size and not b]
    beside = [f"{one} besides" for one in held]
    return ", ".join(
        [f"white noise, independent, of intensity {', '.join(noise)}", *beside, *still]
    )
