"""The certified loop as numbers: plant, law and claim, read from a certificate's own document.

No object of the design or its proof is used, so the simulated loop is exactly the one in the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.splines.scalar_surface import patch_coefficients
from takagi.models.splines.spline import Surface

KIND = "coherent-loop"
PEAKS = ("speed_error", "effort_lag", "speed_signal", "integral")
# Rows h of the peaks |h xi|, xi = (e, zeta, x): e, zeta, e - x, x.
DIRECTIONS = np.array([[1.0, 0, 0], [0, 1.0, 0], [1.0, 0, -1.0], [0, 0, 1.0]])
# The order of the rows of ``CertifiedLoop.tables``.
TABLES = ("rotor_speed", "trim_effort", "effectiveness", "proportional", "effectiveness_limit")
PITCHES = 40


class Equations(NamedTuple):
    """What moves the loop; symbols of docs/effort-sharing-loop.md, in SI units."""

    torque_scale: float  # c / J, where T_r = c v^2 c_Q
    gear_scale: float  # n_g / J
    rotor_radius: float
    pitch_lag: float
    pitch_rate_limit: float
    pitch_min: float
    pitch_max: float
    overlap: float
    rated_torque: float
    effort_torque: float  # E
    integral_limit: float
    # c_Q(lambda, beta) as in ``patch_coefficients``.
    ratio: Floats
    pitch: Floats
    patches: Floats
    # A row for each wind cell: its ends; omega*, q*, b, gamma and b_fw at its lower end; their
    # slopes over wind; nu.  One array, since numba counts references to each.
    cells: Floats


class CertifiedLoop(NamedTuple):
    """The loop of a certificate of kind ``coherent-loop``, and what is claimed of it."""

    equations: Equations
    rated_speed: float
    top_speed: float  # the greatest omega*
    wind: Floats  # nodes of the schedule
    P: Floats  # of the set, in (e, zeta, x)
    R: Floats  # of the common decay
    common_rate: float
    root: Floats  # its columns span the set
    corners: Floats  # points of the set where a peak is attained
    peaks: Floats  # of e, zeta, e - x, x
    # In each cell: delta, rho, d_k.
    wind_error: Floats
    wind_rate: Floats
    decay_rate: Floats
    # Least and greatest true over nominal inertia, and over table's c_P.
    inertia: Floats
    power: Floats
    wake: Floats  # in each cell: largest share of the way to the frozen wake


def certified_loop(document: Mapping[str, Any]) -> CertifiedLoop:
    """Return the loop of a certificate; ``document`` is the file's JSON.

    Raises
    ------
    ModelError : no claim of kind ``coherent-loop``, or a part that is missing or does not fit.
    """
    listed = [claim for claim in document.get("claims", ()) if isinstance(claim, dict)]
    claim = next((claim for claim in listed if claim.get("kind") == KIND), None)
    if claim is None:
        kinds = ", ".join(sorted({str(claim.get("kind")) for claim in listed})) or "none"
        raise ModelError(
            f"the certificate has claims of kind {kinds}; a campaign needs one of kind {KIND}, "
            "which `takagi design TURBINE` makes with the effort-sharing law"
        )
    try:
        return _read(document["model"], document["gains"], claim)
    except (KeyError, TypeError, ValueError, np.linalg.LinAlgError) as error:
        raise ModelError(
            f"the certificate cannot be simulated ({type(error).__name__}: {error}); "
            "`takagi check` says what is wrong with it"
        ) from error


def _read(model: dict[str, Any], law: dict[str, Any], claim: dict[str, Any]) -> CertifiedLoop:
    table = model["torque_surface"]
    surface = Surface(table["tip_speed_ratio_knots"], table["pitch_knots"], table["coefficients"])
    wind = _row(law["wind"])
    tables = np.array([law[name] for name in TABLES], dtype=np.float64).reshape(5, len(wind))
    cells, uncertainty = claim["cells"], claim["uncertainty"]
    P = _row(claim["P"]).reshape(3, 3)
    inverse = np.linalg.inv(P)
    ratio, pitch, patches = patch_coefficients(surface)
    gear = float(model["gear_ratio"])
    J = float(model["rotor_inertia"]) + gear**2 * float(model["generator_inertia"])
    of_model = ("rotor_radius", "pitch_rate_limit", "pitch_min", "pitch_max")
    of_law = ("overlap", "rated_torque", "effort_torque", "integral_limit")
    rows = [wind[:-1], wind[1:], *tables[:, :-1], *(np.diff(tables, axis=1) / np.diff(wind))]
    equations = Equations(
        torque_scale=float(model["torque_constant"]) / J,
        gear_scale=gear / J,
        pitch_lag=float(model["pitch_time_constant"]),
        **{name: float(model[name]) for name in of_model},
        **{name: float(law[name]) for name in of_law},
        ratio=np.array(ratio),
        pitch=np.array(pitch),
        patches=patches,
        cells=np.ascontiguousarray(np.vstack([*rows, _row(law["integral_rate"])]).T),
    )
    of_cell = ("wind_error", "wind_rate", "decay_rate")
    loop = CertifiedLoop(
        equations=equations,
        rated_speed=float(model["rated_rotor_speed"]),
        top_speed=float(tables[0].max()),
        wind=wind,
        P=P,
        R=_row(claim["settling"]["P"]).reshape(3, 3),
        common_rate=float(claim["settling"]["decay_rate"]),
        root=np.ascontiguousarray(np.linalg.inv(np.linalg.cholesky(P)).T),
        corners=np.array([inverse @ h / np.sqrt(h @ inverse @ h) for h in DIRECTIONS]),
        peaks=_row([claim["peaks"][name] for name in PEAKS]),
        **{name: _row([c[name] for c in cells]).reshape(len(wind) - 1) for name in of_cell},
        inertia=_row(uncertainty["inertia"]).reshape(2),
        # A file without this member means the power coefficient of the table.
        power=_row(uncertainty.get("power_coefficient", (1.0, 1.0))).reshape(2),
        wake=np.zeros(len(cells)),
    )
    return loop._replace(wake=_wake(loop, surface)) if uncertainty["frozen_wake"] else loop


def _wake(loop: CertifiedLoop, surface: Surface) -> Floats:
    """Return 1 in the cells where every wake up to the frozen one belongs to the family, else 0.

    There b_fw + s_P d(T_r/J)/dbeta is not negative over the pitch that the set can reach.
    """
    p = loop.equations
    low, high, tables, slopes = p.cells[:, 0], p.cells[:, 1], p.cells[:, 2:7].T, p.cells[:, 7:12].T
    fits = np.ones(len(low), dtype=bool)
    for middle in (0.0, 0.5, 1.0):
        wind = low + middle * (high - low)
        speed, effort, b, gain, limit = tables + (wind - low) * slopes
        reach = gain * loop.peaks[2]
        high_effort = _ramp(effort + reach, p.overlap) + loop.peaks[1]
        low_effort = np.maximum(_ramp(effort - reach, p.overlap) - loop.peaks[1], 0.0)
        pitch = p.pitch_min + np.linspace(low_effort, high_effort, PITCHES) / b
        slope = surface(p.rotor_radius * speed / wind, pitch, dy=1, clip=True)
        fits &= np.all(limit + loop.power[1] * p.torque_scale * wind**2 * slope >= 0, axis=0)
    return fits.astype(np.float64)


def _ramp(effort: Floats, overlap: float) -> Floats:
    bent = np.clip(effort + overlap, 0.0, 2 * overlap)
    return np.asarray(bent * bent / (4 * overlap) + np.maximum(effort - overlap, 0.0))


def _row(values: Any) -> Floats:
    return np.array(values, dtype=np.float64)
