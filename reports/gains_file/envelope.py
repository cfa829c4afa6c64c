"""What every gain file has in common: the entries that both bodies use, and the file's text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from takagi.certificates.controller.content import gain_file_of

Numbers: TypeAlias = list[float]

# Members whose entries stand on lines of their own.
LISTED = ("language", "programs", "states", "inputs")


class Strict(BaseModel):
    """Unknown fields are refused; numbers must be finite; nothing is converted."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class SplineEntry(Strict):
    """A cubic spline: a full row of knots for each argument, and the coefficients."""

    knots: list[Numbers] = Field(min_length=1, max_length=2)
    coefficients: list[Numbers] | Numbers


class ClaimEntry(Strict):
    """One claim of the certificate and what the checker says."""

    name: str
    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    text: str


class NameEntry(Strict):
    """The place of a name's value in the file."""

    value: str
    unit: str


class ReadEntry(Strict):
    """A signal that is read at every sample."""

    name: str
    unit: str
    meaning: str


class KeepEntry(Strict):
    """A value that is kept from one sample to the next."""

    name: str
    unit: str
    start: str
    next: str
    meaning: str


class NearEntry(Strict):
    """The polynomial that replaces a step's formula where |of| <= within."""

    of: str
    within: float = Field(ge=0)
    formula: str


class RemovableEntry(NearEntry):
    """The same for a premise, with the limit where it is 0/0."""

    limit: str


class StepEntry(Strict):
    """One assignment."""

    set: str
    unit: str
    formula: str
    meaning: str


class NearStepEntry(StepEntry):
    """One assignment with other formulas near some points."""

    near: list[RemovableEntry | NearEntry]


class SendEntry(Strict):
    """A signal that is sent at every sample."""

    name: str
    unit: str
    formula: str
    meaning: str


class ProgramEntry(Strict):
    """One sample of a part of the controller; ``language`` says how it is read."""

    name: str
    names: dict[str, NameEntry]
    read: list[ReadEntry]
    keep: list[KeepEntry]
    steps: list[NearStepEntry | StepEntry]
    send: list[SendEntry]


class CertificateEntry(Strict):
    """What the certificate beside this file says about the law."""

    verdict: Literal["PROVED", "DISPROVED", "UNDECIDED"]
    claims: list[ClaimEntry]
    sha256: dict[str, str]


class SamplingEntry(Strict):
    """The longest time from sample to sample, and why; None where none is known."""

    longest: float | None = Field(gt=0, description="[s]; exports refuse a longer one")
    reason: str


class Envelope(Strict):
    """The members of every gain file; a body adds its own."""

    format: Literal["takagi-gains"]
    version: Literal[3]
    name: str
    units: dict[str, str]
    language: dict[str, str]
    programs: list[ProgramEntry]
    sampling: SamplingEntry | None = Field(default=None, description="none in files of before")
    certificate: CertificateEntry


def validated(document: Mapping[str, Any], body: type[Envelope]) -> dict[str, Any]:
    """Return the gain file of a certificate as plain data, checked against a body's schema.

    ``law`` is the certificate's ``gains``, number by number.

    Raises pydantic.ValidationError : a law whose members do not fit.
    """
    content = gain_file_of(document)
    body.model_validate(content)
    return content


def file_schema(body: type[Envelope], title: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a gain file with this body."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **body.model_json_schema(),
        "title": title,
    }


def dump_gains(content: dict[str, Any]) -> str:
    """Return the file's text: a line for each step, the same bytes for the same numbers."""
    texts = {
        key: _lines(value, 2 if key == "programs" else 0)
        if key in LISTED
        else json.dumps(value, allow_nan=False)
        for key, value in content.items()
    }
    body = ",\n".join(f"{json.dumps(key)}: {text}" for key, text in texts.items())
    return f"{{\n{body}\n}}\n"


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
