"""From a file to verdicts: read strictly, compare hashes and companions, replay every claim."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from takagi.certificates.checker.coherent import check_coherent
from takagi.certificates.checker.model_file import compare_turbine
from takagi.certificates.checker.paper import check_paper
from takagi.certificates.checker.quadratic import check_impossibility, check_quadratic
from takagi.certificates.checker.reader import (
    canonical,
    digest,
    integer,
    member,
    read_json,
    read_text,
    text,
)
from takagi.certificates.checker.refusal import CertificateError
from takagi.certificates.checker.result import Checked, Claim

__all__ = ["FORMAT", "VERSION", "check", "check_document"]

FORMAT, VERSION = "takagi-certificate", 1
HASHED = ("model", "gains", "claims")
# Kinds whose matrices stand in the claim itself: a gain or model file says nothing about them.
SELF_CONTAINED = ("quadratic-decay", "no-common-quadratic")


def check(
    path: Path | str, *, gains: Path | str | None = None, model: Path | str | None = None
) -> Checked:
    """Return the verdict on every claim of a certificate file.

    Parameters
    ----------
    gains : a gain file; its law must be the certificate's, number by number.
    model : the model's data file; its SHA-256 must be the one recorded.

    Raises
    ------
    CertificateError : the file is unreadable, damaged, of another version, or not about the given
        gains or model.
    """
    data = read_json(Path(path))
    messages = [_compare_gains(data, gains), _compare_model(data, model)]
    checked = _replayed(data, str(path))
    if gains is not None or model is not None:
        messages.append(_unconnected(data))
    return Checked(checked.verdict, checked.claims, [message for message in messages if message])


def check_document(document: Mapping[str, Any]) -> Checked:
    """Return the verdict on a certificate that is not written yet, as a reader would see it.

    Raises
    ------
    CertificateError : as for ``check``.
    """
    return _replayed(read_text(json.dumps(document), "certificate"), "certificate")


def _replayed(data: dict[str, Any], path: str) -> Checked:
    if text(data, "format", "certificate") != FORMAT:
        raise CertificateError(f"{path}: the format is not {FORMAT!r}")
    version = integer(data, "version", "certificate")
    if version != VERSION:
        raise CertificateError(
            f"{path}: version {version}; this checker reads version {VERSION}: use a matching one"
        )
    _check_hashes(path, data)
    claims = member(data, "claims", "certificate")
    if not isinstance(claims, list) or not claims:
        raise CertificateError(f"{path}: no claims")
    return Checked.of([_replay(claim, data, f"claims[{i}]") for i, claim in enumerate(claims)], [])


def _replay(claim: Any, data: dict[str, Any], where: str) -> Claim:
    kind = text(claim, "kind", where)
    text(claim, "name", where)
    if kind == "coherent-loop":
        return check_coherent(claim, member(data, "model", "certificate"), data.get("gains"), where)
    if kind == "paper-loop":
        return check_paper(claim, member(data, "model", "certificate"), data.get("gains"), where)
    if kind == "quadratic-decay":
        return check_quadratic(claim, where)
    if kind == "no-common-quadratic":
        return check_impossibility(claim, where)
    raise CertificateError(f"{where}.kind: {kind!r} is not a kind that this checker can replay")


def _check_hashes(path: Path | str, data: dict[str, Any]) -> None:
    hashes = member(member(data, "provenance", "certificate"), "sha256", "provenance")
    for part in HASHED:
        if text(hashes, part, "provenance.sha256") != digest(data.get(part)):
            raise CertificateError(
                f"{path}: the {part} are not those the certificate was made for (its hash "
                "differs); make the certificate again with 'takagi certify'"
            )


def _compare_gains(data: dict[str, Any], gains: Path | str | None) -> str:
    if gains is None:
        return "checked without a gain file: the verdict is about the gains inside the certificate"
    law = member(read_json(Path(gains)), "law", str(gains))
    if canonical(law) != canonical(data.get("gains")):
        raise CertificateError(f"{gains}: the law is not the certificate's{_first(law, data)}")
    return ""


def _first(law: Any, data: dict[str, Any]) -> str:
    ours = data.get("gains")
    if not isinstance(law, dict) or not isinstance(ours, dict):
        return ""
    keys = sorted(set(law) | set(ours))
    differing = [k for k in keys if canonical(law.get(k)) != canonical(ours.get(k))]
    return f"; what differs: {', '.join(map(ascii, differing[:6]))}"


def _unconnected(data: dict[str, Any]) -> str:
    """Return which claims the given files have no part in; to be read after a replay."""
    places = [
        f"claims[{i}]" for i, claim in enumerate(data["claims"]) if claim["kind"] in SELF_CONTAINED
    ]
    return f"about matrices inside the claim alone: {', '.join(places)}" if places else ""


def _compare_model(data: dict[str, Any], model: Path | str | None) -> str:
    if model is None:
        return "checked without a model file: the verdict is about the plant inside the certificate"
    recorded = member(member(data, "model", "certificate"), "files_sha256", "model")
    path = Path(model)
    if not isinstance(recorded, dict) or path.name not in recorded:
        raise CertificateError(f"{model}: not a file that the certificate was made from")
    for name in recorded:
        if not name or Path(name).name != name or not name.isprintable():
            raise CertificateError(f"model.files_sha256: {name!a} is not a file name")
        file = path.with_name(name)
        try:
            found = hashlib.sha256(file.read_bytes()).hexdigest()
        except OSError as error:
            raise CertificateError(f"{file}: cannot be read: {error.strerror or error}") from error
        if found != recorded[name]:
            raise CertificateError(f"{file}: has changed since the certificate was made from it")
    if path.suffix == ".toml":
        compare_turbine(data["model"], data.get("gains"), path)
    return ""
