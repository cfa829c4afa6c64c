"""The model and the claims of a gain file's certificate, for targets that write them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel.reader import digest, member, read_json
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram


def certified_model(
    gains: Path, certificate: Path | None, program: ControllerProgram
) -> Mapping[str, Any] | None:
    """Return the model of a certificate, with numbers as the file has them.

    Parameters
    ----------
    certificate : None takes ``certificate.json`` in the gain file's folder if its model has the
        hash that the gain file states, and otherwise returns None.

    Raises
    ------
    ModelError : the given certificate is about another model than the gain file, or the law is not
        proved, so that no certificate is about it.
    CertificateError : it cannot be read.
    """
    if not program.hashes:
        if certificate is None:
            return None
        raise ModelError(
            f"{certificate} was given, and {gains} names no certificate: the law is not proved; "
            "leave --certificate out"
        )
    path = certificate or gains.parent / "certificate.json"
    if certificate is None and not path.is_file():
        return None
    model: Mapping[str, Any] = member(read_json(path), "model", str(path))
    if digest(model) == program.hashes.get("model"):
        return model
    if certificate is None:
        return None
    raise ModelError(
        f"{path} is about another model than {gains}: the gain file names the SHA-256 of its model"
    )


def certified_claims(
    gains: Path, certificate: Path | None, program: ControllerProgram
) -> tuple[Mapping[str, Any], ...]:
    """Return the claims of the gain file's certificate; () without it, or if it has other claims.

    Parameters
    ----------
    certificate : None takes ``certificate.json`` in the gain file's folder.  Claims are returned if
        they have the hash that the gain file states.

    Raises
    ------
    CertificateError : the file cannot be read.
    """
    path = certificate or gains.parent / "certificate.json"
    if not program.hashes or not path.is_file():
        return ()
    claims = member(read_json(path), "claims", str(path))
    return tuple(claims) if digest(claims) == program.hashes.get("claims") else ()
