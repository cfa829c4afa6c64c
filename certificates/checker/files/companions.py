"""Whether a certificate is about the model's data files that are given with it."""

from __future__ import annotations

import hashlib
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Any

from takagi.certificates.checker.kernel.reader import member
from takagi.certificates.checker.kernel.refusal import CertificateError

__all__ = ["compare_model", "unconnected"]

# Kinds whose matrices stand in the claim itself: a gain or model file says nothing about them.
SELF_CONTAINED = ("quadratic-decay", "no-common-quadratic")
MOST_TOLD = 3  # files that a message names
LARGEST_FILE = 64_000_000


def unconnected(data: dict[str, Any]) -> str:
    """Return which claims the given files have no part in; to be read after a replay."""
    places = [
        f"claims[{i}]" for i, claim in enumerate(data["claims"]) if claim["kind"] in SELF_CONTAINED
    ]
    return f"about matrices inside the claim alone: {', '.join(places)}" if places else ""


def compare_model(data: dict[str, Any], model: Path | str) -> str:
    """Return what a reader has to know; refuses data files that have changed since."""
    if "model" not in data:
        raise CertificateError(
            "certificate: 'model' is missing; give a certificate, such as the certificate.json of "
            "a design"
        )
    recorded = member(data["model"], "files_sha256", "model")
    path = Path(model)
    if not isinstance(recorded, dict) or path.name not in recorded:
        made_from = ", ".join(islice(recorded, MOST_TOLD)) if isinstance(recorded, dict) else ""
        raise CertificateError(
            f"{model}: not a file that the certificate was made from; it names "
            f"{made_from or 'none'}: give the path of that model"
        )
    for name in recorded:
        file = path.parent / _inside(name)
        if name != path.name and not file.resolve().is_relative_to(path.parent.resolve()):
            raise CertificateError(f"{file}: is a link that leads out of the model's folder")
        if _hash(file) != recorded[name]:
            why = _what_changed(data, path) if name == path.name else ""
            raise CertificateError(
                f"{file}: has changed since the certificate was made from it{why}; make the "
                "certificate again with 'takagi certify'"
            )
    return _compared(data, path)


def _compared(data: dict[str, Any], path: Path) -> str:
    """Compare the numbers and equations of a file that the checker can read."""
    # Imported here: one of them at most is needed, and neither for a gain file.
    if path.suffix == ".toml" and data["model"].get("kind") == "plant":
        from takagi.certificates.checker.files.plant_file import compare_plant

        _require_blend_claim(data)
        return compare_plant(data["model"], path)
    if path.suffix == ".toml" and data["model"].get("kind") == "turbine":
        from takagi.certificates.checker.files.turbine_file import compare_turbine

        return compare_turbine(data["model"], data.get("gains"), path)
    return ""


def _require_blend_claim(data: dict[str, Any]) -> None:
    """Refuse a plant behind a blend without the claim that this is the plant of the file."""
    if "blending" not in data["model"]:
        return
    if not any(claim.get("kind") == "effort-blend" for claim in data["claims"]):
        raise CertificateError(
            "the certificate has a blend, but no claim 'effort-blend' that ties it to the plant "
            "with its two actuators; make it again with 'takagi certify'"
        )


def _what_changed(data: dict[str, Any], path: Path) -> str:
    """Return what the changed file says otherwise, as far as the certificate has it."""
    if path.suffix != ".toml" or data["model"].get("kind") not in ("plant", "turbine"):
        return ""
    try:
        _compared(data, path)
    except CertificateError as error:
        return f" ({error})"
    return " (not in what the certificate says of it: in words, layout or design options)"


def _hash(file: Path) -> str:
    """Return the SHA-256 of a file; refuses what is no plain file, and what is too large."""
    try:
        if not file.is_file():
            raise CertificateError(f"{file}: cannot be read: not a file")
        with file.open("rb") as opened:
            content = opened.read(LARGEST_FILE + 1)
    except OSError as error:
        raise CertificateError(f"{file}: cannot be read: {error.strerror or error}") from error
    if len(content) > LARGEST_FILE:
        raise CertificateError(f"{file}: larger than {LARGEST_FILE} bytes")
    return hashlib.sha256(content).hexdigest()


def _inside(name: str) -> PurePosixPath:
    """Return a file's place in the model's folder or below it; refuses what leads out of it."""
    place = PurePosixPath(name)
    plain = name.isprintable() and "\\" not in name and ":" not in name and str(place) == name
    if not plain or not place.name or place.is_absolute() or ".." in place.parts:
        raise CertificateError(f"model.files_sha256: {name!a} is not a file name")
    return place
