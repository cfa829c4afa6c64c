"""The members of the claim about the loop with a published law."""

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
