"""The members of the effort-sharing law, of the claim about it, and of those that depend on it."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain

# ``state`` is words for the reader of the file.
OF: dict[str, Members] = {
    "coherent-loop": {
        **plain("state P"),
        "uncertainty": plain("inertia frozen_wake power_coefficient"),
        "box": plain("speed_error effort_lag speed_signal wind_share"),
        "peaks": plain("speed_error effort_lag speed_signal integral"),
        "settling": plain("P decay_rate"),
        "cells": plain(
            "wind effectiveness_limit stiffness loop_gain lag_gain share_gain lag_rate residual "
            "wind_gain inertia_gain effectiveness_slope reference_slope lag_disturbance "
            "integral_rate wind_error wind_rate multiplier decay_rate"
        ),
    },
    "wind-rate": {
        "loop": {},
        "ranges": plain("wind estimate_rate schedule_rate estimate_error"),
    },
    "actuator-rates": {
        **plain("loop wind_rate torque_step"),
        "cells": plain("pitch_rate signal_rate torque_rate schedule_bend"),
    },
}
LAW = plain(
    "name wind rotor_speed trim_effort effectiveness effectiveness_limit overlap proportional "
    "integral_rate inertia_feedforward feedforward_limit pitch_lead rated_torque effort_torque "
    "pitch_min pitch_max wind_filter integral_limit"
)
