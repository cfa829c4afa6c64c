"""The part of docs/certificate.md that counts what a verdict ran through."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from takagi.certificates import certify
from takagi.certificates.audit.trusted_lines import Trusted, check_counted

PAGE = Path(__file__).parents[1] / "certificate.md"
FIRST, LAST = "<!-- trusted: made by `make docs` -->\n", "<!-- end trusted -->"
TURBINE = "a turbine: the first three claims of `takagi design nrel5mw`"
RUNNING = "a turbine: the fourth, `running-loop`"
STORED = PAGE.parent / "figures" / "nrel5mw-certificate.json"
DECAY = "one claim `decay` of a model of matrices"
ROOMS = ("replay", "kernel", "arithmetic", "loop", "kinds", "plant", "turbine")


def page() -> str:
    """Return docs/certificate.md with its numbers measured."""
    with tempfile.TemporaryDirectory() as folder:
        paths = {}
        for number, (name, document) in enumerate(certificates().items()):
            paths[name] = Path(folder) / f"{number}.json"
            paths[name].write_text(json.dumps(document), encoding="utf-8")
        return placed(PAGE.read_text(encoding="utf-8"), block(paths))


def placed(text: str, block: str) -> str:
    """Return the page with another block."""
    before, _, rest = text.partition(FIRST)
    _, _, after = rest.partition(LAST)
    return f"{before}{FIRST}{block}{LAST}{after}"


def block(paths: Mapping[str, Path]) -> str:
    """Return the table for certificates that are proved, by name."""
    head = ["certificate", "files", "lines of code", *(f"{room}/" for room in ROOMS), "words/"]
    rows = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for name, path in paths.items():
        checked, trusted = check_counted(path)
        assert checked.verdict.name == "PROVED", name
        rows.append(row(name, trusted))
    return "\n".join(rows) + "\n"


def row(name: str, trusted: Trusted) -> str:
    """Return one row of the table."""
    rooms = [
        sum(file.lines for file in trusted.files if file.path.startswith(f"{room}/"))
        for room in ROOMS
    ]
    words = sum(file.lines for file in trusted.words)
    cells = [name, len(trusted.files), trusted.lines, *rooms, words]
    return f"| {' | '.join(map(str, cells))} |"


def certificates() -> dict[str, Mapping[str, Any]]:
    """Return one certificate of each sort that the page names."""
    return {TURBINE: _turbine(), RUNNING: running(), DECAY: decay()}


def decay() -> Mapping[str, Any]:
    """Return the certificate of the pendulum in README.md."""
    from takagi.models import TSModel

    A = [[[0, 1], [17.3, 0]], [[0, 1], [9.4, 0]]]
    B = [[[0], [-0.18]], [[0], [-0.15]]]
    model = TSModel(A, B, states=["angle [rad]", "rate [rad/s]"], inputs=["force [N]"])
    return certify(model, gains=[[-150.0, -40.0]]).document


def running() -> Mapping[str, Any]:
    """Return the stored default certificate with its claim about the running loop alone."""
    from takagi.certificates.checker.kernel.reader import digest
    from takagi.certificates.document.certificate_file import as_read

    found = json.loads(STORED.read_text(encoding="utf-8"))
    claims = [claim for claim in found["claims"] if claim["kind"] == "running-loop"]
    hashes = {**found["provenance"]["sha256"], "claims": digest(as_read(claims))}
    return {**found, "claims": claims, "provenance": {"sha256": hashes}}


def _turbine() -> Mapping[str, Any]:
    """Return a certificate of the default turbine: gains found first, which takes seconds."""
    from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_candidate
    from takagi.certificates.claims.turbine.loop_claims import loop_document
    from takagi.lmi.turbine.effort import effort_gains
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.laws.effort_sharing.schedule import effort_schedule
    from takagi.models.turbine.loader import nrel5mw

    turbine = nrel5mw()
    schedule = effort_schedule(turbine)
    law = EffortSharingLaw.of(turbine, schedule, effort_gains(turbine, schedule).gains)
    return loop_document(turbine, law, effort_sharing_candidate(turbine, law), "documentation")
