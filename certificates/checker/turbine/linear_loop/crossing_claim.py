r"""``turbine-crossing``: the linear loop rarely leaves its reference speed in turbulence.

    dx = A x dt + S dW,   x(0) = 0,   |e - omega*' y| reaches overspeed * rated speed within T,

A of ``jacobian``, computed from the file's turbine, law, observer and filters at the trim of one
mean wind, for constant parameters of a box.  For each piece of the box a matrix C > 0 with

    A C + C A' + S S' < 0     at the piece's corners,

and the bound of ``kinds.crossing_probability`` with s^2 = h C h', m^2 = max h A C A' h', b >= s.
h S = 0, as the noise enters r alone.

Theorem and proof: docs/turbine-crossing.md, docs/crossing-probability.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.spline_point import ExactSurface
from takagi.certificates.checker.kernel.matrices import Matrix, read_stack
from takagi.certificates.checker.kernel.reader import number, positive
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.kinds.crossing_probability import crossing_bound
from takagi.certificates.checker.loop.polytopic_loop import bounded
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.linear_loop.jacobian import (
    loop_matrix,
    noise_square,
    order,
    signal_row,
)
from takagi.certificates.checker.turbine.linear_loop.pieces import (
    Box,
    Turbulence,
    corners,
    cut_boxes,
    parameter_box,
)
from takagi.certificates.checker.turbine.linear_loop.trim import Trim, trim_at
from takagi.certificates.checker.turbine.running_loop.inputs import Machine
from takagi.certificates.checker.turbine.running_loop.rounded_definite import is_surely_definite
from takagi.certificates.checker.turbine.running_loop.stated import stated_loop


@dataclass(frozen=True)
class LinearLoop:
    """The loop of a claim at its wind; ``limit`` is b [rad/s]."""

    plant: Plant
    machine: Machine
    wind: Turbulence
    trim: Trim
    limit: Fraction

    @property
    def row(self) -> Matrix:
        return signal_row(self.trim, self.machine)

    def at(self, box: Box) -> list[Matrix]:
        """Return A at the corners of a box of the parameters."""
        return [
            loop_matrix(self.trim, self.plant, self.machine, self.wind, values)
            for values in corners(box)
        ]


def check_turbine_crossing(claim: Any, data: Any, where: str) -> Found:
    """Return the verdict on one claim.

    Parameters
    ----------
    data : the whole file.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be; also an observer or filters
        that are not those of the certificate's ``controller``.
    """
    plant, _, machine = loop = stated_loop(claim, data, where)
    mean, wind = positive(claim, "wind", where), Turbulence.read(claim, where)
    box = parameter_box(claim, where)
    parts = cut_boxes(claim, box, where)
    covariances, n = read_stack(claim, "C", where), order(machine)
    if covariances[0].shape != (n, n) or len(covariances) != len(parts):
        raise CertificateError(
            f"{where}.C: {len(parts)} matrices {n} by {n}, one for each piece, are needed"
        )
    # A part of the box has as many corners as the whole.
    bounded(len(parts) * sum(1 for _ in corners(box)), n)
    overspeed, horizon = (positive(claim, name, where) for name in ("overspeed", "horizon"))
    probability = number(claim, "probability", where)
    if not 0 < probability < 1:
        raise CertificateError(f"{where}.probability: a number between 0 and 1 is needed")
    said = {
        "mean": mean,
        "wind": wind,
        "box": box,
        "overspeed": overspeed,
        "limit": overspeed * plant.rated_speed,
        "horizon": horizon,
        "probability": probability,
        "pieces": len(parts),
    }
    try:
        trim = trim_at(*loop, ExactSurface.read(data["model"]), mean)
    except Refused as reason:
        return Found(Verdict.UNDECIDED, "turbine_crossing", said | {"why": str(reason)})
    linear = LinearLoop(plant, machine, wind, trim, overspeed * plant.rated_speed)
    for k, (part, C) in enumerate(zip(parts, covariances, strict=True), start=1):
        if why := piece_failure(linear, part, C, horizon, probability):
            place = f" on piece {k}" if len(parts) > 1 else ""
            return Found(Verdict.UNDECIDED, "turbine_crossing", said | {"why": why + place})
    return Found(Verdict.PROVED, "turbine_crossing", said | {"residual": abs(trim.residual)})


def piece_failure(
    linear: LinearLoop, part: Box, C: Matrix, horizon: Fraction, probability: Fraction
) -> str:
    """Return which condition fails on one piece; empty if all hold."""
    if not C.is_positive_definite:
        return "C is not symmetric positive definite"
    row, noise = linear.row, noise_square(linear.wind, linear.machine)
    variance, rate = _square(row, C), Fraction(0)
    if linear.limit**2 < variance:
        return "the limit is below the deviation"
    for A in linear.at(part):
        AC = A @ C
        # The entries of A are long: a rounded matrix decides, which is on the safe side.
        if not is_surely_definite((-(AC + AC.T) - noise).rows):
            return "the inequality of the covariance fails"
        rate = max(rate, _square(row @ A, C))
    bound = crossing_bound(
        ratio=linear.limit**2 / (2 * variance), rate=rate / variance, horizon=horizon
    )
    return "" if bound <= probability else "the bound of the probability is above the claim's"


def _square(row: Matrix, C: Matrix) -> Fraction:
    return (row @ C @ row.T)[0, 0]
