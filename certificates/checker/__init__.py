"""An independent checker: standard library alone, imports nothing else of takagi.

kernel/       code that every check uses: reader, exact matrices, verdicts
arithmetic/   intervals, functions and splines with outward rounding
loop/         the closed loop as exact matrices, and pieces of its weights
replay/       the check of one file: hashes, the table of kinds, the verdict
kinds/        claims about the loop that model and gains make, one kind a file
plant/        a plant's own equations: proofs that the model contains the plant
turbine/      the turbine's loops
files/        the certificate against the gain, turbine and plant files given beside it
controller/   the gain file of the proved law: programs, units, texts
words/        numbers in words, rounded to the safe side
"""

from __future__ import annotations

from takagi.certificates.checker.kernel.reader import read_text as read_text
from takagi.certificates.checker.kernel.refusal import CertificateError as CertificateError
from takagi.certificates.checker.kernel.result import Checked as Checked
from takagi.certificates.checker.kernel.result import Claim as Claim
from takagi.certificates.checker.kernel.result import Verdict as Verdict
from takagi.certificates.checker.replay.certificate import check as check
from takagi.certificates.checker.replay.certificate import check_document as check_document
