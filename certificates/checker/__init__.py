"""An independent checker: standard library alone, shares no code with the synthesis.

Rooms: ``reader`` (strict JSON, numbers as written), ``definite`` (exact definiteness), ``fixed``
(outward-rounded intervals), ``spline`` (ranges of the coefficient surface), ``shown`` (numbers in
words, rounded to the safe side), ``quadratic`` and ``coherent`` (one kind of claim each; the latter
with ``coherent_inputs``, ``coherent_loop``, ``coherent_residual`` and ``coherent_corners``),
``certificate`` (the whole file).
"""

from __future__ import annotations

from takagi.certificates.checker.certificate import check
from takagi.certificates.checker.refusal import CertificateError
from takagi.certificates.checker.result import Checked, Claim, Verdict

__all__ = ["CertificateError", "Checked", "Claim", "Verdict", "check"]
