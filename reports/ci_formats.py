"""The results of a check in the formats of continuous integration: JUnit, SARIF and Markdown.

The standard library alone, since `takagi check` writes them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple, Protocol
from urllib.parse import quote
from xml.sax.saxutils import escape, quoteattr

__all__ = ["Checked", "CheckedClaim", "junit", "markdown", "refusal", "sarif"]

_SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


class CheckedClaim(Protocol):
    """A claim, and what the checker found."""

    @property
    def name(self) -> str: ...
    @property
    def verdict(self) -> Enum: ...
    @property
    def text(self) -> str: ...


class Checked(Protocol):
    """What the checker says about a file."""

    @property
    def verdict(self) -> Enum: ...
    @property
    def claims(self) -> Sequence[CheckedClaim]: ...
    @property
    def messages(self) -> Sequence[str]: ...


class _Refusal(Enum):
    REFUSED = "The file is no certificate that can be checked."


class _RefusedClaim(NamedTuple):
    name: str
    verdict: Enum
    text: str


class _RefusedFile(NamedTuple):
    verdict: Enum
    claims: tuple[_RefusedClaim, ...]
    messages: tuple[str, ...]


def refusal(reason: str) -> Checked:
    """Return the result for a file that the checker refuses to read: one claim, not met."""
    claim = _RefusedClaim("the file is a certificate", _Refusal.REFUSED, reason)
    return _RefusedFile(_Refusal.REFUSED, (claim,), ())


def junit(checked: Checked, *, source: str) -> str:
    """Return JUnit XML: one test case a claim; what is not PROVED is a failure.

    ``source`` is the certificate's path.
    """
    cases = [_junit_case(claim, source) for claim in checked.claims]
    failures = sum(not _proved(claim) for claim in checked.claims)
    counts = f'tests="{len(cases)}" failures="{failures}" errors="0"'
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<testsuites name="takagi check" {counts}>',
        f"  <testsuite name={_attribute(source)} {counts}>",
        *cases,
        f"    <system-out>{_text(chr(10).join(checked.messages))}</system-out>",
        "  </testsuite>",
        "</testsuites>",
    ]
    return "\n".join(lines) + "\n"


def sarif(checked: Checked, *, source: str) -> str:
    """Return SARIF 2.1.0: one rule a claim; PROVED passes, UNDECIDED warns, the rest are errors.

    ``source`` is the certificate's path, as it shall appear in the results.
    """
    rules = [
        {"id": claim.name, "shortDescription": {"text": claim.text}} for claim in checked.claims
    ]
    driver = {"name": "takagi", "rules": rules}
    results = [
        {
            "ruleId": claim.name,
            "ruleIndex": index,
            "kind": "pass" if _proved(claim) else "fail",
            "level": _level(claim),
            "message": {"text": f"{claim.verdict.name}: {claim.text}"},
            "locations": [_location(source)],
        }
        for index, claim in enumerate(checked.claims)
    ]
    run = {"tool": {"driver": driver}, "results": results}
    return json.dumps({"$schema": _SARIF_SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2)


def markdown(checked: Checked, *, source: str) -> str:
    """Return a Markdown summary: the verdict, a table of the claims, the checker's messages."""
    lines = [
        f"## {_cell(source)}: {checked.verdict.name}",
        "",
        "| Verdict | Claim | |",
        "|---|---|---|",
    ]
    lines += [
        f"| {claim.verdict.name} | {_cell(claim.name)} | {_cell(claim.text)} |"
        for claim in checked.claims
    ]
    if checked.messages:
        lines += ["", *(f"- {_cell(message)}" for message in checked.messages)]
    return "\n".join(lines) + "\n"


def _proved(claim: CheckedClaim) -> bool:
    return claim.verdict.name == "PROVED"


def _level(claim: CheckedClaim) -> str:
    return {"PROVED": "none", "UNDECIDED": "warning"}.get(claim.verdict.name, "error")


def _junit_case(claim: CheckedClaim, source: str) -> str:
    head = f"    <testcase classname={_attribute(source)} name={_attribute(claim.name)}"
    if _proved(claim):
        return f"{head}/>"
    verdict = quoteattr(claim.verdict.name)
    return (
        f"{head}>\n      <failure type={verdict} message={verdict}>{_text(claim.text)}</failure>\n"
        "    </testcase>"
    )


def _location(source: str) -> dict[str, object]:
    # A reader that marks lines needs a region; a certificate is one statement, from its first.
    artifact = {"uri": quote(source.replace("\\", "/"))}
    return {"physicalLocation": {"artifactLocation": artifact, "region": {"startLine": 1}}}


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def _text(text: str) -> str:
    return escape(_printable(text))


def _attribute(text: str) -> str:
    return quoteattr(_printable(text))


def _printable(text: str) -> str:
    # XML 1.0 has no way at all to write most control characters.
    return "".join(c if c >= " " or c in "\t\n\r" else "\ufffd" for c in text)
