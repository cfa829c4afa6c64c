"""The JSON Schemas (draft 2020-12) of gain files and certificates: docs/schemas/.

A name has the version of the format; the schema of an earlier version stays beside the new one.
The plant file's is docs/plant.schema.json.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields
from typing import Any

from takagi.certificates.checker.controller.content import VERSION as GAINS_VERSION
from takagi.certificates.checker.replay import claim_kinds
from takagi.certificates.checker.replay.certificate import FORMAT, VERSION
from takagi.reports.gains_file.envelope import gain_file_schema, plant_gain_file_schema

NUMBER = {"type": "number"}
ROW = {"type": "array", "items": NUMBER}
MATRIX = {"type": "array", "items": ROW}
DIGEST = {"type": "string", "pattern": "^[0-9a-f]{64}$"}


def certificate_schema() -> dict[str, Any]:
    """Return the schema of certificates; of claims about a loop it has the members too.

    The checker is stricter: it knows every shape, and compares the hashes.
    """
    kinds = sorted(claim_kinds.READ)
    claim: dict[str, Any] = {
        "type": "object",
        "required": ["kind", "name"],
        "properties": {"kind": {"enum": kinds}, "name": {"type": "string"}},
        "allOf": [_kind(kind) for kind in sorted(claim_kinds.KINDS)],
    }
    hashes = {name: DIGEST for name in ("model", "gains", "claims", "controller")}
    provenance = {
        "type": "object",
        "required": ["sha256"],
        "properties": {"sha256": {"type": "object", "properties": hashes}},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "takagi certificate",
        "type": "object",
        "required": ["format", "version", "model", "gains", "claims", "provenance"],
        "properties": {
            "format": {"const": FORMAT},
            "version": {"const": VERSION},
            "model": {"type": "object"},
            "gains": {"type": ["object", "null"]},
            "controller": {"type": "object"},
            "claims": {"type": "array", "minItems": 1, "items": claim},
            "provenance": provenance,
        },
    }


def _kind(kind: str) -> dict[str, Any]:
    """Return what a claim of this kind has: its numbers with their units, and its matrices."""
    cls = claim_kinds.class_of(kind)
    members = {f.name: _member(f) for f in fields(cls) if "read" in f.metadata}
    return {
        "if": {"properties": {"kind": {"const": kind}}},
        "then": {
            "description": (cls.__doc__ or "").split("\n")[0].replace("; see the module", ""),
            "properties": members,
        },
    }


def _member(field: Any) -> dict[str, Any]:
    kind = str(field.type)
    shape = MATRIX if kind == "Matrix" else ROW if kind.startswith("list") else NUMBER
    unit = field.metadata.get("unit")
    return {**shape, "description": f"[{unit}]"} if unit else shape


def _text(schema: Callable[[], dict[str, Any]]) -> Callable[[], str]:
    return lambda: json.dumps(schema(), indent=1) + "\n"


# Path below docs/ -> what makes the text.
SCHEMAS = {
    f"schemas/gains-plant-{GAINS_VERSION}.schema.json": _text(plant_gain_file_schema),
    f"schemas/gains-outputs-{GAINS_VERSION}.schema.json": _text(
        lambda: plant_gain_file_schema(outputs=True)
    ),
    f"schemas/gains-turbine-{GAINS_VERSION}.schema.json": _text(gain_file_schema),
    f"schemas/certificate-{VERSION}.schema.json": _text(certificate_schema),
}
