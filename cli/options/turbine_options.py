"""The options of a turbine's design, declared once for all verbs, and the names of its laws."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeVar

import typer

from takagi.cli.options.given import OBJECTIVE, Options, group, option

Given = TypeVar("Given", str, list[str], None)

# What each law is called in gain files and certificates; these names may be typed too.
IN_FILES = {
    "effort-sharing": "coherent",
    "schulte": "paper",
}
_REFERENCE = {"reference": "baseline"}
# Former names, which may still be typed.
_ALIASES = {"published": "paper"}

Model = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A built-in name (see `takagi models`) or the path of a TOML file.",
        show_default=False,
    ),
]

ModelOrFolder = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A built-in name, the path of a TOML file, or the folder of a design.",
        show_default=False,
    ),
]
Folder = Annotated[
    Path, typer.Argument(metavar="DIR", help="A folder of `takagi design`.", show_default=False)
]


def law_in_files(given: Given) -> Given:
    """Return the names that files have of the laws that were typed; others are left as they are."""
    if isinstance(given, list):
        return [law_in_files(name) for name in given]
    return given if given is None else (IN_FILES | _REFERENCE | _ALIASES).get(given, given)


def typed_name(law: str) -> str:
    """Return the name to type for a law of the files, for messages and tables."""
    return {filed: name for name, filed in (IN_FILES | _REFERENCE).items()}.get(law, law)


# In the order in which the help lists them.
_TURBINE = group(
    "Turbines",
    option(
        "law NAME",
        "Turbines: effort-sharing (one law for all winds, which hands its effort from torque to "
        "pitch), or the law of Schulte (2024), with regions and filters between them, schulte; "
        "effort-sharing unless given.",
        callback=law_in_files,
    ),
    option(
        "overlap",
        "Turbines: half the width of effort over which torque and pitch both act [rad/s^2]; 0.01 "
        "unless given. Effort-sharing law.",
        float,
    ),
    option(
        "speed_overlap",
        "Turbines: overlap of the coupling filter in rotor speed [rad/s]; 0.5 unless given. "
        "Schulte's law.",
        float,
    ),
    option(
        "torque_overlap",
        "Turbines: overlap of the coupling filter in torque [N m]; 4000 unless given. Schulte's "
        "law.",
        float,
    ),
    option(
        "speed_setpoint SPEED",
        "Turbines: de-rated rotor speed with its unit, 11.5rpm or 1.2rad/s; rated speed unless "
        "given.",
    ),
    option(
        "torque_setpoint TORQUE",
        "Turbines: de-rated generator torque with its unit, 34.5kNm, or a share of the rated one, "
        "80%; rated torque unless given.",
    ),
    option(
        "lowest_speed_setpoint SPEED",
        "Turbines: the law takes set-points of rotor speed and power at run time, the speed from "
        "this one, 10rpm or 1.05rad/s, to the rated one. Effort-sharing law.",
    ),
    option(
        "lowest_torque_setpoint TORQUE",
        "Turbines: the same, with the torque from this one, 38.8kNm or 90%, to the rated one. "
        "Effort-sharing law.",
    ),
    option(
        "pitch_effectiveness_share SHARE",
        "Turbines: pitch effectiveness that the law assumes, as a share of the frozen wake's [-]; "
        "1 unless given. A smaller one moves pitch more. Effort-sharing law.",
        float,
    ),
    option(
        "ramp_shape NAME",
        "Turbines: ramp of the coupling filter in speed: smooth (C1) or linear; smooth unless "
        "given. Schulte's law.",
    ),
    option(
        "ramp_placement SHARE",
        "Turbines: share of the speed overlap that lies above the set-point [-], 0 to 1; 0 "
        "unless given. Schulte's law.",
        float,
    ),
    option(
        "wind_filter SECONDS",
        "Turbines: low-pass on the wind estimate [s]; 12 unless given. A fast one, 0.05, is for a "
        "wind that is measured, by a lidar say: the wind rate that is proved is then larger, but "
        "with an estimate from rotor speed the loop oscillates. Effort-sharing law.",
        float,
    ),
    option(
        "speed_filter RAD/S",
        "Turbines: corner of the low-pass on the measured rotor speed [rad/s], which the gain file "
        "contains, 0 for none; 30 unless given, 8 without a torsion filter. Only the claim "
        "running-loop covers it.",
        float,
    ),
    option(
        "torsion_filter RAD/S",
        "Turbines: frequency of the band-stop on the measured rotor speed [rad/s], which the gain "
        "file contains, 0 for none; 0.9 of the drivetrain's torsion mode unless given, if the "
        "turbine's file states one. It removes that mode from the loop. Only the claim "
        "running-loop covers it.",
        float,
    ),
    option(
        "bandwidth",
        "Turbines: wanted proportional gain [1/s]; 0.6 unless given. Effort-sharing law.",
        float,
    ),
    option(
        "bandwidth_growth FACTOR",
        "Turbines: factor on --bandwidth from 1.25 times the wind where pitch begins to act [-]; 1 "
        "unless given, more for a rotor larger than the NREL 5-MW turbine's. Effort-sharing law.",
        float,
    ),
    option(
        "inertia LOW HIGH",
        "Turbines: true over nominal inertia that gains and certificate must cover; 0.9 1.1 unless "
        "given. Effort-sharing law.",
        tuple[str, str],
    ),
    option(
        "power_coefficient LOW HIGH",
        "Turbines: true over tabulated power coefficient that the certificate must cover, such as "
        "0.99 1.01; the table's own unless given. Effort-sharing law.",
        tuple[str, str],
    ),
    option(
        "equilibrium_wake",
        "Turbines: leave the frozen wake out of the pitch effectiveness that the certificate "
        "covers: wider wind limits, for a smaller family of plants.",
        bool,
    ),
    option(
        "two_step",
        "Turbines: find the gains wind by wind and prove them afterwards. This is the default "
        "unless --one-step or --objective is given. Effort-sharing law.",
        bool,
    ),
    option(
        "one_step",
        "Turbines: change gains and proof together, starting from the two-step gains. This takes "
        "about two minutes more and gives wider wind limits and faster decay; pitch then travels "
        "more. Effort-sharing law.",
        bool,
    ),
)
TURBINE_OPTIONS: Options = (*_TURBINE, OBJECTIVE)
