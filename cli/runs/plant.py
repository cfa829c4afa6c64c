"""Makes a plant's design, or the proof of given gains, for a verb; no gains is an answer."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from takagi.certificates.design.design import CertifiedLaw, NoDesign
from takagi.cli.options.given import Groups, as_typed
from takagi.cli.options.plant_options import plant_options, plant_settings, sampled_options
from takagi.cli.options.time_budget import budget_asked, time_options
from takagi.cli.progress import Tell

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.plant_files.loader import PlantFile


@dataclass(frozen=True, eq=False)
class PlantMaker:
    """What verbs ask of a plant, see ``takagi.cli.runs.makers.Maker``."""

    words: ClassVar[str] = "a plant"
    groups: ClassVar[Groups] = (plant_options, sampled_options, time_options)
    summary: ClassVar[str] = "takagi.cli.terminal.plant_summary"
    simulation: ClassVar[str] = "takagi.cli.verbs.simulate_plant"
    has_maps: ClassVar[bool] = False
    source: PlantFile
    asked: Mapping[str, Any]

    def design(self, tell: Tell) -> PlantDesign | NoDesign:
        """Return the finished design."""
        from takagi.certificates.design.plant.design import design_plant
        from takagi.certificates.design.plant.many_rules import BUDGET

        found = design_plant(
            *self._question(),
            files=self.source.files,
            tell=tell,
            announce=lambda words: print(f"takagi: {words}", file=sys.stderr, flush=True),
            budget=budget_asked(self.asked.get("time"), BUDGET),
        )
        given = as_typed(self.asked)
        if isinstance(found, NoDesign) and given:
            relax = f"Asked for on the command line: {given}; relax that first."
            return NoDesign(f"{found.reason}\n{relax}")
        return found

    def certify(self, gains: Path, tell: Tell) -> CertifiedLaw:
        """Return the certificate of a file's law, also on a plant that has changed since."""
        from takagi.certificates.design.plant.design import certify_filed

        plant, settings = self._question()
        found = certify_filed(plant, gains, settings, files=self.source.files, tell=tell)
        return CertifiedLaw(found.document, found.checked, found.notes[1:], found.is_about_plant)

    def with_gains(self, gains: Path, tell: Tell) -> PlantDesign:
        """Return the proof for the gains of a file, as they stand: a design to be simulated."""
        from takagi.certificates.design.given.plant_gains import read_gains
        from takagi.certificates.design.plant.design import certify_filed, certify_plant

        plant, settings = self._question()
        if plant.measured is not None:
            return certify_filed(plant, gains, settings, files=self.source.files, tell=tell)
        return certify_plant(
            plant,
            lambda derived: read_gains(gains, derived),
            settings,
            files=self.source.files,
            tell=tell,
        )

    def _question(self) -> tuple[Plant, PlantSettings]:
        return self.source.model, plant_settings(self.source, self.asked)
