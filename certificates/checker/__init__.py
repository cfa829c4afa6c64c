"""An independent checker: standard library alone, shares no code with the synthesis.

kernel/       what every check runs through: reader, exact matrices, the table of kinds
arithmetic/   intervals, functions and splines with outward rounding
kinds/        claims about the loop that model and gains make, one kind a file
plant/        a plant's own equations: its model contains it
turbine/      the turbine's loops, and where they rest
files/        the certificate against the gain, turbine and plant files given beside it
controller/   what a gain file says of the law that is proved: programs, units, words
words/        numbers in words, rounded to the safe side
"""

from __future__ import annotations

from takagi.certificates.checker.kernel.certificate import check
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Checked, Claim, Verdict

__all__ = ["CertificateError", "Checked", "Claim", "Verdict", "check"]
