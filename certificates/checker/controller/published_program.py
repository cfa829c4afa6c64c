r"""One sample of a published law as a program; premises are secants of the rotor's torque.

    u_1 = -k^b_w e - k^b_p beta + k^b_I x        torque, gains of partial load
    u_2 = -k^c_w e - k^c_p beta + k^c_I x        pitch, gains of full load
    torque = f_2(u_1) u_1,  pitch = f_1(omega) u_2,  both held within their limits

A secant over less than a small step is computed over that step about the same midpoint.  Without an
overlap f_1 is a switch, and torque is limited alone.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.controller.language import Item, keep, program, read, send, step
from takagi.certificates.checker.controller.texts import PUBLISHED_UNITS, units_of
from takagi.certificates.checker.kernel.refusal import CertificateError

UNITS = {"a": "1/s", "b": "1/s^2 per rad", "d": "1/s per m/s"}
# Steps [rad/s, rad, m/s] below which a secant is taken over the step itself.
STEPS = {"a": "0.0001", "b": "0.0001", "d": "0.001"}
SHAPES = {"smooth": "s_1^2*(3 - 2*s_1)", "linear": "s_1"}
FIGURES = units_of(PUBLISHED_UNITS)
COUPLING = units_of(PUBLISHED_UNITS, of="coupling.", without=("minimum_torque",))
ROTOR = {
    "torque_constant": "kg m",
    "inertia": "kg m^2",
    "radius": "m",
    "torque_coefficient": "-",
}


def published_program(law: Any) -> Item:
    """Return the program of law ``paper``.

    Raises
    ------
    CertificateError : a coupling filter or ramp that has no program.
    """
    coupling = law["coupling"]
    shape = SHAPES.get(str(coupling["speed_ramp_shape"]))
    if coupling["variant"] != "saturated" or shape is None:
        raise CertificateError("gains.coupling: no program is written for this filter")
    names = {name: (f"law.{name}", unit) for name, unit in FIGURES.items()}
    names |= {name: (f"law.coupling.{name}", unit) for name, unit in COUPLING.items()}
    names |= {name: (f"rotor.{name}", unit) for name, unit in ROTOR.items()}
    names["start_x"] = ("start.integrals.0", "rad")
    names["start_wind"] = ("start.wind", "m/s")
    for region in ("partial", "full"):
        names |= _region_names(law, region)
    return program(
        "law",
        names,
        reads=[
            read("speed", "rad/s", "measured rotor speed"),
            read("pitch", "rad", "measured pitch"),
            read("wind_estimate", "m/s", "of the observer, or measured"),
        ],
        keeps=[
            keep(
                "x",
                "rad",
                "line(wind_estimate, start_wind, start_x)",
                "x - sample_time*e",
                "integral of the speed deficit",
            )
        ],
        steps=[
            *_reference(),
            *_region(law, "partial"),
            *_region(law, "full"),
            step("u_1", "N m", _command("partial"), "torque that partial load asks for"),
            step("u_2", "rad", _command("full"), "pitch that full load asks for"),
            *_blended(coupling, shape),
        ],
        sends=[
            send("torque", "N m", "torque_held", "to the generator, high-speed shaft"),
            send("pitch_reference", "rad", "pitch_held", "to the pitch drive"),
        ],
    )


def _region_names(law: Any, region: str) -> dict[str, tuple[str, str]]:
    stated = law[region]
    path = f"law.{region}"
    over = {"speed": "rad/s", "pitch": "rad", "integral": "rad"}
    out = "N m" if region == "partial" else "rad"
    names = {f"{region}_wind": (f"{path}.wind", "m/s")}
    names |= {f"{region}_{name}": (f"{path}.{name}", over[name.removeprefix("rotor_")])
              for name in ("rotor_speed", "pitch")}  # fmt: skip
    names[f"{region}_rules"] = (f"{path}.rules", "-")
    for name, unit in over.items():
        names[f"{region}_k_{name}"] = (f"{path}.k_{name}", f"{out} per {unit}")
    for p in sorted(stated["premises"]):
        for end, k in (("lower", 0), ("upper", 1)):
            names[f"{region}_{p}_{end}"] = (f"{path}.premises.{p}.{k}", UNITS[p])
    return names


def _reference() -> list[Item]:
    return [
        step("v_ref", "m/s", "limit(wind_estimate, cut_in, cut_out)"),
        step("slowest", "rad/s",
             "min(minimum_rotor_speed, largest_tip_speed_ratio*v_ref/radius)"),
        step("reference", "rad/s",
             "min(max(optimal_tip_speed_ratio*v_ref/radius, slowest), speed_setpoint)"),
        step("e", "rad/s", "speed - reference", "speed error"),
        step("scale", "1/s^2 per (m/s)^2", "torque_constant/inertia"),
    ]  # fmt: skip


def _region(law: Any, region: str) -> list[Item]:
    premises = sorted(law[region]["premises"])
    v, omega, beta = f"{region}_v", f"{region}_omega", f"{region}_beta"
    wind = f"{region}_wind"
    steps = [
        step(v, "m/s", f"limit(wind_estimate, first({wind}), last({wind}))"),
        step(omega, "rad/s", f"line({v}, {wind}, {region}_rotor_speed)", "trim"),
        step(beta, "rad", f"line({v}, {wind}, {region}_pitch)", "trim"),
    ]
    point = {"a": ("speed", omega), "b": ("pitch", beta), "d": (v, v)}
    angle = "pitch" if "b" in premises else beta
    for p in premises:
        here, trim = point[p]
        at = {"a": ("{}", angle, v), "b": (omega, "{}", v), "d": (omega, beta, "{}")}[p]
        steps += _secant(f"{region}_{p}", p, here, trim, at)
        low, high = f"{region}_{p}_lower", f"{region}_{p}_upper"
        share = f"limit(({region}_{p} - {low})/({high} - {low}), 0, 1)"
        flat = float(law[region]["premises"][p][0]) == float(law[region]["premises"][p][1])
        steps.append(step(f"{region}_w_{p}", "-", "0" if flat else share))
    weights = ", ".join(f"{region}_w_{p}" for p in premises)
    for short, name in (("w", "speed"), ("p", "pitch"), ("I", "integral")):
        formula = f"mix({region}_rules, {region}_k_{name}, {weights})"
        steps.append(step(f"{region}_{short}", "as its gain", formula))
    return steps


def _secant(name: str, p: str, here: str, trim: str, at: tuple[str, str, str]) -> list[Item]:
    """Return [a(far) - a(near)] / (far - near) of a = T_r / J, over at least the step."""
    low_end, high_end = f"({name}_mid - {name}_half)", f"({name}_mid + {name}_half)"
    ends = [[argument.format(end) for argument in at] for end in (high_end, low_end)]
    unit = {"a": "rad/s", "b": "rad", "d": "m/s"}[p]
    accelerations = [f"scale*{v}^2*spline({w}*radius/{v}, {b}, torque_coefficient)"
                     for w, b, v in ends]  # fmt: skip
    gap = f"{here} - {trim}"
    return [
        step(f"{name}_mid", unit, f"({here} + {trim})/2"),
        step(f"{name}_half", unit,
             f"choose(abs({gap}) - {STEPS[p]}, {STEPS[p]}/2, ({gap})/2)"),
        step(name, UNITS[p], f"({accelerations[0]} - {accelerations[1]})/(2*{name}_half)",
             "premise"),
    ]  # fmt: skip


def _command(region: str) -> str:
    return f"-{region}_w*e - {region}_p*pitch + {region}_I*x"


def _blended(coupling: Any, shape: str) -> list[Item]:
    half = "torque_overlap/2"
    curve = f"rated_torque - (rated_torque + {half} - T_near)^2/(2*torque_overlap)"
    share = [
        step("s_1", "-", "limit((speed - speed_ramp_start)/speed_overlap, 0, 1)"),
        step("f_1", "-", shape, "share of pitch"),
    ]
    if not float(coupling["speed_overlap"]):
        switch = "choose(speed - speed_ramp_start, 0, 1)"
        share = [step("f_1", "-", switch, "whether pitch acts")]
    torque = [
        step("T_near", "N m", f"limit(u_1, rated_torque - {half}, rated_torque + {half})"),
        step("phi", "N m", curve, "the corner at rated torque, rounded"),
        step(
            "torque_wanted",
            "N m",
            f"choose(u_1 - rated_torque + {half}, u_1, max(phi, u_1*rated_torque/top_torque))",
            "f_2(u_1) u_1",
        ),
    ]
    if not float(coupling["torque_overlap"]):
        torque = [step("torque_wanted", "N m", "u_1")]
    return [
        *share,
        *torque,
        step("torque_held", "N m", "limit(torque_wanted, 0, rated_torque)"),
        step("pitch_held", "rad", "limit(f_1*u_2, pitch_min, pitch_max)"),
    ]
