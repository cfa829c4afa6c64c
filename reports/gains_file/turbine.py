r"""The gain file ``gains.json``: everything a controller needs, and what is proved about it.

``law`` is, number by number, the object inside the certificate, and every other member follows
from the certificate, so that ``takagi check certificate.json --gains gains.json`` compares the
whole file.  What is proved is about these decimals.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from takagi.certificates.controller.content import gain_file_of
from takagi.reports.gains_file.schema import GainFile, gain_file_schema

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.design import TurbineDesign

__all__ = ["dump_gains", "gain_file", "gain_file_schema"]

# Members whose entries stand on lines of their own.
LISTED = ("language", "programs", "states", "inputs")


def gain_file(design: TurbineDesign) -> dict[str, Any]:
    """Return the content of ``gains.json`` as plain data, checked against its schema.

    ``law`` is ``design.document["gains"]`` itself; every other number is written as it is used.

    Raises
    ------
    pydantic.ValidationError : a law whose tables do not fit each other.
    """
    found = gain_file_of(design.document)
    GainFile.model_validate(found)
    return found


def dump_gains(content: dict[str, Any]) -> str:
    """Return the file's text: a line for each step, the same bytes for the same numbers."""
    body = ",\n".join(f"{json.dumps(key)}: {_text(key, value)}" for key, value in content.items())
    return f"{{\n{body}\n}}\n"


def _text(key: str, value: Any) -> str:
    if key not in LISTED:
        return json.dumps(value, allow_nan=False)
    return _lines(value, 2 if key == "programs" else 0)


def _lines(value: Any, depth: int, indent: str = "  ") -> str:
    """Return a value with its entries on lines of their own, to some depth."""
    inner = [json.dumps(part, allow_nan=False) for part in value]
    if depth and isinstance(value, dict | list):
        parts = value.values() if isinstance(value, dict) else value
        inner = [
            _lines(part, depth - 1, indent + "  ") if isinstance(part, dict | list) and part
            else json.dumps(part, allow_nan=False)
            for part in parts
        ]  # fmt: skip
    elif isinstance(value, dict):
        inner = [json.dumps(part, allow_nan=False) for part in value.values()]
    if isinstance(value, dict):
        inner = [f"{json.dumps(k)}: {text}" for k, text in zip(value, inner, strict=True)]
    ends = "{}" if isinstance(value, dict) else "[]"
    return f"{ends[0]}\n{indent}" + f",\n{indent}".join(inner) + f"\n{indent[2:]}{ends[1]}"
