"""The loop of a published law around the line where it rests, cell by cell, for the search.

The checker encloses the loop (``checker.turbine.published.loop``); here its ranges become floats,
in units of the box: A_ij r_j / r_i and d_i / r_i, both in 1/s, as a claim states them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.published import inputs
from takagi.certificates.checker.turbine.published.loop import Ends, Loop
from takagi.certificates.checker.turbine.published.loop_claim import disturbance_sizes
from takagi.certificates.document.certificate_file import published_law_data, turbine_data
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import exact
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Turbine

EMITTED_DIGITS = 7
# Emitted ranges are wider than the enclosed ones by this share of the largest entry of their row,
# which is far more than what the floats here are rounded by.
WIDENED = 1e-8


@dataclass(frozen=True, slots=True, eq=False)
class ExactLoop:
    """Plant, law and overlaps as the checker reads them from the law's certificate."""

    plant: Plant
    law: inputs.PublishedLaw

    @classmethod
    def of(cls, law: PublishedLaw) -> ExactLoop:
        """Return the loop of a law.

        Raises
        ------
        ModelError : a filter or gains that no claim covers.
        """
        torque, limit = law.coupling.rated_torque, law.turbine.rated_torque
        if torque != limit:
            raise ModelError(
                f"the filter holds torque at {torque:.6g} N m, the turbine's limit is "
                f"{limit:.6g} N m; a claim needs them equal"
            )
        written = json.dumps(published_law_data(law))
        try:
            return cls(_plant(law.turbine), inputs.PublishedLaw.read(read_text(written, "gains")))
        except CertificateError as error:
            raise ModelError(f"no claim covers this law: {error}") from error

    def over(
        self, wind: tuple[float, float], centre: Floats, box: Floats | None, seeds: str
    ) -> Loop:
        """Return the loop over a cell; ``seeds`` as of ``Loop``."""
        return Loop(self.plant, self.law, self.law.overlaps, _ends(wind, centre, box), seeds)


@lru_cache(maxsize=4)
def _plant(turbine: Turbine) -> Plant:
    return Plant.read(read_text(json.dumps(turbine_data(turbine, ())), "model"))


def _ends(wind: tuple[float, float], centre: Floats, box: Floats | None) -> Ends:
    first, last = ([exact(value) for value in row] for row in centre.tolist())
    widths = [exact(r) for r in (np.zeros(len(first)) if box is None else box).tolist()]
    return Ends((exact(wind[0]), exact(wind[1])), (first, last), widths)


@dataclass(frozen=True, slots=True, eq=False)
class PublishedCell:
    """Ranges of the loop over one cell, in units of the box.

    Attributes
    ----------
    wind : (v_1, v_2) [m/s].
    centre : (2, n) z_0 at both winds;  box : (n,) r.  Units rad/s, rad, rad.
    low, high : (corners, n, n) [1/s].
    disturbance : (n,) bound on |d_i| / r_i [1/s].
    """

    wind: tuple[float, float]
    centre: Floats
    box: Floats
    low: Floats
    high: Floats
    disturbance: Floats


def enclosed_cell(
    loop: ExactLoop,
    wind: tuple[float, float],
    centre: Floats,
    box: Floats,
    disturbance: Floats | None = None,
) -> PublishedCell:
    """Return the ranges over one cell; ``disturbance`` is that of ``disturbance_bound``, if known.

    Raises
    ------
    ModelError : the box leaves the coefficient table or may demand more than the pitch rate
        limit, or an integral gain may vanish in it.
    """
    bound = disturbance_bound(loop, wind, centre) if disturbance is None else disturbance
    try:
        enclosed = loop.over(wind, centre, box, "states")
        slopes = [
            [[(slope.low / ONE, slope.high / ONE) for slope in rate.slopes] for rate in rates]
            for rates in (enclosed.rates(*choice) for choice in enclosed.choices())
        ]
    except Refused as error:
        raise _refused(wind, error) from error
    low, high = np.moveaxis(np.array(slopes) / box[:, None, None], -1, 0)
    size = np.maximum(np.abs(low), np.abs(high)).max(axis=(0, 2), keepdims=True) * WIDENED
    return PublishedCell(
        wind,
        centre,
        box,
        _emitted(np.floor, low - size * (low != 0)),
        _emitted(np.ceil, high + size * (high != 0)),
        _emitted(np.ceil, bound / box * (1 + WIDENED) + 1e-6),
    )


def disturbance_bound(loop: ExactLoop, wind: tuple[float, float], centre: Floats) -> Floats:
    """Return (n,) bounds of |f_i(z_0(v), v)| over the cell, in SI units.

    Raises
    ------
    ModelError : see ``enclosed_cell``.
    """
    law, ends = loop.law, _ends(wind, centre, None)
    try:
        sizes = disturbance_sizes(loop.plant, law, law.overlaps, ends)
    except Refused as error:
        raise _refused(wind, error) from error
    return np.array([size / ONE for size in sizes])


def wind_breaks(loop: ExactLoop, low: float, high: float) -> list[float]:
    """Return the winds between which tables and reference speed are smooth, ends included.

    Where the reference speed bends is not a decimal: two breaks enclose such a wind.
    """
    law = loop.law
    nodes = {float(v) for region in (law.partial, law.full) for v in region.wind}
    for speed, ratio in (
        (law.minimum_speed, law.optimal_ratio),
        (law.setpoint, law.optimal_ratio),
        (law.minimum_speed, law.largest_ratio),
    ):
        bend = float(speed * loop.plant.radius / ratio)
        nodes |= {math.floor(bend * 1e6) / 1e6, math.ceil(bend * 1e6) / 1e6}
    return sorted({low, high, *(v for v in nodes if low < v < high)})


def _refused(wind: Sequence[float], error: Refused) -> ModelError:
    return ModelError(f"wind {wind[0]:.6g} to {wind[1]:.6g} m/s: {error}; take a smaller box")


def _emitted(rounded: np.ufunc, values: Floats) -> Floats:
    scale = 10.0**EMITTED_DIGITS
    return np.asarray(rounded(values * scale) / scale, dtype=np.float64)
