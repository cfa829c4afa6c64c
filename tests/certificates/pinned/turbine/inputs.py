"""What the pinned numbers are of: a turbine, laws and claims of one wind cell each, as recorded.

``inputs.json`` holds the 5-MW turbine, the laws ``coherent``, ``paper`` and
``paper-two-integrators``, and claims about them, as ``takagi design`` made them once: for the
effort-sharing law three cells, below rated wind, at it and above it.  They are inputs; that newer
designs have other numbers changes nothing here.
"""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel.reader import digest

INPUTS = Path(__file__).with_name("inputs.json")
CELLS = ("torque", "rated", "pitch")
Document = dict[str, Any]
_INPUTS: Document = json.loads(INPUTS.read_text(encoding="utf-8"))


def document(name: str, *kinds: str) -> Document:
    """Return a recorded certificate with its claims of these kinds, or all; its own to change."""
    found = deepcopy(_INPUTS["certificates"][name])
    claims = [claim for claim in found["claims"] if not kinds or claim["kind"] in kinds]
    return sealed(
        {"model": deepcopy(_INPUTS["turbine"]), "gains": found["gains"], "claims": claims}
    )


def sealed(parts: Document) -> Document:
    """Return a certificate with the hashes of its parts."""
    whole = {"format": "takagi-certificate", "version": 1, **parts}
    read = read_text(json.dumps(whole), "certificate")
    hashes = {part: digest(read.get(part)) for part in ("model", "gains", "claims")}
    return whole | {"provenance": {"sha256": hashes}}


def as_read(data: Document) -> Document:
    """Return a certificate as the checker reads it, its numbers as they are written."""
    found: Document = read_text(json.dumps(data), "certificate")
    return found


_READ = {
    name: as_read({"model": _INPUTS["turbine"], **parts})
    for name, parts in _INPUTS["certificates"].items()
}


def read(name: str) -> Document:
    """Return a recorded certificate as the checker reads it; the same one at every call."""
    return _READ[name]
