"""Turbines, laws, plants and their files, recorded once: what tests of single answers begin with.

``turbine_laws.json`` holds the 5-MW turbine, the laws ``torque``, ``rated`` and ``pitch`` (one wind
cell each of the effort-sharing law) and ``paper``, and claims about them, as ``takagi design`` made
them.  ``model_files.json`` holds three plants (a cart with tables and a mass matrix, a plant with a
sample time, one with a blend) and two turbines, each as its files and as its certificate has it.
They are inputs: newer designs have other numbers.
"""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

from tests.certificates.kinds.claims import as_read, resealed

Document = dict[str, Any]


def _recorded(name: str) -> Document:
    found: Document = json.loads(Path(__file__).with_name(name).read_text(encoding="utf-8"))
    return found


_LAWS, _FILES = _recorded("turbine_laws.json"), _recorded("model_files.json")
LAWS = tuple(_LAWS["certificates"])


def document(law: str, *kinds: str) -> Document:
    """Return a recorded certificate with its claims of these kinds, or all; its own to change."""
    found = deepcopy(_LAWS["certificates"][law])
    claims = [claim for claim in found["claims"] if not kinds or claim["kind"] in kinds]
    return sealed({"model": deepcopy(_LAWS["turbine"]), "gains": found["gains"], "claims": claims})


def sealed(parts: Document) -> Document:
    return resealed({"format": "takagi-certificate", "version": 1, **parts})


def read_law(name: str) -> Document:
    return dict(as_read({"model": _LAWS["turbine"], **_LAWS["certificates"][name]}))


def texts_of(model: str) -> dict[str, str]:
    return dict(_FILES[model]["files"])


def of_model(name: str) -> Document:
    found = {key: deepcopy(part) for key, part in _FILES[name].items() if key != "files"}
    found["provenance"] = {"sha256": {"model": "m", "gains": "g", "claims": "c"}}
    return dict(as_read(found))
