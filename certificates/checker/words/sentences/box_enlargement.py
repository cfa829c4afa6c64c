"""What a proved claim of kind ``box-enlargement`` says: the claim ``decay`` of other ranges."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.result import Outcome
from takagi.certificates.checker.words.rounded import at_least
from takagi.certificates.checker.words.saying import in_words


def said(what: str, theta: Fraction, decay: Outcome) -> tuple[str, str]:
    """Return name and sentence; ``what`` has been widened by ``theta``, or shrunk below 1.

    With ``theta`` = 0 one loop is left, so that nothing is said of the model.
    """
    proved = in_words(decay)
    shrunk = ", less than the model's own" if theta < 1 else ""
    shrunk += "" if theta else ", their middle alone, which says nothing of the model"
    return proved.name, f"{what} times {at_least(theta, 6)}{shrunk}: {proved.text}"
