"""A finished design for a plant, as a value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from takagi.models.arrays import Floats, ShortRepr

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked, Verdict
    from takagi.certificates.claims.certification import Certificate
    from takagi.lmi import Design
    from takagi.models.laws.pdc import OutputFeedback, PdcLaw, ReferenceFeedback
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class PlantDesign(ShortRepr):
    """A finished design, or a finished analysis of a plant without inputs.

    Attributes
    ----------
    settings : what was asked for.
    model : the Takagi-Sugeno model, equal to the plant on its box.
    design : gains as the solver left them, with P and the answer; None for an analysis, and for
        gains that were given.
    gains : K (r, m, n) of u - u* = -sum_i h_i K_i (x - x*), short decimals: those that are emitted
        and proved.  None for an analysis.
    law : the same with premises and trim, to be evaluated at run time; None for an analysis, and
        where the plant has measured outputs.
    certificate : what is claimed of ``model`` and ``gains``, and what the checker says about it.
    notes : in words, what was chosen where nothing was asked, and what was backed off.
    seconds : step -> time it took.
    output_law : the law of a plant with measured outputs: these gains, and its observer.
    observer : how its observer's gains were found by LMIs; None where they were not.
    regulator_sizes : (n,) of the states and (m,) of the inputs, SI, of the linear-quadratic
        regulator that the law was chosen beside; None where it was not.
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
    output_law: OutputFeedback | ReferenceFeedback | None = None
    observer: Design | None = None
    regulator_sizes: tuple[Floats, Floats] | None = None

    kind: ClassVar[Literal["plant"]] = "plant"

    @property
    def name(self) -> str:
        """Of the plant."""
        return self.plant.name

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
        """PROVED, DISPROVED or UNDECIDED, of what the certificate is about."""
        return self.certificate.verdict

    @property
    def is_about_plant(self) -> bool:
        """Whether the certificate has the plant's equations, not the model's vertices alone."""
        return bool(self.document["model"]["kind"] == "plant")

    @property
    def verdict_words(self) -> str:
        """``PROVED`` only where it is said of the plant, not of its model's vertices alone."""
        alone = "" if self.is_about_plant else ", of the vertices alone: not of the plant"
        return f"{self.verdict.name}{alone}"

    @property
    def proved(self) -> bool:
        """Whether everything is proved, and of the plant itself."""
        return self.is_about_plant and self.verdict.name == "PROVED"
