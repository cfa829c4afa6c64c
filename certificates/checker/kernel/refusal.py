"""The exceptions by which the checker refuses a file."""

from __future__ import annotations


class CertificateError(ValueError):
    """The file is no certificate, is damaged, or does not belong to the given gains or model."""


class Refused(CertificateError):
    """A computation met a value that no valid certificate contains."""


class OtherGains(CertificateError):
    """The gain file differs from the certificate, so the proofs are not about it."""
