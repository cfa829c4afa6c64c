"""Claims about a plant: what they read, and how a step that is not proved becomes a reason."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel.claim_kind import ClaimKind
from takagi.certificates.checker.kernel.obligation import Decider, decided_exactly
from takagi.certificates.checker.kernel.reader import text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, read_plant

KIND = "plant"


@dataclass(frozen=True)
class PlantClaim(ClaimKind):
    """A claim about the plant of ``model``.

    Attributes
    ----------
    claim, model, gains, where : the parts of the file, and the claim's place for messages.
    form : of the embedding that the claim needs, "sector" or "secant".
    removable : the variables at whose zero a quotient means its limit; known when the obligations
        have been decided.
    """

    form: ClassVar[str]
    claim: Any = field(repr=False)
    model: Any = field(repr=False)
    gains: Any = field(repr=False)
    where: str
    name: str
    plant: PlantNodes = field(repr=False)
    removable: set[str] = field(default_factory=set, repr=False)

    @classmethod
    def read(cls, claim: Any, data: Any, where: str) -> Self:
        """Return the claim; ``data`` is the whole file.

        Raises
        ------
        CertificateError : the model is malformed, of another kind or of another form.
        """
        name, model = text(claim, "name", where), data["model"]
        if text(model, "kind", "model") != KIND:
            raise CertificateError(
                f"{where}: a claim about a plant; model.kind is {model['kind']!a}"
            )
        model = cls.embedded(model)
        plant = read_plant(model, "model")
        if plant.form != cls.form:
            raise CertificateError(
                f"{where}: model.embedding.form is {plant.form!a}, not {cls.form!r}"
            )
        return cls(claim, model, data.get("gains"), where, name, plant)

    @classmethod
    def embedded(cls, model: Any) -> Any:
        """Return the model with the embedding that the claim is about."""
        return model

    def failure(self, holds: Decider = decided_exactly) -> str:
        """Return which step is not proved; empty if all are."""
        try:
            reason = super().failure(holds)
        except Refused as error:
            reason = str(error) or "a step is refused"
        return f"not proved: {reason}" if reason else ""


@dataclass(frozen=True, slots=True)
class Enclosure:
    """lower <= node <= upper on the box of ``ranges``, an obligation about an expression.

    ``subject`` : the expression in words, for the reason.
    """

    ranges: Ranges
    node: int
    lower: Fraction
    upper: Fraction
    subject: str

    @property
    def failure(self) -> str:
        return f"{self.subject} is not shown to stay in its bounds"

    @property
    def holds(self) -> bool:
        """True.

        Raises
        ------
        Refused : it does not hold, or is not decided; the message says where.
        """
        self.ranges.prove_within(self.node, self.lower, self.upper, self.subject)
        return True
