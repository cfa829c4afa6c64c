"""An independent checker: standard library alone, shares no code with the synthesis.

The kernel, 500 lines of code at most:

    reader        strict JSON, numbers as written
    definite      definiteness of integer matrices
    matrices      exact matrices: integers over one denominator
    family        the loop that model and gains make, and the blends that stand for all of it
    certificate   the whole file: hashes, and every claim by its kind

Beside it ``kinds/`` (one kind of claim a file; ``claim_kinds`` is their table), ``quadratic``
(claims that hold their own matrices), ``plant_embedding`` and ``plant/`` (a plant lies in its
model), ``coherent`` and ``paper`` with what they are made of (the turbine's loops), ``fixed`` and
``spline`` (outward-rounded intervals, ranges of a coefficient surface), ``shown`` (numbers in
words, rounded to the safe side), ``companions`` and ``model_file`` (against given files).
"""

from __future__ import annotations

from takagi.certificates.checker.certificate import check
from takagi.certificates.checker.refusal import CertificateError
from takagi.certificates.checker.result import Checked, Claim, Verdict

__all__ = ["CertificateError", "Checked", "Claim", "Verdict", "check"]
