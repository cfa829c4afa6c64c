"""The members of a published law, and of the claim about the loop with it."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain

# ``state`` and ``reason`` are words for the reader of the file.
OF: dict[str, Members] = {
    "paper-loop": {
        **plain("state speed_ramp_start speed_overlap torque_overlap winds"),
        "unproved": plain("wind reason"),
        "cells": {
            **plain("wind rest centre box P disturbance decay_rate multiplier"),
            "corners": plain("low high"),
        },
    },
}
REGION = plain("wind rotor_speed pitch rules k_speed k_pitch k_integral")
LAW: Members = {
    **plain(
        "name states speed_setpoint minimum_rotor_speed optimal_tip_speed_ratio "
        "largest_tip_speed_ratio cut_in cut_out rated_torque pitch_min pitch_max tracking_time"
    ),
    "coupling": plain(
        "variant speed_ramp_start speed_overlap speed_ramp_shape torque_overlap minimum_torque "
        "top_torque"
    ),
    "partial": {**REGION, "premises": plain("a d")},
    "full": {**REGION, "premises": plain("a b d")},
}
