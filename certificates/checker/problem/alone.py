"""A certificate about a conic problem has no law and no plant beside it."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.refusal import CertificateError


def require_alone(gains: Any, path: str, messages: list[str]) -> list[str]:
    """Return the messages of the verdict in the place of those about files of a law and a plant.

    Raises
    ------
    CertificateError : gains beside the problem. No claim speaks of them, so that PROVED would be
        said of any law.
    """
    if gains is not None:
        raise CertificateError(f"{path}: a certificate about a conic problem has no gains")
    return ["the verdict is about the problem inside the certificate"] if messages else []
