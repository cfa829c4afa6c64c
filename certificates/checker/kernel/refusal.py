"""Why the checker refuses to go on: the file is not what it has to be."""

from __future__ import annotations

__all__ = ["CertificateError", "Refused"]


class CertificateError(ValueError):
    """The file is no certificate, is damaged, or does not belong to the given gains or model."""


class Refused(CertificateError):
    """A computation met something that no sound certificate contains."""
