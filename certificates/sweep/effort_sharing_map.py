"""The map of the effort-sharing law: what is proved over overlap, gains, plant and class.

At each point the gains are designed wind by wind (two steps), one quadratic function is sought for
all winds, and its claim is judged by the independent checker on the decimals that a certificate
would state: what ``takagi design MODEL --two-step`` gives with these settings.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_candidate
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.provenance import plain, provenance
from takagi.certificates.sweep.axis import Axis
from takagi.certificates.sweep.grid import SweepMap, Task
from takagi.certificates.sweep.loop_answer import answer
from takagi.certificates.sweep.loop_settings import AXES as AXES  # takagi sweep reads it here
from takagi.certificates.sweep.loop_settings import loop_at, model_numbers
from takagi.certificates.sweep.wind_ranges import wind_ranges
from takagi.models.turbine.data import Turbine

Tell = Callable[..., None]


def build(
    law: str, turbine: Turbine, files: Sequence[Path], axes: Sequence[Axis], tell: Tell
) -> SweepMap:
    """Return the map of the effort-sharing law of a turbine over the axes.

    A value that the turbine's tables do not allow is no error here: it is the result of its point,
    which names the wind cell and the change that helps.
    """
    return SweepMap(law, tuple(axes), loop_settings(turbine), point, turbine)


def loop_settings(turbine: Turbine) -> dict[str, Any]:
    """Return what results depend on besides the point: settings, the model, versions."""
    return {
        "design": plain(default_settings(turbine)),
        "model": model_numbers(turbine),
        "versions": provenance({}, {})["versions"],
    }


def point(task: Task) -> dict[str, Any]:
    """Return what is proved at a point.

    Raises
    ------
    ModelError : no trim, no gain, or a box that leaves a table or an actuator's limits; names the
        wind and what to change.
    """
    turbine: Turbine = task.shared
    loop = loop_at(turbine, default_settings(turbine), task.at)
    found = effort_sharing_candidate(
        loop.turbine, loop.law, box=loop.box, uncertainty=loop.uncertainty, wind_class=loop.shape
    )
    return answer(loop.turbine, loop.law, found, wind_ranges(turbine))
