"""The default design of the NREL 5-MW turbine, without the searches that take most of its time.

They are for the cells of the claim ``running-loop``, and for P of a loop that allows larger wind
errors.  Both are recorded in ``turbine_design_cells.json``, and this design states them where its
own searches would have found them: they are proved for its law, as all claims of a design are.
Where they are not, because the law is another by now, they are sought.

``python -m tests.turbine_designs`` records those of today.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np

from takagi.certificates import DesignSettings, TurbineDesign, design_turbine
from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.running_loop.running_claim import StatedCell
from takagi.certificates.claims.turbine import running_loop_claim
from takagi.certificates.design.turbine import effort_sharing_gains
from takagi.lmi.turbine.one_step.design import one_step_gains
from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains
from takagi.models import nrel5mw
from takagi.models.turbine.loader import model_files

RECORDED = Path(__file__).with_name("turbine_design_cells.json")


def searched_design() -> TurbineDesign:
    asked = DesignSettings(synthesis="two-step")
    return design_turbine(nrel5mw(), asked, files=model_files("nrel5mw"))


def design_with_recorded_cells() -> TurbineDesign:
    """Return the same design, with what is recorded of its loops if that is proved."""
    with (
        recorded_cells_for_sought(),
        patch.object(effort_sharing_gains, "one_step_gains", recorded_function),
    ):
        found = searched_design()
    holds = running_loop(found) is not None and has_recorded_function(found)
    return found if holds else searched_design()


def recorded_function(loop: LoopOfGains, *, steps: int, tell: object) -> Any:
    """Return the gains of the loop with the recorded P, in the place of an analysis of them."""
    assert steps == 0
    functions = SimpleNamespace(P=np.array(json.loads(RECORDED.read_text(encoding="utf-8"))["P"]))
    return SimpleNamespace(law=loop.law, functions=functions)


def has_recorded_function(design: TurbineDesign) -> bool:
    """Return whether the design's loop has the recorded P, up to the decimals of a certificate."""
    P = np.array(json.loads(RECORDED.read_text(encoding="utf-8"))["P"])
    return bool(np.allclose(design.document["claims"][0]["P"], P, rtol=1e-3, atol=0))


@contextmanager
def recorded_cells_for_sought() -> Iterator[None]:
    """Let the claim of the running loop state the recorded cells, whatever its law."""
    with patch.object(running_loop_claim, "cells_over_winds", recorded_cells):
        yield


def running_loop(design: TurbineDesign) -> Any:
    claims = design.document["claims"]
    return next((claim for claim in claims if claim["kind"] == "running-loop"), None)


def recorded_cells(_: object) -> Iterator[StatedCell]:
    for cell in read_text(RECORDED.read_text(encoding="utf-8"), RECORDED.name)["cells"]:
        yield StatedCell.read(cell, len(cell["P"]), RECORDED.name)


def recorded_rows() -> list[dict[str, Any]]:
    return list(json.loads(RECORDED.read_text(encoding="utf-8"))["cells"])


def main() -> None:
    sought: list[Any] = []

    def noted(*given: Any, **options: Any) -> Any:
        sought.append(one_step_gains(*given, **options))
        return sought[-1]

    with patch.object(effort_sharing_gains, "one_step_gains", noted):
        cells = running_loop(searched_design())["cells"]
    P = json.dumps(sought[-1].functions.P.tolist())
    rows = ",\n".join(json.dumps(cell) for cell in cells)
    RECORDED.write_text(f'{{"P": {P},\n"cells": [\n{rows}\n]}}\n', encoding="utf-8")


if __name__ == "__main__":
    main()
