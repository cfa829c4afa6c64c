"""The results of a check in the formats of continuous integration: JUnit, SARIF and Markdown.

The standard library alone, since `takagi check` writes them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from enum import Enum
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias
from urllib.parse import quote
from xml.sax.saxutils import escape, quoteattr

from takagi.certificates.checker.kernel.result import Checked, Claim
from takagi.certificates.checker.words.figure import Figure, Figures

if TYPE_CHECKING:
    from takagi.reports.sections.plant.summary import SummaryRow

_SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
# Kind of claim -> the sections of a plant's file that it follows from, the first that is there.
_SECTIONS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("input-limits",), ("inputs",)),
    **dict.fromkeys(("l2-gain", "peak", "h2-norm", "exit-probability"), ("disturbances",)),
    **dict.fromkeys(("observer", "observed-loop"), ("outputs",)),
    **dict.fromkeys(("invariant-ellipsoid",), ("states",)),
    "sector-embedding": ("equations",),
    "tracking": ("reference",),
}


class _Failure(Enum):
    REFUSED = "A file cannot be read, or is not about what the certificate is about."
    FAILED = "The claims may be proved; something else that was asked is missed."


class _Failed(NamedTuple):
    """What else was asked, as a claim."""

    name: str
    verdict: Enum
    text: str
    assumes: tuple[str, ...] = ()
    figures: Figures = ()


CheckedClaim: TypeAlias = Claim | _Failed


class _File(NamedTuple):
    """The checker's answer with failures, or a refusal."""

    verdict: Enum
    claims: tuple[CheckedClaim, ...]
    messages: tuple[str, ...] = ()
    assumes: tuple[str, ...] = ()


CheckedFile: TypeAlias = Checked | _File


def refusal(reason: str, *, needed: str = "the file is a certificate") -> CheckedFile:
    """Return the result for a file that the checker refuses: one failed claim.

    ``needed`` is the failed requirement, used as the name of the claim.
    """
    claim = _Failed(needed, _Failure.REFUSED, reason)
    return _File(_Failure.REFUSED, (claim,))


def with_failures(
    checked: CheckedFile, unmet: Sequence[tuple[str, str]], lines: Sequence[str] = ()
) -> CheckedFile:
    """Return a result with all its claims, and behind them what else was asked and is missed.

    A failed requirement stands in the list like a claim, so that every format shows both.  A
    verdict that was PROVED is FAILED then.

    Parameters
    ----------
    unmet : (requirement, reason) of each.
    lines : messages that are added.
    """
    failed = (_Failed(name, _Failure.FAILED, reason) for name, reason in unmet)
    proved = checked.verdict.name == "PROVED"
    return _File(
        _Failure.FAILED if unmet and proved else checked.verdict,
        (*checked.claims, *failed),
        (*checked.messages, *lines),
        tuple(checked.assumes),
    )


def junit(checked: CheckedFile, *, source: str, summary: Sequence[SummaryRow] = ()) -> str:
    """Return JUnit XML: one test case a claim; what is not PROVED is a failure.

    The figures of a claim become properties of its case.

    Parameters
    ----------
    source : the certificate's path.
    summary : of the design, if there is one; its numbers become properties of the suite.
    """
    cases = [_junit_case(name, claim, source) for name, claim in _named(checked)]
    failures = sum(not _proved(claim) for claim in checked.claims)
    counts = f'tests="{len(cases)}" failures="{failures}" errors="0"'
    messages = "\n".join([*_assumed(checked), *checked.messages])
    items = [item for row in summary for item in _row_properties(row)]
    properties = [f"      <property name={_attribute(k)} value={_attribute(v)}/>" for k, v in items]
    if items:
        properties = ["    <properties>", *properties, "    </properties>"]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<testsuites name="takagi check" {counts}>',
        f"  <testsuite name={_attribute(source)} {counts}>",
        *properties,
        *cases,
        f"    <system-out>{_text(messages)}</system-out>",
        "  </testsuite>",
        "</testsuites>",
    ]
    return "\n".join(lines) + "\n"


