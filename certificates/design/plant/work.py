"""What is needed to certify gains of a plant: its model, what is asked for, and the clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.claims.certification import ClaimRequirements, plant_certificate
from takagi.certificates.controller.content import bound
from takagi.certificates.controller.plant_members import plant_members
from takagi.certificates.design.design import StepClock, Tell
from takagi.certificates.design.plant.gain_task import FoundGains, GainTask, rounded_gains
from takagi.certificates.design.plant.gains import requirements_of
from takagi.certificates.design.plant.plain_words import advice_of, in_plant_words
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.models.arrays import Floats
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import Plant

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.equilibrium_line import ConstantObserver
    from takagi.models.ts.model import TSModel

# Significant digits of the emitted gains; more where fewer cannot be proved.
DIGITS = (4, 6, 9)


def plant_model(plant: Plant, settings: PlantSettings, clock: StepClock | None = None) -> TSModel:
    """Return the Takagi-Sugeno model that a design with these settings is made for.

    Raises
    ------
    ModelError : the plant has none on its box.
    """
    from takagi.models.sector.model import sector_model

    with (clock or StepClock(None))("model"), in_plant_words(plant):
        if plant.references:
            return secant_model(plant, rest=settings.rest)
        if plant.blending is not None:
            from takagi.models.blending.substitution import blended_model

            return blended_model(plant, choice=settings.choice, rest=settings.rest)
        return sector_model(plant, choice=settings.choice, rest=settings.rest)


def _may_be_the_digits(design: PlantDesign) -> bool:
    """Return whether a claim about the gains is open that a few digits of them may decide."""
    claims = zip(design.document["claims"], design.checked.claims, strict=True)
    return any(
        claim["kind"] not in ("sector-embedding", "sampled-loop", "tracking", "attraction-region")
        and checked.verdict.name != "PROVED"
        for claim, checked in claims
    )


@dataclass(frozen=True, slots=True, eq=False)
class PlantWork:
    """What is needed to certify gains of one model."""

    task: GainTask
    requirements: ClaimRequirements
    files: tuple[Path, ...]
    clock: StepClock

    def of_task(self, task: GainTask) -> PlantWork:
        """Return the same for another model, or other ranges of the plant."""
        return replace(self, task=task, requirements=requirements_of(task))

    def searched(
        self, step: str, search: Callable[..., FoundGains | None], *options: Any
    ) -> tuple[FoundGains | None, PlantDesign | None]:
        """Return the gains of a search, and the design with them; None where there are none."""
        with self.clock(step), in_plant_words(self.task.plant):
            gains = search(self.task, *options)
        if gains is None or not gains.design.found:
            return gains, None
        return gains, self.rounded(gains)

    def rounded(self, gains: FoundGains) -> PlantDesign:
        """Return the design with gains of as few digits as can be proved."""
        last: PlantDesign | None = None
        work, limited = self, self.requirements.input_limits
        integrators = self.task.plant.integrators
        if limited is not None and (gains.input_share < 1 or integrators):
            limits, shape = gains.input_share * limited, np.asarray(gains.design.P)
            requirements = replace(self.requirements, input_limits=limits, shape=shape)
            work = replace(self, requirements=requirements)
        # What the numbers of a controller do may be a small difference of large ones.
        for digits in DIGITS[1:] if integrators else DIGITS:
            K = rounded_gains(np.asarray(gains.design.require()[0]), digits)
            notes = (*gains.notes, f"gains to {digits} significant digits")
            last = work.certified(K, gains.design, notes, observer=gains.observer)
            if not _may_be_the_digits(last):
                break
        assert last is not None  # there is always a number of digits
        return replace(last, regulator_sizes=gains.sizes)

    def certified(
        self,
        gains: Floats | None,
        design: Design | None,
        notes: tuple[str, ...],
        *,
        law: Mapping[str, Any] | None = None,
        observer: ConstantObserver | None = None,
    ) -> PlantDesign:
        from takagi.models.laws.pdc import PdcLaw, ReferenceFeedback

        plant, model, settings = self.task.plant, self.task.model, self.task.settings
        with self.clock("exact proof"):
            certificate = plant_certificate(
                model,
                gains,
                settings,
                self.requirements,
                files=self.files,
                law=law,
                observer=observer,
            )
        document, checked = certificate.document, certificate.checked
        if document["model"]["kind"] != "plant":
            notes = (*certificate.tried[:1], *notes)
        notes = (*advice_of(checked), *notes)
        run = output_law = None
        if gains is not None:
            if law is None:
                trim = document["gains"]["trim"]
                run = PdcLaw(model, gains, np.array(trim["state"]), np.array(trim["input"]))
            times = [
                float(claim["sample_time"])
                for claim, verdict in zip(document["claims"], checked.claims, strict=True)
                if claim["kind"] == "sampled-loop" and verdict.verdict.name == "PROVED"
            ]
            sample = max(times, default=None)
            members = (plant, model, document["gains"], checked, notes)
            controller = plant_members(*members, proved_sample=sample)
            certificate = replace(certificate, document=bound(document, controller))
        if observer is not None and run is not None:
            states = tuple(plant.own_states)
            output_law, run = ReferenceFeedback(run, observer, plant.measured_rows, states), None
        values = (plant, settings, model, design, gains, run, certificate)
        return PlantDesign(*values, notes, dict(self.clock.seconds), output_law=output_law)


def plant_work(
    plant: Plant, settings: PlantSettings | None, files: Sequence[Path], tell: Tell | None
) -> PlantWork:
    """Return what is needed to certify gains of the plant's own model."""
    chosen, clock = settings or PlantSettings(), StepClock(tell)
    task = GainTask.of(plant, plant_model(plant, chosen, clock), chosen)
    return PlantWork(task, requirements_of(task), tuple(files), clock)
