"""The contents of a gain file: from a certificate, and bound to a file of gains that were given.

A file of the current version keeps its texts, observer gains, trim table and the data about its own
certificate. Programs, limits, ranges and units are computed from the certified model. If they
differ from the file, ``takagi check --gains`` will refuse it, and ``told`` reports this beforehand.
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
from takagi.certificates.checker.files.differences import differences_between, shown
from takagi.certificates.checker.files.gain_file import expected_file, left_out
from takagi.certificates.checker.kernel.reader import Number, digest, read_json, read_text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.document.certificate_file import as_read

# The first members of the file; the others keep their order.
ORDER = ("format", "version", "name", "turbine", "plant", "units", "law", "states", "inputs")
LAST = ("language", "programs", "rotor", "tables", "certificate")


def bound(document: Mapping[str, Any], controller: Mapping[str, Any]) -> dict[str, Any]:
    """Return the certificate with the other members of its gain file, and their hash."""
    provenance = document["provenance"]
    hashes = {**provenance["sha256"], "controller": digest(as_read(controller))}
    return {**document, "controller": controller, "provenance": {**provenance, "sha256": hashes}}


def gain_file_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``gains.json`` for a certificate with a ``controller``.

    ``certificate.sha256`` holds the certificate's hashes of model, law, claims and controller.
    """
    own = document["controller"]
    found = plain(file_content(document["model"], document["gains"], own))
    found["certificate"]["sha256"] = dict(document["provenance"]["sha256"])
    middle = [key for key in found if key not in (*ORDER, *LAST)]
    return {key: found[key] for key in (*ORDER, *middle, *LAST) if key in found}


def plain(value: Any) -> Any:
    """Return the value with numbers of the strict reader as JSON has them."""
    if isinstance(value, Number):
        whole = value.lstrip("-").isdigit()
        return int(value) if whole else float(value)
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


# Members that model and law do not determine; they are taken from the file.
FREE = ("name", "turbine", "plant", "notes", "trim", "start", "observer", "measurement",
        "certificate")  # fmt: skip
NEEDED = ("trim", "observer")  # of a turbine's file
MOST = 3


def bound_to_file(
    document: Mapping[str, Any], path: Path, own: Mapping[str, Any] | None = None
) -> Mapping[str, Any]:
    """Return the certificate bound to a gain file; unchanged if the file contains only a law.

    Parameters
    ----------
    own : the ``controller`` of the certificate where it has one that was made anew.

    Raises
    ------
    CertificateError : the file cannot be read, or is of an earlier version and differs from the
        model.
    """
    file = read_json(path)
    beside = {key: plain(value) for key, value in file.items() if key not in ("format", "law")}
    if not beside:
        return document if own is None else bound(document, own)
    if str(file.get("version")) == str(VERSION):
        if own is not None and "sampling" not in file:
            # A file of before: its program does not hold estimates in the box.
            own = {key: value for key, value in own.items() if key != "sampling"}
        return _of_today(document, beside, own)
    _compare_previous(document, file, own, path)
    return bound(document, {"version": beside.get("version"), **beside})


def refreshed(
    document: Mapping[str, Any], path: Path, own: Mapping[str, Any], statement: Mapping[str, Any]
) -> tuple[Mapping[str, Any], dict[str, Any]]:
    """Return the certificate bound to the gain file written anew, and the content of that file.

    Raises
    ------
    CertificateError : the file cannot be read, or lacks what does not follow from the model.
    """
    file = {key: plain(value) for key, value in read_json(path).items()}
    kept = {key: file[key] for key in FREE if key in file} | {"certificate": statement}
    found = _of_today(document, kept, own)
    if "controller" not in found:
        raise CertificateError(
            f"{path}: it has no {' and no '.join(k for k in NEEDED if k not in file)}, so no whole "
            "gain file can be written; give the gains.json of a design, or design anew"
        )
    return found, gain_file_of(found)


def told(document: Mapping[str, Any], path: Path) -> str:
    """Return the fields in which a gain file differs from that of a certificate, or leaves out."""
    data, file = read_text(json.dumps(document), "certificate"), read_json(path)
    expected = expected_file(data) if "controller" in data else {}
    compared = file if expected else {}
    wanted = {key: expected.get(key) for key in compared}
    found = [
        f"{one.place} is {there} there, {ours} for this model"
        for one in islice(differences_between(compared, wanted), MOST)
        for there, ours in [shown(one)]
    ] or left_out(file, expected, data)
    if not found:
        return ""
    return (
        f"{path}: 'takagi check --gains' will refuse it beside this certificate: "
        f"{'; '.join(found)}. --gains-out FILE writes it anew for this model, with the same law"
    )


def _of_today(
    document: Mapping[str, Any], file: Mapping[str, Any], own: Mapping[str, Any] | None
) -> Mapping[str, Any]:
    found = {**(own or {}), **{key: file[key] for key in FREE if key in file}}
    if document["gains"]["name"] != "pdc":
        if "sampling" in file:
            found["sampling"] = file["sampling"]
        if not all(isinstance(found.get(key), Mapping) for key in NEEDED):
            return document
        _require_measurement(found.get("measurement"))
        observer = {key: v for key, v in found["observer"].items() if key != "equations"}
        found |= {"observer": observer, "states": file.get("states", [])}
    found.setdefault("certificate", {})
    return bound(document, found)


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


def _compare_previous(
    document: Mapping[str, Any], file: Mapping[str, Any], own: Mapping[str, Any] | None, path: Path
) -> None:
    """Refuse a file whose limits, equilibria, ranges, units or formulas are not the model's."""
    data = read_text(json.dumps(dict(document)), "certificate")
    wanted = _known(data, own)
    for key, value in wanted.items():
        if key not in file:
            continue
        stated = file[key]
        for one in differences_between(stated, _like(stated, value), (key,)):
            there, ours = shown(one)
            raise CertificateError(
                f"{path}: {one.place} is {there} there, {ours} for this model: the file was "
                "written for another one; mend it, or design anew"
            )


def _known(data: Mapping[str, Any], own: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the contents of an older file that follow from model and law."""
    law = data["gains"]
    words = read_text(json.dumps(own or {}), "controller")
    filled = {"observer": {}, "start": None, "certificate": {}, **words}
    whole = file_content(data["model"], law, filled)
    keys = ("states", "inputs", "formulas") if law["name"] == "pdc" else ("limits", "ramp")
    return {key: whole[key] for key in keys if key in whole}


def _like(stated: Any, wanted: Any) -> Any:
    """Return the part of ``wanted`` with the keys of ``stated``: older files have fewer keys."""
    if isinstance(stated, dict) and isinstance(wanted, dict):
        return {key: _like(stated[key], wanted.get(key)) for key in stated}
    if isinstance(stated, list) and isinstance(wanted, list) and len(stated) == len(wanted):
        return [_like(s, w) for s, w in zip(stated, wanted, strict=True)]
    return wanted
