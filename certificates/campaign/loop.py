"""The certified loop as numbers: plant, law and claim, read from a certificate's own document.

No object of the design or its proof is used, so the simulated loop is exactly the one in the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from takagi.certificates.campaign.spline_patches import Patches, spline_patches
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

KIND = "coherent-loop"
PEAKS = ("speed_error", "effort_lag", "speed_signal", "integral")
# The order of the rows of ``CertifiedLoop.tables``.
TABLES = ("rotor_speed", "trim_effort", "effectiveness", "proportional", "effectiveness_limit")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CertifiedLoop:
    """The loop of a certificate of kind ``coherent-loop``; symbols of docs/effort-sharing-loop.md.

    Attributes
    ----------
    torque_scale : c / J, where T_r = c v^2 c_Q [rad/m^2 ...];  gear_scale : n_g / J.
    rotor_radius [m], pitch_lag : tau [s], pitch_rate_limit [rad/s], rated_speed [rad/s].
    pitch_min, pitch_max [rad].
    surface : c_Q(lambda, beta).
    wind : (K,) nodes of the schedule [m/s].
    tables : (5, K) omega*, q*, b, gamma, b_fw at the nodes, linear between them;
        slopes : (5, K - 1) over wind.
    integral_rate, inertia_feedforward, feedforward_limit : (K - 1,) nu, f, g.
    overlap, pitch_lead, rated_torque, effort_torque, integral_limit : eps, tau_l, T_rated, E.
    P, R : (3, 3) of the set and of the common decay, in (e, zeta, x);  common_rate : d [1/s].
    peaks : (4,) of e, zeta, e - x, x.
    wind_error, wind_rate, decay_rate : (K - 1,) delta [m/s], rho [m/s^2], d_k [1/s].
    inertia, power : least and greatest true over nominal inertia and over table's c_P [-].
    frozen_wake : whether Delta acts.
    """

    name: str
    torque_scale: float
    gear_scale: float
    rotor_radius: float
    pitch_lag: float
    pitch_rate_limit: float
    rated_speed: float
    pitch_min: float
    pitch_max: float
    surface: Patches
    wind: Floats
    tables: Floats
    slopes: Floats
    integral_rate: Floats
    inertia_feedforward: Floats
    feedforward_limit: Floats
    overlap: float
    pitch_lead: float
    rated_torque: float
    effort_torque: float
    integral_limit: float
    P: Floats
    R: Floats
    common_rate: float
    peaks: Floats
    wind_error: Floats
    wind_rate: Floats
    decay_rate: Floats
    inertia: tuple[float, float]
    power: tuple[float, float]
    frozen_wake: bool


def certified_loop(document: Mapping[str, Any]) -> CertifiedLoop:
    """Return the loop of a certificate; ``document`` is the file's JSON.

    Raises
    ------
    ModelError : no claim of kind ``coherent-loop``, or a part that is missing or does not fit.
    """
    model, law = _part(document, "model"), _part(document, "gains")
    claims = document.get("claims")
    found = [c for c in claims if isinstance(c, dict)] if isinstance(claims, list) else []
    claim = next((c for c in found if c.get("kind") == KIND), None)
    if claim is None:
        kinds = ", ".join(sorted({str(c.get("kind")) for c in found})) or "none"
        raise ModelError(
            f"the certificate has claims of kind {kinds}; a campaign needs one of kind {KIND}, "
            "which `takagi design TURBINE` makes with the effort-sharing law"
        )
    try:
        return _read(model, law, claim)
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError(
            f"the certificate cannot be simulated ({type(error).__name__}: {error}); "
            "`takagi check` says what is wrong with it"
        ) from error


def _part(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    part = document.get(name)
    if not isinstance(part, dict):
        raise ModelError(f"the certificate has no {name}; give the file that `takagi design` wrote")
    return part


def _read(model: dict[str, Any], law: dict[str, Any], claim: dict[str, Any]) -> CertifiedLoop:
    wind = np.array(law["wind"], dtype=np.float64)
    if len(claim["cells"]) != len(wind) - 1:
        raise ModelError(
            f"{len(claim['cells'])} cells were found for {len(wind)} winds; one per interval"
        )
    return CertifiedLoop(**_plant(model), wind=wind, **_law(law, wind), **_claimed(claim))


def _plant(model: dict[str, Any]) -> dict[str, Any]:
    gear = float(model["gear_ratio"])
    J = float(model["rotor_inertia"]) + gear**2 * float(model["generator_inertia"])
    table = model["torque_surface"]
    return {
        "name": str(model["name"]),
        "torque_scale": float(model["torque_constant"]) / J,
        "gear_scale": gear / J,
        "rotor_radius": float(model["rotor_radius"]),
        "pitch_lag": float(model["pitch_time_constant"]),
        "pitch_rate_limit": float(model["pitch_rate_limit"]),
        "rated_speed": float(model["rated_rotor_speed"]),
        "pitch_min": float(model["pitch_min"]),
        "pitch_max": float(model["pitch_max"]),
        "surface": spline_patches(
            table["tip_speed_ratio_knots"], table["pitch_knots"], table["coefficients"]
        ),
    }


def _law(law: dict[str, Any], wind: Floats) -> dict[str, Any]:
    tables = np.array([law[name] for name in TABLES], dtype=np.float64).reshape(5, len(wind))
    per_interval = ("integral_rate", "inertia_feedforward", "feedforward_limit")
    single = ("overlap", "pitch_lead", "rated_torque", "effort_torque", "integral_limit")
    return {
        "tables": tables,
        "slopes": np.diff(tables, axis=1) / np.diff(wind),
        **{name: _intervals(law, name, wind) for name in per_interval},
        **{name: float(law[name]) for name in single},
    }


def _claimed(claim: dict[str, Any]) -> dict[str, Any]:
    uncertainty = claim["uncertainty"]
    low, high = uncertainty["inertia"]
    # A file without this member means the power coefficient of the table.
    least, most = uncertainty.get("power_coefficient", (1.0, 1.0))
    return {
        "P": np.array(claim["P"], dtype=np.float64).reshape(3, 3),
        "R": np.array(claim["settling"]["P"], dtype=np.float64).reshape(3, 3),
        "common_rate": float(claim["settling"]["decay_rate"]),
        "peaks": np.array([float(claim["peaks"][name]) for name in PEAKS]),
        **{
            name: np.array([cell[name] for cell in claim["cells"]], dtype=np.float64)
            for name in ("wind_error", "wind_rate", "decay_rate")
        },
        "inertia": (float(low), float(high)),
        "power": (float(least), float(most)),
        "frozen_wake": bool(uncertainty["frozen_wake"]),
    }


def _intervals(law: dict[str, Any], name: str, wind: Floats) -> Floats:
    return np.array(law[name], dtype=np.float64).reshape(len(wind) - 1)
