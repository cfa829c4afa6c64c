"""The members of the claim about the loop as it runs, at constant winds."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain

OF: dict[str, Members] = {
    "running-loop": {
        **plain("winds decay_rate"),
        "observer": plain("l1 l2 wind_limits"),
        "measurement": {"speed_filter": {}, "torsion_filter": plain("frequency passed")},
        "uncertainty": plain("inertia wake_length"),
        "cells": {
            **plain("wind P"),
            "sides": plain(
                "speed measured pitch signal effort schedule estimate integral measured_rate "
                "innovation"
            ),
            # The reader of ``multipliers`` refuses a name that is not a factor's.
            "multipliers": None,
        },
    }
}
