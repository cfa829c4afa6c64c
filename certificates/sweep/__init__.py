"""Sweeps: what is proved of a turbine's law at each point of a grid of its parameters.

    tasks             tasks over several processes, with one stored result each
    axis              a quantity with its values, and how a user writes it
    effort_sharing    one point of the effort-sharing law
    published         one point of a published law: a pair of overlaps, at many winds
    sweep             all points of a grid: ``run_sweep``

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.sweep.axis import Axis as Axis
    from takagi.certificates.sweep.axis import AxisKind as AxisKind
    from takagi.certificates.sweep.axis import parse_axes as parse_axes
    from takagi.certificates.sweep.sweep import LAWS as LAWS
    from takagi.certificates.sweep.sweep import Sweep as Sweep
    from takagi.certificates.sweep.sweep import run_sweep as run_sweep
    from takagi.certificates.sweep.tasks import Task as Task
    from takagi.certificates.sweep.tasks import run_tasks as run_tasks

__getattr__, __dir__ = lazy_names(__name__)
