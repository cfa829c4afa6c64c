"""From a plant to a checked design: model, gains as they are emitted, certificate.

This module combines models, lmi and certificates for general plants. All outputs (gain file,
report, simulation) read the ``PlantDesign`` made here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.controller.content import plain
from takagi.certificates.design.design import NoDesign, Tell
from takagi.certificates.design.plant.candidates import laws_beside_regulator
from takagi.certificates.design.plant.gain_task import FoundGains
from takagi.certificates.design.plant.gains import (
    GAIN_OF_EACH_REGION,
    regional_gains,
    scheduled_gains,
)
from takagi.certificates.design.plant.many_rules import (
    BUDGET,
    GainChoice,
    gain_choice,
    gains_of_few_premises,
    gains_of_known_premises,
    shortened_gains,
)
from takagi.certificates.design.plant.plain_words import (
    in_file_rates,
    in_plant_words,
    obstacle,
    require_sensible,
)
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.static_gains import plant_of_law
from takagi.certificates.design.plant.tracking_design import claims_alone, design_tracking
from takagi.certificates.design.plant.work import PlantWork, plant_work
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import Plant

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel

# The search for a helpful relaxation needs some fifty designs.
MOST_EXPLAINED = 32


def design_plant(
    plant: Plant,
    settings: PlantSettings | None = None,
    *,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
    announce: Tell | None = None,
    budget: float = BUDGET,
) -> PlantDesign | NoDesign:
    """Return model, gains, law and certificate of a plant; without inputs, an analysis.

    The gains are rounded to short decimals first; what is claimed and proved is about these.

    Parameters
    ----------
    settings : what is asked for; None leaves every choice.
    files : the data files the plant was read from; the certificate records their SHA-256.
    tell : called with a word before each step.
    announce : called before long work, with its size and what is done about it.
    budget : time [s] that a gain for every rule may take, by an estimate; beyond it fewer gains
        are sought (``takagi.certificates.design.plant.many_rules``).

    Raises
    ------
    ModelError : the plant has no Takagi-Sugeno model on its box, or the settings make no sense
        for it.
    """
    plant = plant_of_law(plant, settings or PlantSettings())
    work = plant_work(plant, settings, files, tell)
    task, clock = work.task, work.clock
    if plant.references:
        tracking = design_tracking(task, clock)
        if isinstance(tracking, NoDesign):
            return tracking
        return work.of_task(tracking[0]).rounded(tracking[1])
    if plant.measured is not None:
        from takagi.certificates.design.plant.observed_design import design_observed

        return design_observed(work)
    if not plant.inputs:
        return work.certified(None, None, ("no inputs: an analysis",))
    require_sensible(plant, task.model, task.settings)
    regional, by_regions = work.searched("gains", regional_gains)
    if regional is not None and by_regions is not None and by_regions.proved:
        return _beside_regulator(work, regional, by_regions)
    choice = gain_choice(task.model, task.with_one_gain()[0].settings, budget)
    if choice.announcement and announce is not None:
        announce(choice.announcement)
    further: list[tuple[Any, ...]] = [("gains by known premises", gains_of_known_premises)]
    gains, design = _best_of_candidates(work, choice)
    if choice.shortened:
        further.insert(0, ("gains over few premises", gains_of_few_premises, budget))
    further.append(("gains by a function of the weights", scheduled_gains))
    for step, search, *options in further if design is None or not design.proved else ():
        _, alternative = work.searched(step, search, *options)
        if alternative is not None and alternative.proved:
            return alternative
    if design is not None:
        return design
    with clock("what would help"):
        reason = _reason(gains, work)
        return NoDesign(f"{choice.note}\n{reason}" if choice.note else reason)


def _beside_regulator(work: PlantWork, gains: FoundGains, proved: PlantDesign) -> PlantDesign:
    """Return the proved design of these gains, or another that is better beside LQR."""
    with work.clock("gains"), in_plant_words(work.task.plant):
        law = laws_beside_regulator(work.task, gains)[0]
    if law.design is gains.design:
        return proved
    notes = tuple(note for note in law.notes if note != GAIN_OF_EACH_REGION)
    other = work.rounded(replace(law, notes=notes))
    return other if other.proved else proved


def _best_of_candidates(
    work: PlantWork, choice: GainChoice
) -> tuple[FoundGains, PlantDesign | None]:
    """Return the first law found and the design: of the preferred law, if that is proved."""
    with work.clock("gains"), in_plant_words(work.task.plant):
        first = shortened_gains(work.task, choice) if choice.shortened else None
        laws = laws_beside_regulator(work.task, first)
    design = None
    for gains in laws:
        design = work.rounded(gains) if gains.design.found else None
        if design is not None and design.proved:
            break
    return laws[-1], design


def certify_plant(
    plant: Plant,
    gains: Callable[[TSModel], Floats] | ArrayLike,
    settings: PlantSettings | None = None,
    *,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
) -> PlantDesign:
    """Return the same for gains that exist, as they stand.

    Parameters
    ----------
    gains : K (r, m, n), or a function that returns them for the model, e.g. from a gain file.
    settings : ``choice`` and ``rest`` decide what the rules are; a decay rate, limits of inputs and
        a region of poles that are asked for have to be proved.

    Raises
    ------
    ModelError : as ``design_plant``, and gains that do not fit the model.
    """
    plant = plant_of_law(plant, settings or PlantSettings())
    if plant.measured is not None and (not plant.references or plant.hides_states):
        raise ModelError(
            f"plant {plant.name!r} measures {', '.join(plant.measured)}: gains of all states are "
            "no law for it; give the gain file of its design"
        )
    work = plant_work(plant, settings, files, tell)
    K = gains(work.task.model) if callable(gains) else np.asarray(gains, dtype=np.float64)
    return work.certified(K, None, ("gains were given",))


def certify_filed(
    plant: Plant,
    path: Path,
    settings: PlantSettings | None = None,
    *,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
) -> PlantDesign:
    """Return the same for the law of a gain file, also where the plant has changed since.

    The file's premises are kept where the new equations can be written in them; else the law has
    weights of its own, and ``law`` of the answer is None: it cannot be run with the model.

    Raises
    ------
    ModelError : as ``design_plant``.
    CertificateError : the gain file is unreadable, or not for this plant.
    """
    from takagi.certificates.design.given.kept_model import law_for

    plant = plant_of_law(plant, settings or PlantSettings())
    if claims_alone(plant):
        from takagi.certificates.design.given.plant_gains import in_ranges_of

        plant = in_ranges_of(path, plant)
    work = plant_work(plant, settings, files, tell)
    if plant.references and plant.hides_states:
        from takagi.certificates.design.given.plant_gains import read_reference_gains

        K, observer = read_reference_gains(path, plant, work.task.model)
        return work.certified(K, None, ("gains were given",), observer=observer)
    if plant.measured is not None and not plant.references:
        return _certify_observed(work, path)
    law = law_for(plant, work.task.model, path, work.task.settings, files=files)
    work = work.of_task(work.task.with_model(law.model))
    return work.certified(law.gains, None, law.notes, law=law.law)


def _certify_observed(work_of_plant: PlantWork, path: Path) -> PlantDesign:
    """Return the certificate for the gains K and L of a file, as they stand."""
    from takagi.certificates.design.given.kept_model import (
        is_of,
        model_in_premises_of,
        moved_rest,
    )
    from takagi.certificates.design.given.plant_gains import read_observer_gains, read_plant_law
    from takagi.certificates.design.plant.observed_design import ObservedWork

    task, work = work_of_plant.task, ObservedWork.of(work_of_plant)
    try:
        K, L = read_observer_gains(path, work)
        return work.certified_pair(K, L, None, ("gains were given", work.note))
    except CertificateError as error:
        first_error = error
    if is_of(task.model, path, work_of_plant.files):
        raise first_error
    law = plain(read_plant_law(path))
    notes: tuple[str, ...] = ("gains were given", work.note)
    try:
        K, L = read_observer_gains(path, work, any_trim=True)
    except CertificateError:
        try:
            model = model_in_premises_of(task.plant, law, task.settings)
            work = ObservedWork.of(work_of_plant.of_task(task.with_model(model)))
            K, L = read_observer_gains(path, work, any_trim=True)
        except (ModelError, CertificateError) as reason:
            raise CertificateError(
                f"{first_error}; on a changed plant a law with measured outputs is proved in the "
                f"premises of its file alone, and there: {reason}"
            ) from reason
        notes = (*notes, "the premises of their file were kept")
    return work.certified_pair(K, L, None, (*notes, *moved_rest(law, work.base.task.model)))


def _reason(gains: FoundGains, work: PlantWork) -> str:
    """Return why there are no gains, and what would help where that can be asked.

    First in the words of the plant's file; what the solver says of its inequalities comes last.
    """
    from takagi.lmi import explain

    design, plant, model = gains.design, work.task.plant, work.task.model
    if plant.integrators and design.answer.diagnosis:
        # The search for a controller says what to try itself.
        return in_file_rates(design.answer.diagnosis, plant)
    cause = obstacle(design.answer, plant, model, work.task.settings)
    paragraphs = [cause] if cause else []
    if design.answer.diagnosis:
        paragraphs.append(f"{'In detail: ' if cause else ''}{design.answer.diagnosis}")
    if len(model.A) <= MOST_EXPLAINED and gains.options is not None:
        paragraphs.append(str(explain(design, model, steps=4, **gains.options)))
    return in_file_rates("\n".join(paragraphs), plant)
