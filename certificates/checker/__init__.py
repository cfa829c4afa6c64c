"""An independent checker: standard library alone, shares no code with the synthesis.

Rooms: ``reader`` (strict JSON, numbers as written), ``definite`` (exact definiteness), ``fixed``
(outward-rounded intervals), ``spline`` (ranges of the coefficient surface), ``shown`` (numbers in
words, rounded to the safe side), ``quadratic``, ``coherent`` and ``paper`` (one kind of claim each,
with what they are made of in ``coherent_*``, ``paper_*``, ``dual`` and ``interval_family``),
``model_file`` (the plant against its turbine file), ``certificate`` (the whole file).
"""

from __future__ import annotations

from takagi.certificates.checker.certificate import check
from takagi.certificates.checker.refusal import CertificateError
from takagi.certificates.checker.result import Checked, Claim, Verdict

__all__ = ["CertificateError", "Checked", "Claim", "Verdict", "check"]
