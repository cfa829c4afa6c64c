"""The default design of the NREL 5-MW turbine, without the search that takes half of its time.

That search is for the cells of the claim ``running-loop``.  They are recorded in
``turbine_design_cells.json``, and this design states them where its own search would have found
them: they are proved for its law, as all claims of a design are.  Where the claim is not proved,
because the law is another by now, the cells are sought.

``python -m tests.turbine_designs`` records the cells of today.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

from takagi.certificates import DesignSettings, TurbineDesign, design_turbine
from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.running_loop.running_claim import StatedCell
from takagi.certificates.claims.turbine import running_loop_claim
from takagi.models import nrel5mw
from takagi.models.turbine.loader import model_files

RECORDED = Path(__file__).with_name("turbine_design_cells.json")


def searched_design() -> TurbineDesign:
    """Return the design as ``takagi design nrel5mw --two-step`` makes it."""
    asked = DesignSettings(synthesis="two-step")
    return design_turbine(nrel5mw(), asked, files=model_files("nrel5mw"))


def design_with_recorded_cells() -> TurbineDesign:
    """Return the same design, with the recorded cells of its running loop if they are proved."""
    with recorded_cells_for_sought():
        found = searched_design()
    return found if running_loop(found) is not None else searched_design()


@contextmanager
def recorded_cells_for_sought() -> Iterator[None]:
    """Let the claim of the running loop state the recorded cells, whatever its law."""
    with patch.object(running_loop_claim, "cells_over_winds", recorded_cells):
        yield


def running_loop(design: TurbineDesign) -> Any:
    """Return the claim of this kind as plain data, or None."""
    claims = design.document["claims"]
    return next((claim for claim in claims if claim["kind"] == "running-loop"), None)


def recorded_cells(_: object) -> Iterator[StatedCell]:
    """Yield the recorded cells, as the search yields those that it finds."""
    for cell in read_text(RECORDED.read_text(encoding="utf-8"), RECORDED.name)["cells"]:
        yield StatedCell.read(cell, len(cell["P"]), RECORDED.name)


def recorded_rows() -> list[dict[str, Any]]:
    """Return the recorded cells as a claim states them."""
    return list(json.loads(RECORDED.read_text(encoding="utf-8"))["cells"])


def main() -> None:
    """Record the cells of today."""
    rows = [json.dumps(cell) for cell in running_loop(searched_design())["cells"]]
    text = '{"cells": [\n' + ",\n".join(rows) + "\n]}\n"
    RECORDED.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
