"""The members of a finished design, the exception if there is none, and the time of its steps."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
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


Tell = Callable[[str], None]


class StepClock:
    """The time of each step: ``seconds``, step -> time [s]; repeated steps are summed."""

    def __init__(self, tell: Tell | None) -> None:
        self._tell = tell
        self.seconds: dict[str, float] = {}

    def told(self, words: str) -> None:
        """Report a part of a step."""
        if self._tell is not None:
            self._tell(words)

    @contextmanager
    def __call__(self, step: str) -> Iterator[None]:
        """Report a step, and record its duration."""
        self.told(step)
        started = time.perf_counter()
        yield
        self.seconds[step] = self.seconds.get(step, 0.0) + time.perf_counter() - started
