"""Makes a turbine's design for a verb; a requirement that no design meets is an answer."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from takagi.certificates.design.design import CertifiedLaw, NoDesign
from takagi.cli.options.given import Options, as_typed
from takagi.cli.options.turbine_options import TURBINE_OPTIONS
from takagi.cli.options.turbine_settings import EFFORT_SHARING, design_settings, uncertainty_asked
from takagi.cli.progress import Step, Tell
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.certificates.design.turbine.settings import DesignSettings
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.loader import TurbineFile

Value = TypeVar("Value")
# With the NREL 5-MW turbine, on one core.
_STEPS = (
    Step("stability of the loop that runs", 12.0),
    Step("partial-load model", 1.5),
    Step("gains of the effort-sharing law", 1.2),
    Step("joint analysis of the blended loop", 11.0),
    Step("loop with its observer", 27.0),
    Step("summary", 16.0),
    Step("report", 6.0),
)
STABILITY = "stability of the loop that runs"


@dataclass(frozen=True, eq=False)
class TurbineMaker:
    """The maker for turbines, see ``takagi.cli.runs.makers.Maker``."""

    words: ClassVar[str] = "a wind turbine"
    options: ClassVar[Options] = TURBINE_OPTIONS
    summary: ClassVar[str] = "takagi.cli.terminal.turbine_summary"
    simulation: ClassVar[str] = "takagi.cli.verbs.simulate_turbine"
    source: TurbineFile
    asked: Mapping[str, Any]

    @property
    def steps(self) -> tuple[Step, ...]:
        """Those of the effort-sharing law; the steps of another law have no usual times."""
        return _STEPS if self.asked["law"] in (None, EFFORT_SHARING) else ()

    def design(self, tell: Tell) -> TurbineDesign | NoDesign:
        """Return the finished design."""
        turbine, files = self.source.model, self.source.files
        settings = design_settings(turbine, **self.asked)

        def work(noted: Tell) -> TurbineDesign | NoDesign:
            from takagi.certificates.design.turbine.design import design_turbine

            notes = _stability(turbine, settings, noted)
            finished = design_turbine(turbine, settings, files=files, tell=noted)
            return replace(finished, notes=notes)

        return self._answered(work, tell)

    def certify(self, gains: Path, tell: Tell) -> CertifiedLaw | NoDesign:
        """Return the certificate of a gain file's law, as it stands."""
        from takagi.certificates.design.given.turbine_law import (
            certify_law,
            effort_sharing_law_from_data,
            read_law,
            read_observer,
        )

        turbine = self.source.model
        law = effort_sharing_law_from_data(read_law(gains), source=str(gains))
        controller = read_observer(gains)
        uncertainty = uncertainty_asked(self.asked)
        files = self.source.files

        def work(noted: Tell) -> CertifiedLaw:
            made = certify_law(
                turbine,
                law,
                uncertainty=uncertainty,
                files=files,
                controller=controller,
                tell=noted,
            )
            return CertifiedLaw(*made)

        return self._answered(work, tell)

    def _answered(self, work: Callable[[Tell], Value], tell: Tell) -> Value | NoDesign:
        """Return the result of ``work``, or its step and reason: misuse was refused before."""
        step = ""

        def noted(text: str, done: float | None = None) -> None:
            nonlocal step
            step = text
            tell(text, done)

        try:
            return work(noted)
        except ModelError as error:
            given, words = as_typed(self.asked), str(error)
            # The step's name may open the message already.
            prefix = "" if not step or words.startswith(step.split(" of ")[0]) else f"{step}: "
            relax = f"\nAsked for beyond the defaults: {given}; relax that first." if given else ""
            return NoDesign(f"{prefix}{words}{relax}")


def _stability(turbine: Turbine, settings: DesignSettings, tell: Tell) -> tuple[str, ...]:
    """Tell and return notes on the loop that runs; an unstable one is refused."""
    if settings.law != "coherent":
        return ()
    from takagi.reports.margins.running_stability import require_stable

    tell(STABILITY)
    try:
        notes = require_stable(turbine, settings, lambda step: tell(f"{STABILITY}: {step}"))
    except ModelError:
        tell(STABILITY)  # The step that a refusal is told with is the whole of them.
        raise
    for note in notes:
        # At once, before the long work; the summary has it again.
        print(f"note: {note}", file=sys.stderr, flush=True)
    return notes
