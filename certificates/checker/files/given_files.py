"""Compare a certificate with the given model file, by the contents of the file."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from takagi.certificates.checker.files.model_content import (
    OtherModel,
    beside_the_claims,
    content_differences,
    file_content,
    model_content,
    told,
)
from takagi.certificates.checker.kernel.reader import MOST_CLAIMS, listed, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError

LARGEST_FILE = 64_000_000
EARLIER = (
    "only what the claims are about is compared: the certificate, of an earlier version, does not "
    "hold what else the file says"
)


def compare_files(
    data: dict[str, Any],
    path: str,
    gains: Path | str | None,
    model: Path | str | None,
    messages: list[str],
    allow_old: bool,
) -> list[str]:
    """Return the messages about the given files, or that in ``messages`` about one left out.

    Raises
    ------
    CertificateError : as ``compare_gains`` and ``compare_model``, or claims that are no list of
        objects that name their kinds, or no model.
    """
    for i, claim in enumerate(listed(data, "claims", path, 1, MOST_CLAIMS)):
        text(claim, "kind", f"claims[{i}]")
    member(data, "model", "certificate")
    about_gains, about_model = messages
    if gains is not None:
        # Imported here: a model alone does not need it.
        from takagi.certificates.checker.files.gain_file import compare_gains

        about_gains = compare_gains(data, gains, allow_old=allow_old)
    if model is not None:
        about_model = compare_model(data, model)
    return [message for message in (about_gains, about_model) if message]


def compare_model(data: dict[str, Any], model: Path | str) -> str:
    """Return messages about the model file for the reader.

    Contents are compared, not bytes (``model_content``).

    Raises
    ------
    OtherModel : the contents of the file differ from the certificate.
    CertificateError : it cannot be read, or the certificate is about matrices: no claim says that
        these are the model of a file, whatever hash the certificate holds.
    """
    if "model" not in data:
        raise CertificateError(
            "certificate: 'model' is missing; give a certificate, such as the certificate.json of "
            "a design"
        )
    certified, path = data["model"], Path(model)
    if not isinstance(certified, dict) or certified.get("kind") not in ("plant", "turbine"):
        raise CertificateError(
            f"{path}: the certificate is about matrices, which no claim ties to a model file; "
            "check it without a model file, or make one from this file with 'takagi certify'"
        )
    content = model_content(path)
    recorded = certified.get("model_file")
    differences = [] if recorded is None else content_differences(content, recorded)
    try:
        words = _compare_meaning(data, path)
    except CertificateError as error:
        if differences:
            raise OtherModel(told(path, differences, str(error))) from error
        raise
    uncovered = [
        change
        for change in differences
        if beside_the_claims(change, content, certified, data.get("gains"))
    ]
    if uncovered:
        raise OtherModel(told(path, uncovered))
    if recorded is None and _digest(path) not in _recorded(data).values():
        words += f"{'; ' if words else f'{path}: '}{EARLIER}"
    return words


def _compare_meaning(data: dict[str, Any], path: Path) -> str:
    """Compare the numbers and equations of a file with those that the claims are about."""
    # Imported here: at most one of them is needed, and none for a gain file.
    if data["model"]["kind"] == "plant":
        from takagi.certificates.checker.files.plant_file import compare_plant

        _require_blend_claim(data)
        kinds = {claim.get("kind") for claim in data["claims"]}
        return compare_plant(data["model"], path, data.get("gains"), narrower=kinds == {"tracking"})
    from takagi.certificates.checker.files.turbine_file import compare_turbine

    return compare_turbine(data["model"], data.get("gains"), path)


def _require_blend_claim(data: dict[str, Any]) -> None:
    """Refuse a blended plant without the claim that it is the plant of the file."""
    if "blending" not in data["model"]:
        return
    if not any(claim.get("kind") == "effort-blend" for claim in data["claims"]):
        raise CertificateError(
            "the certificate has a blend, but no claim 'effort-blend' that ties it to the plant "
            "with its two actuators; make it again with 'takagi certify'"
        )


def _recorded(data: dict[str, Any]) -> dict[str, Any]:
    """Return the SHA-256 of the files by name; older certificates hold it in the model."""
    provenance = data.get("provenance")
    for owner in (provenance, data["model"]):
        hashes = owner.get("files_sha256") if isinstance(owner, dict) else None
        if isinstance(hashes, dict):
            return hashes
    return {}


def _digest(file: Path) -> str:
    content = file_content(file, what="file of a model", largest=LARGEST_FILE)
    return hashlib.sha256(content).hexdigest()
