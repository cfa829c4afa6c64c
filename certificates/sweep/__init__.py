"""Sweeps: one result for each point of a grid, kept in a journal, made by several processes.

A **map** defines the task at each point.  It is a ``SweepMap`` (frozen dataclass):

    name       the law, as ``takagi sweep --law`` names it
    axes       ``Axis`` values: name, SI unit, values; the points are their product
    settings   JSON-able; everything that a result depends on, except the point: the law's settings
               and the model's numbers.  The journal's header has their hash, so a sweep with
               other settings is refused.
    point      a function at the top of a module, ``point(task) -> dict``
    shared     what all points have in common, such as the ``Turbine``: any value that pickle can
               send and that follows from ``settings``; sent to each process once, and not hashed.
               Read-only mappings, which a ``Turbine`` has, may be in it.
    prepare    ``prepare(settings, shared)``, a function at the top of a module, called once in each
               process: what it returns, which need not be picklable, is each task's ``shared``.
               None: ``shared`` itself is.
    beside     maps to compare with, such as one point of another law; each is made in a subfolder
               of its name, with its own journal

``point`` gets a ``Task``: ``task.at`` (axis name -> value), ``task.settings``, ``task.shared``.  It
returns a dict of JSON values, without NaN, with at least

    "verdict"  "PROVED", "PARTLY" (some of what was asked) or "UNDECIDED"
    "reason"   why not all of it is PROVED, in words; None where it is

and further numbers that its figures need, with the unit in the key.  A ``ModelError`` of the point
gives the answer UNDECIDED with the error's message. Any other error gives FAILED with its message;
that point is computed again when the sweep is resumed.  Neither ends the sweep.

A module with maps of a law gives the command line two names, and its figures a third:

    AXES       the ``AxisKind`` values that ``--over`` knows
    build      ``build(law, turbine, files, axes, tell) -> SweepMap``; raises ``ModelError`` where a
               value lies outside what the turbine's tables allow, naming the axis
    pages      in ``takagi.reports.maps``: ``pages(result: SweepResult) -> {file name: content}``

and a line in ``takagi.cli.verbs.sweep_maps``.  ``run_sweep(map, folder, workers=..., tell=...)``
makes the ``SweepResult``: the map and its points in the order of the grid.

The modules here:

    axis, grid                     axes; the tasks and results of the points
    journal, lock                  a line for each finished point; one writer a file
    runner, sending                several processes, and values as bytes for them
    effort_sharing_map             the map of the effort-sharing law: overlap, gains, plant, class
    effort_sharing_row             one point of it, to compare with another law's map
    published_map, published_point a published law over both overlaps; one pair of them
    loop_settings, wind_ranges     the loop at a point; one range of winds by itself
    loop_answer, loop_limits       what its certificate says; what limits it
    trade_off, widest_set          wind class against overspeed; the function of largest wind errors

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.sweep.axis import Axis as Axis
    from takagi.certificates.sweep.axis import AxisKind as AxisKind
    from takagi.certificates.sweep.axis import parse_axes as parse_axes
    from takagi.certificates.sweep.grid import PointResult as PointResult
    from takagi.certificates.sweep.grid import SweepMap as SweepMap
    from takagi.certificates.sweep.grid import SweepResult as SweepResult
    from takagi.certificates.sweep.grid import Task as Task
    from takagi.certificates.sweep.journal import Journal as Journal
    from takagi.certificates.sweep.journal import JournalError as JournalError
    from takagi.certificates.sweep.loop_limits import what_limits as what_limits
    from takagi.certificates.sweep.loop_settings import LoopSettings as LoopSettings
    from takagi.certificates.sweep.published_point import WindowResult as WindowResult
    from takagi.certificates.sweep.published_point import certified_windows as certified_windows
    from takagi.certificates.sweep.runner import run_sweep as run_sweep
    from takagi.certificates.sweep.wind_ranges import WindRange as WindRange

__getattr__, __dir__ = lazy_names(__name__)