def sarif(
    checked: CheckedFile, *, source: str, kinds: Sequence[str] = (), plant: Path | None = None
) -> str:
    """Return SARIF 2.1.0: a rule a kind of claim, a result for what is not PROVED; UNDECIDED warns.

    SARIF viewers show every result as a finding, even of kind ``pass``. So a proved claim is a rule
    without a result.

    Parameters
    ----------
    source : the certificate's path, as it shall appear in the results.
    kinds : of the claims, in their order: the rules.  What was asked besides is a rule by its name.
    plant : the plant's file: a result marks the line there that the claim follows from, as far as
        the kind tells; None marks the certificate.
    """
    named = _named(checked)
    words = (re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") for name, _ in named[len(kinds) :])
    identifiers = [*kinds[: len(named)], *words]
    rules = list(dict.fromkeys(identifiers))
    driver: dict[str, object] = {
        "name": "takagi",
        "version": version("takagi"),
        "rules": [
            {"id": identifier, "shortDescription": {"text": identifier.replace("-", " ")}}
            for identifier in rules
        ],
    }
    if assumed := {name: list(claim.assumes) for name, claim in named if claim.assumes}:
        driver["properties"] = {"assumes": assumed}
    lines = plant.read_text(encoding="utf-8", errors="replace").splitlines() if plant else []
    artifact = {"uri": quote(str(plant or source).replace("\\", "/"))}
    results = [
        {
            "ruleId": rule,
            "ruleIndex": rules.index(rule),
            "kind": "fail",
            "level": "warning" if claim.verdict.name == "UNDECIDED" else "error",
            "message": {"text": f"{claim.verdict.name}: {name}: {claim.text}"},
            # Viewers that mark lines need a region; a certificate is marked at its first line.
            "locations": [
                {
                    "physicalLocation": {
                        "artifactLocation": artifact,
                        "region": {"startLine": _line(lines, rule)},
                    }
                }
            ],
            "partialFingerprints": {"claim/v1": name},
        }
        for rule, (name, claim) in zip(identifiers, named, strict=True)
        if not _proved(claim)
    ]
    run = {"tool": {"driver": driver}, "results": results}
    return json.dumps({"$schema": _SARIF_SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2)


def _line(lines: Sequence[str], rule: str) -> int:
    """Return the line of the first section that is there, from 1; the first line for none."""
    for section in (*_SECTIONS.get(rule, ()), "design", "equations"):
        for number, line in enumerate(lines, 1):
            if re.match(rf"\s*\[{section}[].]", line):
                return number
    return 1


def markdown(checked: CheckedFile, *, source: str, summary: Sequence[SummaryRow] = ()) -> str:
    """Return the verdict, a table of the claims, and the checker's messages as Markdown.

    The figures of a claim stand in a column of their own.

    Parameters
    ----------
    source : the certificate's path.
    summary : of the design, if there is one; it stands in a table before the claims.
    """
    lines = [f"## {markdown_cell(source)}: {checked.verdict.name}", ""]
    if summary:
        lines += ["| | Figures | Rests on | Less than stated |", "|---|---|---|---|"]
        for row in summary:
            cells = (row.name, row.text, _rests_on(row), row.shortfall if row.partial else "")
            lines.append(f"| {' | '.join(map(markdown_cell, cells))} |")
        lines.append("")
    lines += ["| Verdict | Claim | | Numbers |", "|---|---|---|---|"]
    for name, claim in _named(checked):
        listed = ", ".join(f"{quantity} {number}" for quantity, number in numbers_of(claim).items())
        cells = (claim.verdict.name, name, claim.text, listed)
        lines.append(f"| {' | '.join(map(markdown_cell, cells))} |")
    messages = [*_assumed(checked), *checked.messages]
    if messages:
        lines += ["", *(f"- {markdown_cell(line)}" for line in messages)]
    return "\n".join(lines) + "\n"


def _assumed(checked: CheckedFile) -> list[str]:
    """Return a line for each claim that assumes anything: its own assumptions."""
    return [
        f"{name} assumes: {'; '.join(claim.assumes)}"
        for name, claim in _named(checked)
        if claim.assumes
    ]


def _named(checked: CheckedFile) -> list[tuple[str, CheckedClaim]]:
    """Return the claims under unique names, because viewers merge equal names."""
    by_name: dict[str, CheckedClaim] = {}
    for claim in checked.claims:
        name, k = claim.name, 1
        while name in by_name:
            k += 1
            name = f"{claim.name} ({k})"
        by_name[name] = claim
    return list(by_name.items())


def numbers_of(claim: CheckedClaim) -> dict[str, str]:
    """Return the figures of a claim, such as ``{"decay rate [1/s]": "3.38"}``.

    Bounds are rounded so that they hold.  A claim that is not proved has none.
    """
    # Imported here: most formats show no number.
    from takagi.certificates.checker.words.rounded import at_least, at_most

    return {
        f"{f.name} [{f.unit}]" if f.unit else f.name: (at_least if f.larger else at_most)(
            f.value, 3
        )
        for f in claim.figures
        # A bound of 0 says nothing; a profile depends on the wind.
        if isinstance(f, Figure) and f.value
    }


def _proved(claim: CheckedClaim) -> bool:
    return claim.verdict.name == "PROVED"


def _junit_case(name: str, claim: CheckedClaim, source: str) -> str:
    head = f"    <testcase classname={_attribute(source)} name={_attribute(name)}"
    if _proved(claim):
        listed = "".join(
            f"<property name={_attribute(quantity)} value={_attribute(number)}/>"
            for quantity, number in numbers_of(claim).items()
        )
        return f"{head}><properties>{listed}</properties></testcase>" if listed else f"{head}/>"
    verdict = quoteattr(claim.verdict.name)
    return (
        f"{head}>\n      <failure type={verdict} message={verdict}>{_text(claim.text)}</failure>\n"
        "    </testcase>"
    )


def _row_properties(row: SummaryRow) -> list[tuple[str, str]]:
    """Return (name, value) of each number of a row, of its share, and what they rest on."""
    items = []
    for number in row.numbers:
        name = f"{row.name}: {number.quantity}"
        items.append((f"{name} [{number.unit}]" if number.unit else name, f"{number.value}"))
        if number.share is not None:
            items.append((f"{name}, share of what is stated", f"{number.share}"))
    return [*items, (f"{row.name}: rests on", _rests_on(row))] if items else []


def _rests_on(row: SummaryRow) -> str:
    return row.basis or f"proved{f': {row.claim}' if row.claim else ''}"


def markdown_cell(text: str) -> str:
    """Return a text as one line that is safe in a cell of a Markdown table."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def _text(text: str) -> str:
    return escape(_printable(text))


def _attribute(text: str) -> str:
    return quoteattr(_printable(text))


def _printable(text: str) -> str:
    # XML 1.0 cannot represent most control characters.
    return "".join(c if c >= " " or c in "\t\n\r" else "\ufffd" for c in text)
