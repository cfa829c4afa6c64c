"""The effort-sharing law as one point, to compare with another law's map at the same winds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.design import design_turbine
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.certificates.document.provenance import plain, provenance
from takagi.certificates.sweep.grid import SweepMap, Task
from takagi.certificates.sweep.loop_settings import model_numbers
from takagi.certificates.sweep.published_point import Span, WindowResult, point_result
from takagi.models.turbine.data import Turbine


def effort_sharing_row(turbine: Turbine, winds: Sequence[Span]) -> SweepMap:
    """Return the map of one point: the effort-sharing law with gains found in two steps."""
    settings = {
        "model": model_numbers(turbine),
        "design": plain(_settings(turbine)),
        "windows": [list(span) for span in winds],
        "versions": provenance({}, {})["versions"],
    }
    return SweepMap("coherent", (), settings, point, turbine)


def point(task: Task) -> dict[str, Any]:
    """Return the design's certificate at the windows: PROVED there, with the cells' decay rates.

    Its claim also holds for varying winds and uncertain plants. The map is about constant winds;
    for these the claim gives the decay rate of the cells that contain the window, and the
    equilibrium at the trim.
    """
    turbine: Turbine = task.shared
    design = design_turbine(turbine, _settings(turbine))
    claim, checked = next(
        pair
        for pair in zip(design.document["claims"], design.checked.claims, strict=True)
        if pair[0]["kind"] == "coherent-loop"
    )
    proved = checked.verdict is Verdict.PROVED
    return point_result(
        [
            _window(claim, (low, high), proved, checked.text)
            for low, high in task.settings["windows"]
        ]
    )


def _settings(turbine: Turbine) -> DesignSettings:
    return replace(default_settings(turbine), law="coherent", synthesis="two-step")


def _window(claim: Mapping[str, Any], span: Span, proved: bool, text: str) -> WindowResult:
    """Return one window; it is covered if adjacent cells without a gap contain it."""
    met = sorted(
        (
            cell
            for cell in claim["cells"]
            if cell["wind"][0] < span[1] and cell["wind"][1] > span[0]
        ),
        key=lambda cell: cell["wind"][0],
    )
    whole = bool(met) and met[0]["wind"][0] <= span[0] and met[-1]["wind"][1] >= span[1]
    gapless = all(a["wind"][1] == b["wind"][0] for a, b in zip(met, met[1:], strict=False))
    if not (proved and whole and gapless):
        reason = "the certificate's cells do not cover it" if proved else text
        return WindowResult(span, False, None, None, "intended", None, reason)
    rate = min(float(cell["decay_rate"]) for cell in met)
    width = float(claim["peaks"]["speed_error"])
    return WindowResult(span, True, rate, width, "intended", None, None)
