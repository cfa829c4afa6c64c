"""What a simulation leaves: arrays over time, with their units."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.simulation.turbine_plant import Flag
from takagi.models.turbine.aerodynamics import rotor_thrust
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind, trim


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class History:
    """A closed loop over time, one row per controller sample; all arrays are (n,) and read-only.

    Attributes
    ----------
    time [s]; wind, wind_estimate [m/s] : the wind without the tower's motion, and what the law saw.
    rotor_speed [rad/s]; generator_speed : as seen from the low-speed side [rad/s], equal to
        rotor_speed without torsion.
    pitch, pitch_reference [rad]; pitch_rate [rad/s].
    torque : of the generator, high-speed shaft, in force from this sample to the next [N m].
    torque_command : what the law asked for [N m].
    electrical_power : efficiency times torque times generator speed [W].
    rotor_torque [N m], thrust [N] : aerodynamic, at the sample.
    tower_displacement [m], tower_velocity [m/s] : fore-aft, at the top; 0 without a tower.
    tower_moment : fore-aft at the base [N m]: hub height times (stiffness x + damping x') over the
        turbine's ``tower_share``, which is thrust times hub height at rest.
    plant_states : (n, m), in the order of the plant's ``state_names``.
    law_states : (n, k), in the order of the law's ``state_names``.
    flags : (n,) integers, sums of ``takagi.models.simulation.turbine_plant.Flag``.
    wind_name : for tables.
    """

    time: Floats
    wind: Floats
    wind_estimate: Floats
    rotor_speed: Floats
    generator_speed: Floats
    pitch: Floats
    pitch_reference: Floats
    pitch_rate: Floats
    torque: Floats
    torque_command: Floats
    electrical_power: Floats
    rotor_torque: Floats
    thrust: Floats
    tower_displacement: Floats
    tower_velocity: Floats
    tower_moment: Floats
    plant_states: Floats
    law_states: Floats
    flags: NDArray[np.int64]
    wind_name: str

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def share_flagged(self, flag: Flag) -> float:
        """Return the share of samples at which the flag stands [-]."""
        return float(np.mean((self.flags & flag.value) != 0))

    def per_unit(self, turbine: Turbine) -> dict[str, Floats]:
        """Return the series over their bases [-], by name; ``time`` stays in s.

        Bases: wind and its estimate by rated wind; rotor speed, torque and electrical power by
        their rated values; pitch and its reference by the trim pitch at cut-out; tower
        displacement and moment by their static values at rated wind.
        """
        wind = rated_wind(turbine)
        thrust = float(rotor_thrust(turbine, turbine.rated_rotor_speed, turbine.pitch_min, wind))
        bases = {
            "wind": wind,
            "wind_estimate": wind,
            "rotor_speed": turbine.rated_rotor_speed,
            "pitch": trim(turbine, turbine.cut_out).pitch,
            "pitch_reference": trim(turbine, turbine.cut_out).pitch,
            "torque": turbine.rated_torque,
            "electrical_power": turbine.rated_power,
            "tower_displacement": turbine.tower_share * thrust / turbine.tower_stiffness,
            "tower_moment": thrust * turbine.hub_height,
        }
        scaled = {name: np.asarray(getattr(self, name)) / base for name, base in bases.items()}
        return {"time": self.time, **scaled}
