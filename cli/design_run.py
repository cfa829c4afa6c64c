"""Runs a design for a verb; a requirement that no design meets is an answer, not a misuse."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from takagi.cli.errors import UNPROVED
from takagi.cli.progress import Tell

if TYPE_CHECKING:
    from takagi.certificates.turbine_design import DesignSettings, TurbineDesign
    from takagi.models.turbine.data import Turbine

__all__ = ["Unprovable", "run_design"]


@dataclass(frozen=True, slots=True)
class Unprovable:
    """No design was found that meets what was asked; ``reason`` names condition, wind and cure."""

    reason: str

    def tell(self, *, as_json: bool = False) -> int:
        """Print the reason, and return the exit status for it.  Nothing was written."""
        if as_json:
            print(json.dumps({"verdict": "UNDECIDED", "reason": self.reason}, indent=2))
        else:
            print(f"Not proved, nothing written: {self.reason}", file=sys.stderr)
        return UNPROVED


def run_design(
    turbine: Turbine, asked: DesignSettings, model: str, tell: Tell
) -> TurbineDesign | Unprovable:
    """Return the finished design of ``turbine``, which was read from ``model``.

    What is misuse has been refused before, when options and model were read: a ``ModelError`` from
    here on is a condition that cannot be met.
    """
    from takagi.certificates.turbine_design import design_turbine
    from takagi.models.errors import ModelError
    from takagi.models.turbine.loader import model_files

    try:
        return design_turbine(turbine, asked, files=model_files(model), tell=tell)
    except ModelError as error:
        return Unprovable(str(error))
