r"""One sample of the effort-sharing law as a program.

e = omega - omega*(v_s)          s = e - x
U = q*(v_s) + gamma(v_s) s       the demanded effort
torque = T_rated - (J/n_g) psi(-U)
pitch  = beta_min + psi(U) / b(v_s)
x after   = x - T nu e           v_s after = v_hat + (v_s - v_hat) exp(-T / tau_f)

A law with set-points reads those of rotor speed and power.  Torque falls first, to the lowest; then
the speed set-point falls.  The reference speed is lower by r, and T_s stands for T_rated.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.controller.language import Item, keep, program, read, send, step
from takagi.certificates.checker.controller.texts import (
    EFFORT_SHARING_UNITS,
    SETPOINT_UNITS,
    units_of,
)

EFFORT = "rad/s^2"
WIND = "limit(wind_estimate, first(wind), last(wind))"
UNITS = units_of(EFFORT_SHARING_UNITS, without=("effectiveness_limit",))


def effort_sharing_program(law: Any) -> Item:
    """Return the law's program, with or without a filter on the wind estimate."""
    filtered = float(law["wind_filter"]) > 0
    setpoints = "setpoints" in law
    parameter_names = [name for name in UNITS if filtered or name != "wind_filter"]
    parameters = {name: (f"law.{name}", UNITS[name]) for name in parameter_names}
    if setpoints:
        parameters |= {n: (f"law.setpoints.{n}", u) for n, u in SETPOINT_UNITS.items()}
    return program(
        "law",
        parameters,
        reads=[
            read("speed", "rad/s", "measured rotor speed"),
            read("wind_estimate", "m/s", "of the observer, or measured"),
            *(_setpoints_read() if setpoints else []),
        ],
        keeps=[
            keep("x", "rad/s", "0", "x_after", "integral of the speed error"),
            *(
                [keep("v_s", "m/s", WIND, "v_after", "schedule wind, the filtered estimate")]
                if filtered
                else []
            ),
        ],
        steps=[
            *(_filter() if filtered else _passing()),
            *(_operation() if setpoints else []),
            *_effort(setpoints),
            *_actuators("torque_setpoint" if setpoints else "rated_torque"),
            _integral(),
        ],
        sends=[
            send("torque", "N m", "torque_held", "to the generator, high-speed shaft"),
            send("pitch_reference", "rad", "pitch_held", "to the pitch drive"),
        ],
    )


def _filter() -> list[Item]:
    return [
        _seen(),
        step("v_after", "m/s", "v_seen + (v_s - v_seen)*exp(-sample_time/wind_filter)"),
    ]


def _passing() -> list[Item]:
    return [
        _seen(),
        step("v_s", "m/s", "v_seen", "there is no filter, so the estimate is the schedule wind"),
    ]


def _seen() -> Item:
    return step("v_seen", "m/s", WIND, "the estimate, held within the table's winds")


def _setpoints_read() -> list[Item]:
    return [
        read("speed_setpoint", "rad/s", "largest rotor speed; the rated one for none"),
        read("power_setpoint", "W", "largest electrical power; the rated one for none"),
    ]


def _operation() -> list[Item]:
    slowed = "min(speed_setpoint, power_setpoint/(power_per_torque*lowest_torque))"
    return [
        step("speed_most", "rad/s", f"limit({slowed}, lowest_speed, last(rotor_speed))",
             "speed falls where the lowest torque still gives too much power"),
        step("torque_setpoint", "N m",
             "limit(power_setpoint/(power_per_torque*speed_most), lowest_torque, rated_torque)"),
        step("reduction", "rad/s", "min(speed_most - line(v_s, wind, rotor_speed), 0)",
             "r, of the reference speed"),
        step("lowered", EFFORT,
             "line(v_s, wind, speed_effort)*reduction "
             "+ (rated_torque - torque_setpoint)/effort_torque", "effort that set-points add"),
    ]  # fmt: skip


def _effort(setpoints: bool) -> list[Item]:
    reduction, lowered = (" - reduction", " + lowered") if setpoints else ("", "")
    return [
        step("e", "rad/s", f"speed - line(v_s, wind, rotor_speed){reduction}", "speed error"),
        step("s", "rad/s", "e - x"),
        step("gamma", "1/s", "line(v_s, wind, proportional)"),
        step("U", EFFORT, f"line(v_s, wind, trim_effort){lowered} + gamma*s", "demanded effort"),
        step("near_U", EFFORT, "limit(U, -overlap, overlap)"),
        step(
            "shed", EFFORT, "max(U, (near_U + overlap)^2/(4*overlap))", "psi(U), what pitch sheds"
        ),
        step(
            "reserve",
            EFFORT,
            "max(-U, (overlap - near_U)^2/(4*overlap))",
            "psi(-U), torque kept back",
        ),
    ]


def _actuators(torque: str) -> list[Item]:
    return [
        step("torque_wanted", "N m", f"{torque} - effort_torque*reserve"),
        step("torque_held", "N m", f"limit(torque_wanted, 0, {torque})"),
        step("b", "rad/s^2 per rad", "line(v_s, wind, effectiveness)"),
        step("pitch_wanted", "rad", "pitch_min + shed/b"),
        step("pitch_held", "rad", "limit(pitch_wanted, pitch_min, pitch_max)"),
    ]


def _integral() -> Item:
    return step(
        "x_after",
        "rad/s",
        "limit(x - sample_time*hold(v_s, wind, integral_rate)*e, -integral_limit, integral_limit)",
        "the limit is the anti-windup",
    )
