"""Makes a plant's design, or the proof of given gains, for a verb; no gains is an answer."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from takagi.certificates.design.design import CertifiedLaw, NoDesign
from takagi.cli.options.given import Options, as_typed
from takagi.cli.options.plant_options import PLANT_DESIGN_OPTIONS, plant_settings, time_asked
from takagi.cli.progress import Step, Tell
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.plant_files.loader import PlantFile


@dataclass(frozen=True, eq=False)
class PlantMaker:
    """The maker for plants, see ``takagi.cli.runs.makers.Maker``."""

    words: ClassVar[str] = "a plant"
    options: ClassVar[Options] = PLANT_DESIGN_OPTIONS
    summary: ClassVar[str] = "takagi.cli.terminal.plant_summary"
    simulation: ClassVar[str] = "takagi.cli.verbs.simulate_plant"
    steps: ClassVar[tuple[Step, ...]] = (
        Step("model", 0.8),
        Step("gains", 2.0, varies=True),
        Step("exact proof", 1.0, varies=True),
        Step("report: margins", 0.1),
        Step("report: motions", 2.6),
        Step("report: figures", 0.8),
    )
    source: PlantFile
    asked: Mapping[str, Any]

    def design(self, tell: Tell) -> PlantDesign | NoDesign:
        """Return the finished design."""
        from takagi.certificates.design.plant.design import design_plant
        from takagi.certificates.design.plant.many_rules import BUDGET

        asked = self.asked.get("time")
        budget = time_asked("--time", asked, positive=True, bare="") if asked else BUDGET
        outcome = design_plant(
            *self._question(),
            files=self.source.files,
            tell=tell,
            announce=lambda words: print(f"takagi: {words}", file=sys.stderr, flush=True),
            budget=budget,
        )
        typed = as_typed(self.asked)
        if isinstance(outcome, NoDesign) and typed:
            relax = f"Asked for on the command line: {typed}; relax that first."
            return NoDesign(f"{outcome.reason}\n{relax}")
        return outcome

    def certify(self, gains: Path, tell: Tell) -> CertifiedLaw:
        """Return the certificate of a file's law, also on a plant that has changed since.

        Its notes say what has changed, and, where it is not proved, how much less would be.
        """
        from takagi.certificates.design.given.kept_model import as_sentences, largest_change
        from takagi.certificates.design.plant.design import certify_filed

        plant, settings = self._question()
        files = self.source.files
        law = certify_filed(plant, gains, settings, files=files, tell=tell)
        notes = [*law.notes[1:], *changes_since(plant, gains, law.document)]
        if not law.proved:
            tell("what would be proved")
            less = largest_change(plant, gains, settings, files=files, tell=tell)
            notes += [] if less is None else as_sentences(less, plant, settings)
        return CertifiedLaw(law.document, law.checked, tuple(notes), law.is_about_plant)

    def with_gains(self, gains: Path, tell: Tell) -> PlantDesign:
        """Return the proof for the gains of a file, as they stand: a design to be simulated.

        The plant may have changed since, as long as its equations can be written in the premises of
        the file.

        Raises
        ------
        ModelError : they cannot, so that the law has weights of its own.
        CertificateError : the gain file is unreadable, or not for this plant.
        """
        from takagi.certificates.design.given.kept_model import REST_MOVED
        from takagi.certificates.design.plant.design import certify_filed

        plant, settings = self._question()
        proof = certify_filed(plant, gains, settings, files=self.source.files, tell=tell)
        if REST_MOVED in proof.notes:
            raise ModelError(
                f"{gains}: the law cannot be simulated on this plant: {REST_MOVED} (of 'takagi "
                "certify'); simulate the law on its own plant, or the new one on this plant"
            )
        if proof.gains is not None and proof.law is None and proof.output_law is None:
            why = next((note for note in proof.notes if "are not kept: " in note), "")
            raise ModelError(
                f"{gains}: the law cannot be simulated on this plant, which has changed: "
                f"{why}; simulate it on its own plant, or design gains anew ('takagi certify' says "
                "what is still proved of these)"
            )
        return proof

    def _question(self) -> tuple[Plant, PlantSettings]:
        from takagi.certificates.design.plant.static_gains import plant_of_law

        settings = plant_settings(self.source, self.asked)
        return plant_of_law(self.source.model, settings), settings


def changes_since(plant: Plant, gains: Path, document: Mapping[str, Any]) -> list[str]:
    """Return what has changed from the plant that a gain file was made for; [] if nothing has.

    Ranges, rests and units are in the gain file; equations and parameters are in its certificate,
    which is looked for beside it.
    """
    from takagi.certificates.checker.kernel.reader import read_json
    from takagi.certificates.design.given.kept_model import changes_of_signals

    file = read_json(gains)
    stated = file.get("certificate")
    hashes = stated.get("sha256") if isinstance(stated, Mapping) else None
    digest = hashes.get("model") if isinstance(hashes, Mapping) else None
    if digest is None or digest == document["provenance"]["sha256"]["model"]:
        return []
    differences = changes_of_signals(plant, file, (document.get("gains") or {}).get("trim") or {})
    beside = _certificate_beside(gains, str(digest))
    if beside is None:
        differences.append(
            "its equations and parameters may have changed too: they stand in the certificate of "
            "the gains, which is not beside the gain file"
        )
    else:
        differences += _changes_of_model(beside, document)
    return [f"changed since the gains were made: {difference}" for difference in differences]


def _certificate_beside(gains: Path, digest: str) -> Mapping[str, Any] | None:
    """Return the certificate in the folder of the gain file that is about the same model."""
    from takagi.certificates.checker.kernel.reader import read_json
    from takagi.certificates.checker.kernel.refusal import CertificateError

    try:
        certificate = read_json(gains.with_name("certificate.json"))
    except CertificateError:
        return None
    provenance = certificate.get("provenance")
    hashes = provenance.get("sha256") if isinstance(provenance, Mapping) else None
    stated = hashes.get("model") if isinstance(hashes, Mapping) else None
    return certificate if stated is not None and str(stated) == digest else None


def _changes_of_model(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    from takagi.certificates.checker.kernel.reader import read_text
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.baseline.comparison import changes

    read = read_text(dumps(new), "certificate")
    pair = ({"model": document["model"]} for document in (old, read))
    signal_members = ("states", "inputs", "disturbances", "name", "description", "source")
    return [
        f"{change.place}: {change.old} -> {change.new}"
        for change in changes(*pair)
        if change.part == "model" and change.place.split(".")[0] not in signal_members
    ]
