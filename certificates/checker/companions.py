"""Whether a certificate is about the gain file and the data files that are given with it."""

from __future__ import annotations

import hashlib
from pathlib import Path, PurePosixPath
from typing import Any

from takagi.certificates.checker.model_file import compare_turbine
from takagi.certificates.checker.plant.plant_file import compare_plant
from takagi.certificates.checker.reader import canonical, member, read_json
from takagi.certificates.checker.refusal import CertificateError

__all__ = ["compare_gains", "compare_model", "unconnected"]

# Kinds whose matrices stand in the claim itself: a gain or model file says nothing about them.
SELF_CONTAINED = ("quadratic-decay", "no-common-quadratic")


def compare_gains(data: dict[str, Any], gains: Path | str | None) -> str:
    """Return what a reader has to know; refuses a gain file with another law."""
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


def unconnected(data: dict[str, Any]) -> str:
    """Return which claims the given files have no part in; to be read after a replay."""
    places = [
        f"claims[{i}]" for i, claim in enumerate(data["claims"]) if claim["kind"] in SELF_CONTAINED
    ]
    return f"about matrices inside the claim alone: {', '.join(places)}" if places else ""


def compare_model(data: dict[str, Any], model: Path | str | None) -> str:
    """Return what a reader has to know; refuses data files that have changed since."""
    if model is None:
        return "checked without a model file: the verdict is about the plant inside the certificate"
    recorded = member(member(data, "model", "certificate"), "files_sha256", "model")
    path = Path(model)
    if not isinstance(recorded, dict) or path.name not in recorded:
        raise CertificateError(f"{model}: not a file that the certificate was made from")
    for name in recorded:
        file = path.parent / _inside(name)
        try:
            found = hashlib.sha256(file.read_bytes()).hexdigest()
        except OSError as error:
            raise CertificateError(f"{file}: cannot be read: {error.strerror or error}") from error
        if found != recorded[name]:
            raise CertificateError(f"{file}: has changed since the certificate was made from it")
    if path.suffix == ".toml" and data["model"].get("kind") == "plant":
        return compare_plant(data["model"], path)
    if path.suffix == ".toml" and data["model"].get("kind") == "turbine":
        compare_turbine(data["model"], data.get("gains"), path)
    return ""


def _inside(name: str) -> PurePosixPath:
    """Return a file's place in the model's folder or below it; refuses what leads out of it."""
    place = PurePosixPath(name)
    plain = name.isprintable() and "\\" not in name and ":" not in name and str(place) == name
    if not plain or not place.name or place.is_absolute() or ".." in place.parts:
        raise CertificateError(f"model.files_sha256: {name!a} is not a file name")
    return place
