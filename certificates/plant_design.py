"""From a plant to a checked design: model, gains as they are emitted, certificate.

The one place where the floors below meet for plants in general: everything that leaves the house
(gain file, report, simulation) reads the ``PlantDesign`` made here.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.plant_settings import PlantSettings
from takagi.models.errors import ModelError
from takagi.models.plant.plant import Plant

if TYPE_CHECKING:
    from takagi.certificates.checker.result import Checked, Verdict
    from takagi.certificates.common_quadratic import Certificate
    from takagi.lmi.answer import Design
    from takagi.models.law.pdc import PdcLaw
    from takagi.models.ts_model import TSModel

__all__ = ["NoPlantDesign", "PlantDesign", "PlantSettings", "design_plant"]

Floats = NDArray[np.float64]
Tell = Callable[[str], None]
# Significant digits of the emitted gains; more where fewer cannot be proved.
DIGITS = (4, 6, 9)


@dataclass(frozen=True, slots=True, eq=False)
class PlantDesign:
    """A finished design, or a finished analysis of a plant without inputs.

    Attributes
    ----------
    settings : what was asked for.
    model : the Takagi-Sugeno model, equal to the plant on its box.
    design : gains as the solver left them, with P and the answer; None for an analysis, and for
        gains that were given.
    gains : K (r, m, n) of u - u* = -sum_i h_i K_i (x - x*), short decimals: those that are emitted
        and proved.  None for an analysis.
    law : the same with premises and trim, to be evaluated at run time; None for an analysis.
    certificate : what is claimed of ``model`` and ``gains``, and what the checker says about it.
    notes : in words, what was chosen where nothing was asked, and what was backed off.
    seconds : step -> time it took.
    """

    plant: Plant
    settings: PlantSettings
    model: TSModel
    design: Design | None
    gains: Floats | None
    law: PdcLaw | None
    certificate: Certificate
    notes: tuple[str, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)

    @property
    def checked(self) -> Checked:
        """Verdict per claim."""
        return self.certificate.checked

    @property
    def document(self) -> Mapping[str, Any]:
        """The certificate as it is written."""
        return self.certificate.document

    @property
    def verdict(self) -> Verdict:
        """PROVED, DISPROVED or UNDECIDED."""
        return self.certificate.verdict


@dataclass(frozen=True, slots=True, eq=False)
class NoPlantDesign:
    """There are no gains for what was asked, or none were found.

    Attributes
    ----------
    design : the last answer of the solver layer, with its diagnosis.
    reason : in words: what binds, and what would help.
    """

    plant: Plant
    settings: PlantSettings
    model: TSModel
    design: Design
    reason: str
