"""The contents of a gain file: from a certificate, and bound to a file of gains that were given.

A file of the current version keeps its texts, observer gains, trim table and the data about its own
certificate. Programs, limits, ranges and units are computed from the certified model. If they
differ from the file, ``takagi check --gains`` will refuse it, and ``differences_in_words`` reports
this beforehand.
For an older file all members other than the law are kept, if its numbers that belong to the model
are those of the model.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from takagi.certificates.checker.controller.content import VERSION, file_content
from takagi.certificates.checker.files.differences import (
    MOST_TOLD,
    differences_between,
    listed,
    shown,
)
from takagi.certificates.checker.files.gain_file import expected_file, left_out
from takagi.certificates.checker.kernel.reader import Number, digest, read_json, read_text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.document.certificate_file import as_read

# The first members of the file; the others keep their order.
ORDER = ("format", "version", "name", "turbine", "plant", "units", "law", "states", "inputs")
LAST = ("language", "programs", "rotor", "tables", "certificate")


def read_gain_file(path: Path) -> dict[str, Any]:
    """Return the content of a gain file, its numbers as they are written.

    Raises
    ------
    CertificateError : unreadable, not strict JSON, or of a later version than this takagi reads.
    """
    file = read_json(path)
    version = file.get("version")
    if isinstance(version, Number) and version.isdigit() and int(version) > VERSION:
        raise CertificateError(
            f"{path}: a gain file of version {version}; this takagi reads versions up to "
            f"{VERSION}: use the takagi that wrote it, or a newer one"
        )
    return file


def bound(document: Mapping[str, Any], controller: Mapping[str, Any]) -> dict[str, Any]:
    """Return the certificate with the other members of its gain file, and their hash."""
    provenance = document["provenance"]
    hashes = {**provenance["sha256"], "controller": digest(as_read(controller))}
    return {**document, "controller": controller, "provenance": {**provenance, "sha256": hashes}}


def gain_file_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``gains.json`` for a certificate with a ``controller``.

    ``certificate.sha256`` holds the certificate's hashes of model, law, claims and controller.
    """
    controller = document["controller"]
    content = plain(file_content(document["model"], document["gains"], controller))
    content["certificate"]["sha256"] = dict(document["provenance"]["sha256"])
    middle = [key for key in content if key not in (*ORDER, *LAST)]
    return {key: content[key] for key in (*ORDER, *middle, *LAST) if key in content}


def plain(value: Any) -> Any:
    """Return the value with numbers of the strict reader as JSON has them."""
    if isinstance(value, Number):
        is_integer = value.lstrip("-").isdigit()
        return int(value) if is_integer else float(value)
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


# Members that model and law do not determine; they are taken from the file.
FROM_THE_FILE = ("name", "turbine", "plant", "notes", "trim", "start", "observer",
                 "measurement", "certificate")  # fmt: skip
NEEDED = ("trim", "observer")  # of a turbine's file


def bound_to_file(
    document: Mapping[str, Any], path: Path, controller: Mapping[str, Any] | None = None
) -> Mapping[str, Any]:
    """Return the certificate bound to a gain file; unchanged if the file contains only a law.

    ``controller`` : that of the certificate where it has one that was made anew.

    Raises
    ------
    CertificateError : the file cannot be read, or is of an earlier version and differs from the
        model.
    """
    file = read_json(path)
    beside = {key: plain(value) for key, value in file.items() if key not in ("format", "law")}
    if not beside:
        return document if controller is None else bound(document, controller)
    if str(file.get("version")) == str(VERSION):
        if controller is not None and "sampling" not in file:
            # A file of before: its program does not hold estimates in the box.
            controller = {key: value for key, value in controller.items() if key != "sampling"}
        return _of_today(document, beside, controller)
    _compare_previous(_determined(document, controller), file, path)
    return bound(document, {"version": beside.get("version"), **beside})


def refreshed(
    document: Mapping[str, Any],
    path: Path,
    controller: Mapping[str, Any],
    statement: Mapping[str, Any],
) -> tuple[Mapping[str, Any], dict[str, Any]]:
    """Return the certificate bound to the gain file written anew, and the content of that file.

    Raises
    ------
    CertificateError : the file cannot be read, or lacks what does not follow from the model.
    """
    file = {key: plain(value) for key, value in read_json(path).items()}
    members = {key: file[key] for key in FROM_THE_FILE if key in file} | {"certificate": statement}
    certificate = _of_today(document, members, controller)
    if "controller" not in certificate:
        raise CertificateError(
            f"{path}: it has no {' and no '.join(k for k in NEEDED if k not in file)}, so no whole "
            "gain file can be written; give the gains.json of a design, or design anew"
        )
    return certificate, gain_file_of(certificate)


