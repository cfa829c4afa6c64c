"""The members of the claim about the loop around its schedule wind."""

from __future__ import annotations

from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.running_loop.members import (
    COMMON_SIDES,
    MOVING,
    MOVING_CELL,
)

OF: dict[str, Members] = {
    "schedule-rate": {
        **MOVING,
        "cells": {**MOVING_CELL, "sides": plain(f"{COMMON_SIDES} wind drive")},
    }
}
