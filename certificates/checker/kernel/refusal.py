"""Why the checker refuses to go on: the file is not what it has to be."""

from __future__ import annotations

__all__ = ["CertificateError", "OtherGains", "Refused"]


class CertificateError(ValueError):
    """The file is no certificate, is damaged, or does not belong to the given gains or model."""


class Refused(CertificateError):
    """A computation met something that no sound certificate contains."""


class OtherGains(CertificateError):
    """The gain file says something else than the certificate: what is proved is not about it."""