def differences_in_words(document: Mapping[str, Any], path: Path) -> str:
    """Return the fields in which a gain file differs from that of a certificate, or leaves out."""
    data, file = read_text(json.dumps(document), "certificate"), read_json(path)
    expected = expected_file(data) if "controller" in data else {}
    compared = file if expected else {}
    members = {key: expected.get(key) for key in compared}
    differences = list(islice(differences_between(compared, members), MOST_TOLD))
    words = listed(differences, "for this model") or "; ".join(left_out(file, expected, data))
    if not words:
        return ""
    return (
        f"{path}: 'takagi check --gains' will refuse it beside this certificate: "
        f"{words}. --gains-out FILE writes it anew for this model, with the "
        "same law"
    )


def _of_today(
    document: Mapping[str, Any], file: Mapping[str, Any], controller: Mapping[str, Any] | None
) -> Mapping[str, Any]:
    members = {**(controller or {}), **{key: file[key] for key in FROM_THE_FILE if key in file}}
    if document["gains"]["name"] != "pdc":
        if "sampling" in file:
            members["sampling"] = file["sampling"]
        if not all(isinstance(members.get(key), Mapping) for key in NEEDED):
            return document
        _require_measurement(members.get("measurement"))
        observer = {key: v for key, v in members["observer"].items() if key != "equations"}
        members |= {"observer": observer, "states": file.get("states", [])}
    members.setdefault("certificate", {})
    return bound(document, members)


def _require_measurement(stated: Any) -> None:
    """Refuse filters of the measured speed that are none; a file may lack them."""
    if stated is None:
        return
    members = stated if isinstance(stated, Mapping) else {}
    good = _positive(members.get("speed_filter")) and set(members) <= {
        "speed_filter",
        "torsion_filter",
    }
    if not good:
        raise CertificateError(
            f"the gain file's measurement is {str(stated)[:60]}; a corner above 0 is needed, "
            'such as {"speed_filter": 30.0} in rad/s, or leave the member out'
        )
    if "torsion_filter" in members:
        _require_band_stop(members["torsion_filter"])


def _require_band_stop(stated: Any) -> None:
    members = stated if isinstance(stated, Mapping) else {}
    passed = members.get("passed")
    good = set(members) == {"frequency", "passed"} and _positive(members["frequency"])
    if not (good and passed is not None and _number(passed) and 0 <= passed <= 1):
        raise CertificateError(
            f"the gain file's measurement.torsion_filter is {str(stated)[:60]}; a frequency "
            "above 0 in rad/s and a share from 0 to 1 that passes there are needed, such as "
            '{"frequency": 9.3, "passed": 0.2}, or leave the member out'
        )


def _positive(value: Any) -> bool:
    return _number(value) and value > 0


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _compare_previous(expected: Mapping[str, Any], file: Mapping[str, Any], path: Path) -> None:
    """Refuse a file whose limits, equilibria, ranges, units or formulas are not the model's."""
    for key, value in expected.items():
        if key not in file:
            continue
        stated = file[key]
        for difference in differences_between(stated, _like(stated, value), (key,)):
            there, ours = shown(difference)
            raise CertificateError(
                f"{path}: {difference.place} is {there} there, {ours} for this model: the file was "
                "written for another one; mend it, or design anew"
            )


def _determined(
    document: Mapping[str, Any], controller: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Return the contents of an older file that follow from model and law."""
    data = read_text(json.dumps(dict(document)), "certificate")
    law = data["gains"]
    words = read_text(json.dumps(controller or {}), "controller")
    filled = {"observer": {}, "start": None, "certificate": {}, **words}
    content = file_content(data["model"], law, filled)
    keys = ("states", "inputs", "formulas") if law["name"] == "pdc" else ("limits", "ramp")
    return {key: content[key] for key in keys if key in content}


def _like(stated: Any, expected: Any) -> Any:
    """Return the part of ``wanted`` with the keys of ``stated``: older files have fewer keys."""
    if isinstance(stated, dict) and isinstance(expected, dict):
        return {key: _like(stated[key], expected.get(key)) for key in stated}
    if isinstance(stated, list) and isinstance(expected, list) and len(stated) == len(expected):
        return [_like(s, w) for s, w in zip(stated, expected, strict=True)]
    return expected
