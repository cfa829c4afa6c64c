"""Sections and tables that both reports have: premises, margins, checking, provenance."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.margins.margins import Margins
from takagi.reports.page.text import Section, Table, decimal, significant, table, with_decimals

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.ts.model import TSModel


def premise_table(model: TSModel, caption: str, evidence: str) -> Table:
    """Return the premises of a model with their proved ranges.

    ``evidence`` is the heading of the last column, which says how a range was bounded.
    """
    rows = ((p.name, decimal(float(p.lower)), decimal(float(p.upper)), p.unit, p.evidence)
            for p in model.premises)  # fmt: skip
    return table("premises", rows, premises=caption, evidence=evidence)


def margin_table(rows: Iterable[tuple[tuple[str, ...], Margins]], *, folded_from: int) -> Table:
    """Return a table of the margins of (place, loop); folded with more than so many rows."""
    table_rows = [(*head, *_cells(margins)) for head, margins in rows]
    return table("margins", table_rows, folded=len(table_rows) > folded_from)


def _cells(m: Margins) -> tuple[str, ...]:
    if not m.stable:
        return ("unstable",) * 8
    down = 20 * np.log10(m.gain_decrease) if m.gain_decrease > 0 else -np.inf
    return (
        significant(m.crossover),
        with_decimals(20 * np.log10(m.gain_increase), 1),
        with_decimals(down, 1),
        with_decimals(float(np.degrees(m.phase)), 0),
        significant(m.delay),
        with_decimals(20 * np.log10(m.disk.gain_increase), 1),
        with_decimals(float(np.degrees(m.disk.phase)), 0),
        with_decimals(m.sensitivity_peak, 2),
    )


def check_section(*, compared: str, law: bool = True, needs: str = "") -> Section:
    """Return the section that says how to check the certificate.

    compared : words (HTML) before "hash" that name the file whose hash is also compared.
    law : whether there is a gain file for the certificate.
    needs : a further remark on the checker (HTML).
    """
    return Section("check", "How to check it", {"compared": compared, "law": law, "needs": needs})


def provenance_section(design: TurbineDesign | PlantDesign) -> Section:
    """Return versions, hashes and configuration."""
    recorded = design.document["provenance"]
    files = recorded.get("files_sha256", {})
    hashes = [(f"certificate: {name}", value) for name, value in recorded["sha256"].items()]
    hashes += [(f"file: {name}", value) for name, value in files.items()]
    versions = tuple((name, str(value)) for name, value in recorded["versions"].items())
    return Section(
        "provenance",
        "Provenance",
        {
            "versions": table("versions", versions),
            "hashes": table("hashes", hashes),
            "solver": {k: words for k, words in recorded.get("solver", {}).items() if words},
            "configuration": json.dumps(recorded.get("configuration", {}), indent=1),
        },
    )
