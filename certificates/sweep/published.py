"""One point of a published law's sweep: a pair of overlaps, and the winds proved for it.

At each wind one window of ``WINDOW`` m/s is examined, as one cell (two if a table has a node in
it); nothing is claimed between the windows.  Regional gains and trim tables do not depend on the
overlaps and are made once in each process.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.published import (
    PublishedCandidate,
    published_candidate,
    published_claim,
    published_law_data,
    with_overlaps,
)
from takagi.certificates.design.turbine.published_law import designed_law, regional_design
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.certificate_file import certificate_document, turbine_data
from takagi.certificates.sweep.axis import AxisKind
from takagi.models.errors import ModelError
from takagi.models.laws.published.coupling_filter import coupling_filter
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

SPEED, TORQUE, WIND = "speed-overlap", "torque-overlap", "wind"
AXES = (AxisKind(SPEED, "rad/s"), AxisKind(TORQUE, "N m"), AxisKind(WIND, "m/s"))

# Half widths in speed of the sets to try, the largest first [rad/s].
LADDER = (0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001, 5e-5, 2e-5)
# Wider windows would need smaller cells where the ramp is steep [m/s].
WINDOW = 0.004
# Distance from rated wind within which further winds are added, because the regions meet [m/s].
NEAR_RATED = 1.5
DIGITS = 9

Span = tuple[float, float]


def default_winds(turbine: Turbine) -> tuple[float, ...]:
    """Return a wind per m/s from half a metre above cut-in on, and some near rated wind [m/s]."""
    rated = rated_wind(turbine)
    halves = [turbine.cut_in + 0.5 * k for k in range(1, 1000)]
    inside = [v for v in halves if v < turbine.cut_out]
    return tuple(
        round(v, DIGITS) for k, v in enumerate(inside) if k % 2 == 0 or abs(v - rated) <= NEAR_RATED
    )


def require_winds(turbine: Turbine, winds: Sequence[float]) -> None:
    """Refuse a wind whose window is not between cut-in and cut-out."""
    last = round(turbine.cut_out - WINDOW, DIGITS)
    for v in winds:
        if not turbine.cut_in <= v <= last:
            raise ModelError(
                f"axis {WIND}: {v:g} m/s was given; the window from there on, {WINDOW:g} m/s wide, "
                f"must lie between cut-in and cut-out: give winds from {turbine.cut_in:g} to "
                f"{last:g} m/s"
            )


def point(
    name: str, turbine: Turbine, at: Mapping[str, float], winds: Sequence[float]
) -> dict[str, Any]:
    """Return what is proved at one pair of overlaps, together and by window of wind.

    Parameters
    ----------
    name : of the law, as files have it.
    at : axis name -> value; an overlap that is missing keeps the design's value.
    winds : at which a window begins [m/s].

    Raises
    ------
    ModelError : overlaps without a valid coupling filter.
    """
    law = _law(name, turbine)
    overlaps = {
        "speed_overlap": at.get(SPEED, law.coupling.speed_ramp.width),
        "torque_overlap": at.get(TORQUE, law.coupling.torque_overlap),
    }
    coupling_filter(turbine, **overlaps)
    windows = certified_windows(
        with_overlaps(law, **overlaps), [(v, round(v + WINDOW, DIGITS)) for v in winds]
    )
    proved = [window for window in windows if window["verdict"] == "PROVED"]
    failing = next((window for window in windows if window not in proved), None)
    first = None if failing is None else failing["from [m/s]"]
    return {
        "verdict": "PROVED" if failing is None else "PARTLY" if proved else "UNDECIDED",
        "reason": failing and f"{first:g} to {failing['to [m/s]']:g} m/s: {failing['reason']}",
        "proved_windows": len(proved),
        "proved_at_trim": sum(window["rest"] == "intended" for window in proved),
        "first_failing_wind [m/s]": first,
        "least_decay_rate [1/s]": min((w["decay_rate [1/s]"] for w in proved), default=None),
        "smallest_half_width [rad/s]": min((w["half_width [rad/s]"] for w in proved), default=None),
        "windows": windows,
    }


@lru_cache(maxsize=2)
def _law(name: str, turbine: Turbine) -> PublishedLaw:
    asked = replace(default_settings(turbine), law=name)
    return designed_law(turbine, asked, regional_design(turbine))


def certified_windows(law: PublishedLaw, winds: Sequence[Span]) -> list[dict[str, Any]]:
    """Return, for each window of wind [m/s], whether the checker proves the law there, and why not.

    Cells are searched in floating point and written as decimals. A window is proved only if the
    checker proves it.  ``decay_rate`` is the least of its cells', ``half_width`` in speed that of
    the smallest box.  ``rest`` says where the law rests at the window's lower end: "intended" (at
    the trim), "shifted" (elsewhere), "continuum" or "none"; ``power_ratio`` is the power there
    over that of the trim.
    """
    narrowest = min(high - low for low, high in winds)
    candidate = published_candidate(law, winds=winds, narrowest=narrowest, ladder=LADDER)
    covered = [span for span in candidate.winds if _reason(candidate, span) is None]
    proved = _proved(candidate, covered) if covered else set()
    return [_window(candidate, span, span in proved) for span in candidate.winds]


def _proved(candidate: PublishedCandidate, windows: Sequence[Span]) -> set[Span]:
    """Return the windows that the checker proves, each by a claim of its own."""
    claims = []
    for span in windows:
        cells = tuple(each for each in candidate.cells if _inside(each.cell.wind, span))
        alone = replace(candidate, winds=(span,), cells=cells, unproved=())
        claims.append(published_claim(alone))
    document = certificate_document(
        model=turbine_data(candidate.law.turbine, ()),
        gains=published_law_data(candidate.law),
        claims=claims,
        provenance={"solver": {}},
    )
    pairs = zip(windows, check_document(document).claims, strict=True)
    return {span for span, claim in pairs if claim.verdict is Verdict.PROVED}


def _window(candidate: PublishedCandidate, span: Span, proved: bool) -> dict[str, Any]:
    rest = candidate.rests[span[0]]
    cells = [found for found in candidate.cells if proved and _inside(found.cell.wind, span)]
    reason = _reason(candidate, span) or "the checker did not confirm what was found"
    return {
        "from [m/s]": span[0],
        "to [m/s]": span[1],
        "verdict": "PROVED" if proved else "UNDECIDED",
        "decay_rate [1/s]": min((found.decay_rate for found in cells), default=None),
        "half_width [rad/s]": min((float(found.cell.box[0]) for found in cells), default=None),
        "rest": rest.kind,
        "power_ratio [-]": None if rest.kind == "none" else round(rest.power_ratio, 6),
        "reason": None if proved else reason,
    }


def _reason(candidate: PublishedCandidate, span: Span) -> str | None:
    """Return why cells do not cover a window; None if they do."""
    if any(_inside(span, covered) for covered in candidate.covered):
        return None
    gaps = sorted(candidate.unproved, key=lambda gap: gap.wind)
    return next((gap.reason for gap in gaps if _inside(gap.wind, span)), "no cell was found")


def _inside(span: Span, other: Span) -> bool:
    return other[0] <= span[0] and span[1] <= other[1]
