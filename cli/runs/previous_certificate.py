"""A previous certificate and a tolerance, for `takagi certify --baseline` and `takagi compare`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked
    from takagi.reports.baseline.comparison import CertificateComparison

TOLERANCE = "5%"
_LONGEST = 20


@dataclass(frozen=True, slots=True, eq=False)
class PreviousCertificate:
    """A certificate as plain data, and the checker's verdicts on it."""

    source: Path
    document: Mapping[str, Any]
    checked: Checked


def read_baseline(path: Path) -> PreviousCertificate:
    """Return a certificate with its verdicts; an old file is checked again before it is used.

    Raises
    ------
    CertificateError : the file is refused.
    """
    from takagi.certificates.checker import check
    from takagi.certificates.checker.kernel.reader import read_json

    checked = check(path)
    return PreviousCertificate(path, read_json(path), checked)


def compared(
    old: PreviousCertificate, new: PreviousCertificate, tolerance: Fraction
) -> CertificateComparison:
    """Return the comparison of the old certificate with the new one."""
    from takagi.reports.baseline.comparison import compare_certificates

    return compare_certificates(
        old.document,
        new.document,
        checked_old=old.checked,
        checked_new=new.checked,
        tolerance=tolerance,
    )


def tolerance_of(text: str) -> Fraction:
    """Return a share exactly; ``5%`` and ``0.05`` have the same value.

    Raises
    ------
    ModelError : not a number, or not from 0 to 100 %.
    """
    written = text.strip()
    plain = written.removesuffix("%").strip()
    try:
        short = len(plain) <= _LONGEST and "/" not in plain and "e" not in plain.lower()
        share = Fraction(plain) if short else None
    except ValueError:
        share = None
    if share is not None and written.endswith("%"):
        share /= 100
    if share is None or not 0 <= share <= 1:
        raise ModelError(f"--tolerance {text!r}: a share such as 5% or 0.05 is needed, 0 to 100 %")
    return share
