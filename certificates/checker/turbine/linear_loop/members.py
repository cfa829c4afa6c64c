"""The members of the claim about the linear loop in turbulence."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.running_loop.members import OBSERVED

OF: dict[str, Members] = {
    "turbine-crossing": {
        **plain("wind overspeed horizon probability cuts C"),
        **OBSERVED,
        "uncertainty": plain(
            "inertia speed_damping pitch_effectiveness wake_of_pitch wake_of_wind wake_length"
        ),
        "turbulence": plain("deviation rate rotor_time"),
    }
}
