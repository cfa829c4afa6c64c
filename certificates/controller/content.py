"""The gain file of a certificate as plain data, and a certificate that is bound to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.controller.content import file_content
from takagi.certificates.checker.kernel.reader import Number, digest
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
