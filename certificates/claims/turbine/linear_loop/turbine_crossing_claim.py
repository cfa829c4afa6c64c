"""The candidate of a claim of kind ``turbine-crossing``: one mean wind, one overspeed.

The claim has what is asked for: an overspeed, or the least of ``OVERSPEEDS`` whose probability is
at most the one asked for.  Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.arithmetic.spline_point import ExactSurface
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.loop.polytopic_loop import MOST_WORK
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.linear_loop.crossing_claim import LinearLoop, piece_failure
from takagi.certificates.checker.turbine.linear_loop.pieces import (
    Box,
    Turbulence,
    parameter_box,
)
from takagi.certificates.checker.turbine.linear_loop.trim import trim_at
from takagi.certificates.checker.turbine.running_loop.inputs import Machine
from takagi.certificates.claims.turbine.linear_loop.crossing_search import Piece, Search, tree
from takagi.certificates.claims.turbine.running_loop.running_loop_claim import claim_head
from takagi.certificates.requests.loop.decimals import rounded_up, short
from takagi.certificates.requests.loop.exact_floats import as_read
from takagi.models.turbine import RotorWind

DIGITS = (6, 9, 12)
# Relative margin of the probability, and the least that is claimed: numbers go to 1e-48.
ABOVE, LEAST = 1e-6, 1e-40
OVERSPEEDS = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4)
# Mean winds of a design's claims [m/s]: between nodes of the NREL turbine's tables.
MEAN_WINDS = (5.2, 7.0, 9.0, 11.0, 13.0, 15.0, 17.0, 19.0, 21.0, 23.0)
# Factors of the torque's slopes; shares of what the wake adds at first.
UNCERTAINTY = {
    "speed_damping": [0.8, 1.2],
    "pitch_effectiveness": [0.9, 1.1],
    "wake_of_pitch": [0.8, 1.2],
    "wake_of_wind": [0.2, 0.3],
}


@dataclass(frozen=True, slots=True)
class CrossingAsked:
    """What a claim is to say.

    Attributes
    ----------
    wind : mean wind [m/s];  turbulence : the rotor-effective wind's.
    probability : that is asked for, within ``horizon`` [s].
    overspeed : as a share of rated speed; None takes the least of ``OVERSPEEDS``.
    pieces : the most pieces of the parameters, at most those that the checker takes (109 for 13
        states and five parameters);  depth : cuts before covariances are sought, where one for the
        whole box is not enough.
    least : claim the least probability that is found, instead of the one asked for.
    """

    wind: float
    turbulence: RotorWind
    probability: float = 1e-3
    overspeed: float | None = None
    horizon: float = 600.0
    pieces: int = 1
    depth: int = 0
    least: bool = True


def turbine_crossing_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    controller: Mapping[str, Any],
    inertia: Sequence[float],
    asked: CrossingAsked,
) -> dict[str, Any]:
    """Return the claim as plain data.

    Parameters
    ----------
    model, gains, controller, inertia : as ``running_loop_claim`` takes them.

    Raises
    ------
    Refused : the law has no filter of the measured speed or of the wind, the loop has no derivative
        at this wind, or no covariance shows the probability.
    """
    head = claim_head(model, gains, controller, inertia)
    del head["decay_rate"]
    head |= {
        "kind": "turbine-crossing",
        "wind": asked.wind,
        "turbulence": asked.turbulence.stated(),
        # One value of the wake's length, the rotor's radius.
        "uncertainty": {
            "inertia": list(inertia),
            **UNCERTAINTY,
            "wake_length": [float(model["rotor_radius"])] * 2,
        },
    }
    linear, box = linear_loop(model, gains, head)
    search = Search(linear, asked.horizon)
    rated = float(linear.plant.rated_speed)
    first = search.piece(box)
    most = min(asked.pieces, _taken(first))
    depth = min(asked.depth, most.bit_length() - 1)
    for overspeed in OVERSPEEDS if asked.overspeed is None else (asked.overspeed,):
        limit = overspeed * rated
        found = search.pieces(first, limit, asked.probability, most, depth)
        for claim in _stated(search, found, overspeed, limit, asked):
            if not _fails(linear, found, claim, overspeed):
                return {
                    "name": f"linear loop in turbulence at {asked.wind:g} m/s",
                    **head,
                    **claim,
                }
    bound = max(search.logarithm(one, limit) for one in found)
    shown = f"{float(np.exp(bound)):.2g}" if bound < 0 else "none below 1"
    raise Refused(
        f"no covariance shows {asked.probability:g} for an overspeed of {100 * overspeed:g} % at "
        f"{asked.wind:g} m/s; the bound found on {len(found)} pieces is {shown}"
        + ("; the checker takes no more" if len(found) == most < asked.pieces else "")
    )


def _taken(piece: Piece) -> int:
    """Return how many pieces the checker takes: all their corners are inequalities of the order."""
    corners_each, order = piece.A.shape[:2]
    return max(MOST_WORK // (int(corners_each) * int(order) ** 4), 1)


def linear_loop(
    model: Mapping[str, Any], gains: Mapping[str, Any], head: Mapping[str, Any]
) -> tuple[LinearLoop, Box]:
    """Return the loop as the checker computes it, with no limit yet, and the parameters' box."""
    data = as_read({"model": model, "gains": gains, "claim": head})
    claim = data["claim"]
    plant, law = Plant.read(data["model"]), Law.read(data["gains"])
    machine = Machine.read(claim, data["model"], data["gains"], "claim")
    surface, mean = ExactSurface.read(data["model"]), Fraction(claim["wind"])
    trim = trim_at(plant, law, machine, surface, mean)
    wind = Turbulence.read(claim, "claim")
    return LinearLoop(plant, machine, wind, trim, Fraction(0)), parameter_box(claim, "claim")


def _stated(
    search: Search, pieces: list[Piece], overspeed: float, limit: float, asked: CrossingAsked
) -> Iterator[dict[str, Any]]:
    """Yield what the claim says, with ever more digits; nothing where no bound is small enough."""
    covariances = [one.C for one in pieces if one.C is not None]
    if len(covariances) < len(pieces):
        return
    for digits in DIGITS:
        bound = search.shown(pieces, limit, digits)
        if bound * (1 + ABOVE) > asked.probability:
            continue
        least = rounded_up(max(bound * (1 + ABOVE), LEAST), 4)
        yield {
            "overspeed": overspeed,
            "horizon": asked.horizon,
            "probability": least if asked.least else asked.probability,
            **({"cuts": tree(pieces)} if len(pieces) > 1 else {}),
            "C": [short(C, digits).tolist() for C in covariances],
        }


def _fails(
    linear: LinearLoop, pieces: list[Piece], claim: Mapping[str, Any], overspeed: float
) -> str:
    """Return what the checker will find failing, or nothing."""
    read = as_read(claim)
    limit = Fraction(read["overspeed"]) * linear.plant.rated_speed
    exact = LinearLoop(linear.plant, linear.machine, linear.wind, linear.trim, limit)
    horizon, probability = Fraction(read["horizon"]), Fraction(read["probability"])
    for one, C in zip(pieces, read["C"], strict=True):
        stated = Matrix.of([[Fraction(entry) for entry in row] for row in C])
        if why := piece_failure(exact, one.box, stated, horizon, probability):
            return why
    return ""
