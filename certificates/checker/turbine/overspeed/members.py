"""The members of the claim about a speed that turbulence seldom reaches."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.running_loop.members import FILTERED

OF: dict[str, Members] = {
    "turbulence-speed": {
        **plain("horizon probability least_estimate highest_wind speed window"),
        **FILTERED,
        "wind": plain("mean deviation rate"),
        "uncertainty": plain("inertia torque_excess"),
    }
}
