"""What targets take from a gain file's certificate: its model, and its claims' matrices."""

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
    """Return the model of a certificate, numbers as they are written there.

    Parameters
    ----------
    certificate : None takes ``certificate.json`` beside the gain file if it is about the same
        model by its hash, and returns None if it is not.  A law that is not proved has no hash: it
        takes a given certificate of a model with its plant's name.

    Raises
    ------
    ModelError : the given certificate is about another model than the gain file.
    CertificateError : it cannot be read.
    """
    if certificate is None and not program.hashes:
        return None
    path = certificate or gains.parent / "certificate.json"
    if certificate is None and not path.is_file():
        return None
    model: Mapping[str, Any] = member(read_json(path), "model", str(path))
    if digest(model) == program.hashes.get("model"):
        return model
    if certificate is None:
        return None
    if program.hashes:
        raise ModelError(
            f"{path} is about another model than {gains}: the gain file names the SHA-256 of its "
            "model"
        )
    if model.get("name") == program.plant:
        return model
    raise ModelError(f"{path} is about {model.get('name')!r}; the law is one for {program.plant!r}")


def certified_claims(
    gains: Path, certificate: Path | None, program: ControllerProgram
) -> tuple[Mapping[str, Any], ...]:
    """Return the claims of the gain file's certificate; () where there is none, or other ones.

    Parameters
    ----------
    certificate : None takes ``certificate.json`` beside the gain file.  Claims count if their hash
        is the one that the gain file names.

    Raises
    ------
    CertificateError : the file cannot be read.
    """
    path = certificate or gains.parent / "certificate.json"
    if not program.hashes or not path.is_file():
        return ()
    claims = member(read_json(path), "claims", str(path))
    return tuple(claims) if digest(claims) == program.hashes.get("claims") else ()
