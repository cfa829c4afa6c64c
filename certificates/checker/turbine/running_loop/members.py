"""The members of the claims about the loop as it runs, at constant winds and in moving wind."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain

FAMILY: Members = {
    "winds": {},
    "uncertainty": plain("inertia wake_length"),
    "observer": plain("l1 l2 wind_limits"),
    "measurement": {"speed_filter": {}, "torsion_filter": plain("frequency passed")},
}
MOVING: Members = {**FAMILY, "functions": plain("wind P")}
# The readers of ``multipliers`` refuse a name that is not a factor's.
CELL: Members = {"wind": {}, "multipliers": None}
MOVING_CELL: Members = {**CELL, **plain("wind_rate decay_rate residual_share")}
COMMON_SIDES = "speed measured pitch signal estimate measured_rate innovation"
SIDES = plain(f"{COMMON_SIDES} effort schedule integral")
OF: dict[str, Members] = {
    "running-loop": {**FAMILY, "decay_rate": {}, "cells": {**CELL, "P": {}, "sides": SIDES}},
    "running-rate": {**MOVING, "cells": {**MOVING_CELL, "schedule_cuts": {}, "sides": SIDES}},
}
