"""What a finished design is, of a turbine or of a plant; and that there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked


class Design(Protocol):
    """A finished design.  Verbs and reports read it without asking what the model is."""

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
        """The verdict, and what it is about where that is not the plant."""

    @property
    def proved(self) -> bool:
        """Whether everything is proved, and of the plant itself."""

    @property
    def notes(self) -> tuple[str, ...]:
        """In words, what was chosen where nothing was asked, and what was backed off."""

    @property
    def seconds(self) -> Mapping[str, float]:
        """Step -> time it took."""


@dataclass(frozen=True, slots=True)
class NoDesign:
    """There is no such design, or none was found; ``reason`` says what binds and what helps."""

    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class CertifiedLaw:
    """The certificate of gains that exist already; its members are those of ``Design``."""

    document: Mapping[str, Any]
    checked: Checked
    notes: tuple[str, ...] = ()
    is_about_plant: bool = True
