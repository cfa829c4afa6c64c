"""The sentence of a claim of kind ``turbine-crossing``, proved or not."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from takagi.certificates.checker.turbine.linear_loop.pieces import Turbulence
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly
from takagi.certificates.checker.words.sentences.running_loop import range_words

# Parameters in words, in the order of the sentence; {} is a range.
WORDS = {
    "inertia": "inertia {} of nominal",
    "speed_damping": "the torque's slope in speed {} of the table's",
    "pitch_effectiveness": "that in pitch {} of the table's",
    "wake_of_pitch": "the wake's excess in pitch {} of what reaches the law's effectiveness_limit",
    "wake_of_wind": "its excess in wind {} of the torque's slope in wind",
    "wake_length": "a wake that follows over {} m of wind",
}


def said(
    mean: Fraction,
    wind: Turbulence,
    box: Mapping[str, Span],
    overspeed: Fraction,
    limit: Fraction,
    horizon: Fraction,
    probability: Fraction,
    pieces: int,
    why: str = "",
    residual: Fraction | None = None,
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    mean : the mean wind [m/s];  box : the ranges of the parameters.
    limit : the overspeed times rated speed [rad/s].
    why : what is not proved.
    residual : of the torques at the trim [rad/s^2], where the claim is proved.
    """
    name = f"linear loop in turbulence at {exactly(mean)} m/s"
    if residual is None:
        return name, f"not proved: {why}"
    many = f", in {pieces} pieces" if pieces > 1 else ""
    family = ", ".join(
        words.format(exactly(box[key][0]) if len(set(box[key])) == 1 else range_words(*box[key]))
        for key, words in WORDS.items()
    )
    return name, (
        f"the loop linearised at its trim at a mean wind of {exactly(mean)} m/s: from rest, the "
        "probability that within "
        f"{at_least(horizon, 6)} s the rotor's speed departs from its reference at the present "
        f"wind by {at_most(100 * overspeed, 6)} % of rated speed ({at_most(limit, 4)} rad/s) is at "
        f"most {at_most(probability, 6)}. The wind is its mean plus a Gaussian process with a "
        f"deviation of {exactly(wind.deviation)} m/s and an rms rate of {exactly(wind.rate)} "
        f"m/s^2, averaged by the rotor over {exactly(wind.rotor_time)} s. For all constant values "
        f"of the parameters{many}: {family}. The reference is a line in the wind here, without its "
        "stop at rated speed. The matrices are computed here from turbine, law, "
        f"observer and filters. Nothing is said of the nonlinear loop, its limits, or another mean "
        f"wind; the torques at the trim, which differ by {at_most(residual, 2)} rad/s^2, are taken "
        "as equal"
    )
