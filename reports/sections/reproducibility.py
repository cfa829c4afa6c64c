"""The sections on checking the certificate, and on versions, hashes and settings."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from takagi.reports.page.text import Section, Table, with_decimals

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.certificates.design.turbine.result import TurbineDesign


def check_section(*, compared: str, law: bool = True, needs: str = "") -> Section:
    """Return the section that says how to check the certificate.

    Parameters
    ----------
    compared : words (HTML) before "hash" that name the file whose hash is also compared.
    law : whether there is a gain file for the certificate.
    needs : a further remark on the checker (HTML).
    """
    return Section("check", "How to check it", {"compared": compared, "law": law, "needs": needs})


def provenance_section(design: TurbineDesign | PlantDesign, *, timings: bool) -> Section:
    """Return versions, hashes, configuration and, with ``timings``, the time of each step."""
    recorded = design.document["provenance"]
    files = recorded.get("files_sha256", {})
    hashes = [(f"certificate: {name}", value) for name, value in recorded["sha256"].items()]
    hashes += [(f"file: {name}", value) for name, value in files.items()]
    versions = tuple((name, str(value)) for name, value in recorded["versions"].items())
    seconds = tuple((step, with_decimals(value, 2)) for step, value in design.seconds.items())
    return Section(
        "provenance",
        "Provenance",
        {
            "versions": Table("Versions", (("part", ""), ("version", "")), versions),
            "hashes": Table("SHA-256", (("of", ""), ("digest", "")), tuple(hashes)),
            "solver": recorded.get("solver", {}),
            "configuration": json.dumps(recorded.get("configuration", {}), indent=1),
            "timings": Table("Time per step", (("step", ""), ("time", "s")), seconds)
            if timings and seconds
            else None,
        },
    )
