"""The members of a finished design of a turbine or plant; the exception if there is no design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked


class Design(Protocol):
    """A finished design; verbs and reports read it in the same way for every kind of model."""

    @property
    def kind(self) -> Literal["turbine", "plant"]:
        """Of the model, by which its pages are chosen."""

    @property
    def name(self) -> str:
        """Of the model."""

    @property
    def settings(self) -> object:
        """What was asked for."""

    @property
    def document(self) -> Mapping[str, Any]:
        """The certificate as it is written."""

    @property
    def checked(self) -> Checked:
        """What the independent checker says about it."""

    @property
    def is_about_plant(self) -> bool:
        """Whether the certificate is about the plant itself, not its model's vertices alone."""

    @property
    def verdict_words(self) -> str:
        """The verdict, and its subject if that is not the plant."""

    @property
    def proved(self) -> bool:
        """Whether everything is proved, for the plant itself."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Texts on choices that were made by default, and on requirements that were relaxed."""

    @property
    def seconds(self) -> Mapping[str, float]:
        """Step -> time it took."""


@dataclass(frozen=True, slots=True)
class NoDesign:
    """There is no such design, or none was found; ``reason`` says why, and what may help."""

    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class CertifiedLaw:
    """The certificate of existing gains; its members have the meaning of those in ``Design``."""

    document: Mapping[str, Any]
    checked: Checked
    notes: tuple[str, ...] = ()
    is_about_plant: bool = True
