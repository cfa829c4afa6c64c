r"""The programs around a turbine's law: low-pass and wind observer before it, rate limits after it.

    a         <- measured + (a - measured) exp(-T w)       b <- a + (b - a) exp(-T w)
    stopped    = measured - 2 (1 - p) (a - b)              a band-stop at w that passes p there
    speed     <- stopped + (speed - stopped) exp(-T corner)
    omegahat' = (T_r(omega, beta, vhat) - n_g T) / J + l_1 (omega - omegahat)
    vhat'     = l_2 (omega - omegahat)

with one Euler step per sample of the observer, as in ``takagi simulate``.  Without a band-stop
stopped is the measured speed.
"""

from __future__ import annotations

from takagi.certificates.checker.controller.language import Item, keep, program, read, send, step


def speed_filter_program() -> Item:
    return program(
        "speed filter",
        {"corner": ("measurement.speed_filter", "rad/s")},
        reads=[read("measured_speed", "rad/s", "measured rotor speed")],
        keeps=[
            keep("before", "rad/s", "measured_speed", "speed", "filtered at the last sample"),
        ],
        steps=[],
        sends=[
            send("speed", "rad/s",
                 "measured_speed + (before - measured_speed)*exp(-sample_time*corner)",
                 "through the low-pass, to observer and law"),
        ],
    )  # fmt: skip


def torsion_filter_program() -> Item:
    pole = "{0} + ({1} - {0})*exp(-sample_time*frequency)"
    return program(
        "speed filter",
        {
            "frequency": ("measurement.torsion_filter.frequency", "rad/s"),
            "passed": ("measurement.torsion_filter.passed", "-"),
            "corner": ("measurement.speed_filter", "rad/s"),
        },
        reads=[read("measured_speed", "rad/s", "measured rotor speed")],
        keeps=[
            keep("first", "rad/s", "measured_speed", "first_after", "first pole of the band-stop"),
            keep("second", "rad/s", "measured_speed", "second_after", "its second pole"),
            keep("before", "rad/s", "measured_speed", "speed", "filtered at the last sample"),
        ],
        steps=[
            step("first_after", "rad/s", pole.format("measured_speed", "first")),
            step("second_after", "rad/s", pole.format("first_after", "second")),
            step("stopped", "rad/s",
                 "measured_speed - 2*(1 - passed)*(first_after - second_after)",
                 "without the torsion of the drivetrain"),
        ],
        sends=[
            send("speed", "rad/s", "stopped + (before - stopped)*exp(-sample_time*corner)",
                 "through band-stop and low-pass, to observer and law"),
        ],
    )  # fmt: skip


def observer_program() -> Item:
    rotor = {
        "torque_constant": "kg m",
        "radius": "m",
        "inertia": "kg m^2",
        "gear_ratio": "-",
        "torque_coefficient": "-",
    }
    gap = "speed - omega_hat"
    balance = "(torque_constant*v^2*c_q - gear_ratio*torque_sent)/inertia"
    return program(
        "observer",
        {name: (f"rotor.{name}", unit) for name, unit in rotor.items()}
        | {
            "l1": ("observer.l1", "1/s"),
            "l2": ("observer.l2", "m/s^2 per rad/s"),
            "v_low": ("observer.wind_limits.0", "m/s"),
            "v_high": ("observer.wind_limits.1", "m/s"),
        },
        reads=[
            read("speed", "rad/s", "measured rotor speed"),
            read("pitch", "rad", "measured pitch"),
            read("wind_guess", "m/s", "a first guess of the wind; it counts at the start alone"),
        ],
        keeps=[
            keep("omega_hat", "rad/s", "speed", f"omega_hat + sample_time*({balance} + l1*({gap}))",
                 "estimated rotor speed; torque_sent is that of this sample"),
            keep("v_hat", "m/s", "limit(wind_guess, v_low, v_high)", "v_hat + sample_time*v_rate",
                 "estimated wind"),
        ],
        steps=[
            step("v", "m/s", "limit(v_hat, v_low, v_high)"),
            step("c_q", "-", "spline(speed*radius/v, pitch, torque_coefficient)"),
            step("v_free", "m/s^2", f"l2*({gap})"),
            step("v_up", "m/s^2", "choose(v_low - v_hat, v_free, max(v_free, 0))",
                 "not below the lower limit"),
            step("v_rate", "m/s^2", "choose(v_hat - v_high, v_up, min(v_up, 0))",
                 "nor above the upper one"),
        ],
        sends=[send("wind_estimate", "m/s", "v", "to the law")],
    )  # fmt: skip


def rate_limit_program() -> Item:
    limited = {
        name: f"limit({command}, {previous} - sample_time*{rate}, {previous} + sample_time*{rate})"
        for name, command, previous, rate in (
            ("torque_sent", "torque", "torque_before", "torque_rate"),
            ("pitch_sent", "pitch_reference", "pitch_before", "pitch_rate"),
        )
    }
    return program(
        "rate limits",
        {
            "torque_rate": ("limits.torque_rate", "N m/s"),
            "pitch_rate": ("limits.pitch_rate", "rad/s"),
        },
        reads=[
            read("torque", "N m", "of the law"),
            read("pitch_reference", "rad", "of the law"),
        ],
        keeps=[
            keep("torque_before", "N m", "torque", "torque_sent", "what was sent last"),
            keep("pitch_before", "rad", "pitch_reference", "pitch_sent", "what was sent last"),
        ],
        steps=[],
        sends=[
            send("torque_sent", "N m", limited["torque_sent"], "as the generator can follow"),
            send("pitch_sent", "rad", limited["pitch_sent"], "as the pitch drive can follow"),
        ],
    )
