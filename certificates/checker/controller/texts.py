"""The texts and units of a gain file; they are the same for every law of one name."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

RAMP = [
    "psi(s) = 0 for s <= -overlap",
    "psi(s) = (s + overlap)^2 / (4 overlap) for |s| <= overlap",
    "psi(s) = s for s >= overlap",
]
EFFORT_SHARING_UNITS = {
    "wind": "m/s",
    "rotor_speed": "rad/s",
    "trim_effort": "rad/s^2",
    "effectiveness": "rad/s^2 per rad",
    "effectiveness_limit": "rad/s^2 per rad",
    "overlap": "rad/s^2",
    "proportional": "1/s",
    "integral_rate": "1/s",
    "rated_torque": "N m, high-speed shaft",
    "effort_torque": "N m s^2/rad",
    "pitch_min": "rad",
    "pitch_max": "rad",
    "wind_filter": "s",
    "integral_limit": "rad/s",
}
# Of ``law.setpoints``, in the file of a law that takes set-points at run time.
SETPOINT_UNITS = {
    "lowest_speed": "rad/s",
    "lowest_torque": "N m, high-speed shaft",
    "power_per_torque": "-, electrical power over torque times rotor speed",
    "speed_effort": "1/s",
}
PUBLISHED_UNITS = {
    "speed_setpoint": "rad/s",
    "minimum_rotor_speed": "rad/s",
    "optimal_tip_speed_ratio": "-",
    "largest_tip_speed_ratio": "-",
    "cut_in": "m/s",
    "cut_out": "m/s",
    "rated_torque": "N m, high-speed shaft",
    "pitch_min": "rad",
    "pitch_max": "rad",
    "coupling.speed_ramp_start": "rad/s",
    "coupling.speed_overlap": "rad/s",
    "coupling.torque_overlap": "N m, high-speed shaft",
    "coupling.minimum_torque": "N m, high-speed shaft",
    "coupling.top_torque": "N m, high-speed shaft",
    "partial.wind": "m/s",
    "partial.rotor_speed": "rad/s",
    "partial.pitch": "rad",
    "partial.premises": "a: 1/s, d: 1/s per m/s",
    "partial.k_speed": "N m per rad/s",
    "partial.k_pitch": "N m per rad",
    "partial.k_integral": "N m per rad",
    "full.wind": "m/s",
    "full.rotor_speed": "rad/s",
    "full.pitch": "rad",
    "full.premises": "a: 1/s, b: 1/s^2 per rad, d: 1/s per m/s",
    "full.k_speed": "rad per rad/s",
    "full.k_pitch": "rad per rad",
    "full.k_integral": "rad per rad",
}
TURBINE_UNITS = {
    "trim.wind": "m/s",
    "trim.rotor_speed": "rad/s",
    "trim.pitch": "rad",
    "trim.torque": "N m, high-speed shaft",
    "trim.region": "-",
    "limits.torque": "N m, high-speed shaft",
    "limits.torque_rate": "N m/s, high-speed shaft",
    "limits.pitch": "rad",
    "limits.pitch_rate": "rad/s",
    "limits.pitch_time_constant": "s",
    "observer.l1": "1/s",
    "observer.l2": "m/s^2 per rad/s",
    "observer.decay_rate": "1/s",
    "observer.wind_limits": "m/s",
    "rotor.torque_constant": "kg m, 1/2 rho pi R^3: T_r = torque_constant v^2 c_Q",
    "rotor.radius": "m",
    "rotor.rotor_inertia": "kg m^2",
    "rotor.generator_inertia": "kg m^2, high-speed shaft",
    "rotor.gear_ratio": "-",
    "rotor.inertia": "kg m^2, J = rotor_inertia + gear_ratio^2 generator_inertia",
    "rotor.torque_coefficient": "c_Q over tip-speed ratio [-] and pitch [rad]",
    "certificate.decay_rate": "1/s",
    "certificate.overspeed": "-",
    "certificate.wind_class.cells": "m/s",
    "certificate.wind_class.wind_error": "m/s",
    "certificate.wind_class.wind_rate": "m/s^2",
    "certificate.wind_class.decay_rate": "1/s",
}
# Of files whose law reads a filtered speed.
FILTERED_UNITS = {"measurement.speed_filter": "rad/s"}
FILTERED = (
    "before observer and law read it; the claim running-loop covers it, the others are about the "
    "law that reads the rotor speed itself"
)
LOW_PASS = "goes through a low-pass of one pole, corner measurement.speed_filter, "
STOPPED_UNITS = {
    "measurement.torsion_filter.frequency": "rad/s: w of the band-stop "
    "(s^2 + 2 p w s + w^2)/(s + w)^2",
    "measurement.torsion_filter.passed": "-, p: the share that passes at that frequency",
}
STOPPED = (
    "goes through a band-stop, measurement.torsion_filter, which keeps the drivetrain's torsion "
    "out, then a low-pass of one pole, corner measurement.speed_filter, "
)
OFTEN = {
    "every": "T = 0.01 to 0.02 s; what is sent holds until the next sample",
    "rates": "limits.torque_rate and limits.pitch_rate are the actuators'; what is sent may be "
    "held to them",
}
EQUATIONS = [
    "omegahat' = (T_r(omega, beta, vhat) - n_g T) / J + l1 (omega - omegahat)",
    "vhat' = l2 (omega - omegahat)",
]
EFFORT_SHARING = {
    "schedule": {
        "variables": "schedule wind v_s = low-passed wind estimate; execution has its steps",
        "interpolation": "linear between nodes; integral_rate constant between two nodes",
        "outside": "the wind is held at the first or last node",
    },
    "execution": OFTEN
    | {
        "schedule wind": "v_s after = v_hat + (v_s - v_hat) exp(-T / wind_filter), v_hat held "
        "within the table's winds",
        "integral": "x after = x - T integral_rate e, held within +-integral_limit",
    },
}
PUBLISHED = {
    "schedule": {
        "variables": "rotor speed, pitch, wind estimate",
        "interpolation": "memberships h_i of the regional rules; held at the nearer bound",
    },
    "execution": OFTEN | {"integrals": "x + T x', held nowhere"},
}
FORMULAS = {
    "command": "u = u* - sum over rules i of h_i K_i (x - x*)",
    "memberships": "h_i = product over premises of (upper - z)/(upper - lower) at corner 0, "
    "(z - lower)/(upper - lower) at corner 1; a premise with lower = upper has one corner",
    "rules": "law.rules has the corner of each premise, one row per rule, in the order of law.K; "
    "law.K with one matrix is one gain for all rules",
    "outside": "a premise outside its range is held at the nearer end; nothing is proved there",
    "saturation": "a command is held within the range of its input, where it has one; a proved "
    "set of kind input-limits lies where that does not happen",
    "sampling": "with sample_time T the command is computed at every T and held; without, the law "
    "is continuous, and what is proved is about continuous time",
}
BLEND = {
    "blend": "u = u* - ... is the rate of law.blending.effort, U; low: idle - direction psi(-U)/b, "
    "high: idle + direction psi(U)/b, with b the actuator's effectiveness, in SI",
    "ramp": "psi(s) = 0 for s <= -overlap, (s + overlap)^2/(4 overlap) up to overlap, s above",
    "share": "F = (psi(U) - psi(U*))/(U - U*), psi'(U*) where U = U*; a premise in it is measured; "
    "gains do not depend on a premise in an actuator's error, take 0 for the error",
}

OBSERVED = {
    "command": "u = u* - sum over rules i of h_i K_i s, where s estimates x - x*",
    "observer": "s' = A(z) s + B(z) (u - u*) + sum over rules i of h_i L_i (y - y* - C(z) s - "
    "D(z) (u - u*)), with u as it is sent; in discrete time s(t + T) in the place of s'",
    "weights": "of law.observer.weights 'measured': premises z of the measured states; of "
    "'estimated': premises of the estimate",
    "start": "a state that is measured by itself starts at its first measurement, others at rest",
    "sampling": "with sample_time T the program runs at every T; without, it takes one step of "
    "Euler's method with the sample time of the user, and what is proved is about continuous time",
}


def units_of(
    units: Mapping[str, str], *, of: str = "", without: Collection[str] = ()
) -> dict[str, str]:
    """Return the units of a law's members, or of a part ``of`` it, without words about them."""
    members = {name.removeprefix(of): unit for name, unit in units.items() if name.startswith(of)}
    return {
        name: unit.partition(",")[0]
        for name, unit in members.items()
        if "." not in name and name not in without
    }


def law_texts(law: Any, controller: Mapping[str, Any]) -> dict[str, Any]:
    """Return the members of the gain file that hold words and units of the law."""
    if law["name"] == "pdc":
        added_texts = OBSERVED if "observer" in law else BLEND if "blending" in law else {}
        return {"formulas": FORMULAS | added_texts}
    effort_sharing = law["name"] == "coherent"
    law_units = EFFORT_SHARING_UNITS if effort_sharing else PUBLISHED_UNITS
    units = {f"law.{name}": unit for name, unit in law_units.items()}
    if "setpoints" in law:
        units |= {f"law.setpoints.{name}": unit for name, unit in SETPOINT_UNITS.items()}
    units |= TURBINE_UNITS
    texts = EFFORT_SHARING if effort_sharing else PUBLISHED
    if "measurement" not in controller:
        return {"units": units, **texts}
    stopped = "torsion_filter" in controller["measurement"]
    measurement_text = {"measured speed": (STOPPED if stopped else LOW_PASS) + FILTERED}
    execution = {**texts["execution"], **measurement_text}
    added_texts = FILTERED_UNITS | (STOPPED_UNITS if stopped else {})
    return {"units": units | added_texts, **texts, "execution": execution}
