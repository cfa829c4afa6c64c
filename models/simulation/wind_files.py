r"""Wind series from files: a table of time and wind, and a full field of TurbSim over the disc.

A full field is averaged over the points of its grid that lie inside the rotor's disc, at hub
height: the rotor feels that mean.  Shear, veer and what passes single blades are not in it.

Layout of a ``.bts`` file, all little-endian: int16 kind (7, or 8 for a periodic field); int32
points in height and width, points of the tower, time steps; float32 grid spacing in height and
width [m], time step [s], mean wind at the hub [m/s], hub height and height of the lowest row [m];
then for each of the three components float32 slope and offset; int32 length of a text, and the
text.  Then for every time step int16 values v of all points, rows of height outside, width within,
the three components innermost, and those of the tower: wind = (v - offset) / slope.

Source: Jonkman (2014), TurbSim user's guide v2.00.00, appendix on full-field binary files.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from takagi.models.arrays import Indices
from takagi.models.errors import ModelError
from takagi.models.simulation.wind import WindSeries

FIELD_KINDS = (7, 8)
_HEADER = struct.Struct("<h4i12fi")
# A grid may end this share of the radius inside the disc: TurbSim rounds its size to whole cells.
UNCOVERED = 0.05


def read_wind_table(path: Path) -> WindSeries:
    """Return the wind of a CSV file: time [s] and wind [m/s] in the first two columns.

    A first line that is no pair of numbers is taken for a heading; lines that begin with # are
    comments.

    Raises
    ------
    ModelError : names the line that has no two numbers, or what a wind series refuses.
    """
    rows: list[tuple[float, float]] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ModelError(
            f"{path}: no table of winds, for it is no text; a CSV file with time [s] and wind "
            "[m/s] is needed, or a full field of TurbSim named .bts"
        ) from error
    for number, line in enumerate(lines, 1):
        cells = [cell.strip() for cell in line.split(",")]
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            rows.append((float(cells[0]), float(cells[1])))
        except (ValueError, IndexError):
            if rows or number > 1:
                raise ModelError(
                    f"{path}, line {number}: {line.strip()!r} was read; time [s] and wind [m/s] "
                    "are needed, as in 0.05,11.3"
                ) from None
    if len(rows) < 2:
        raise ModelError(
            f"{path}: {len(rows)} lines with time [s] and wind [m/s] were read; 2 or more are "
            "needed"
        )
    time, speed = np.array(rows).T
    return WindSeries(time, speed, str(path))


def read_full_field(path: Path, *, rotor_radius: float, hub_height: float) -> WindSeries:
    """Return the wind of a TurbSim ``.bts`` file along the flow, averaged over the rotor's disc.

    ``rotor_radius``, ``hub_height`` : of the turbine [m]; the disc's middle is the grid's in width.

    Raises
    ------
    ModelError : no such file, one that ends early, or a grid that does not cover the disc.
    """
    content = path.read_bytes()
    wrong = f"{path}: no full field of TurbSim"
    if len(content) < _HEADER.size:
        raise ModelError(f"{wrong}, for it has {len(content)} bytes; give its .bts file")
    kind, rows, columns, tower, steps, *figures, letters = _HEADER.unpack_from(content)
    if kind not in FIELD_KINDS:
        raise ModelError(
            f"{wrong}, for it begins with {kind} and not with 7 or 8; give the .bts file that "
            "TurbSim writes with WrADFF = True"
        )
    d_z, d_y, d_t, _, _, lowest, slope, offset = figures[:8]
    sizes = (rows, columns, steps, d_z, d_y, d_t, slope)
    if not all(np.isfinite(size) and size > 0 for size in sizes) or tower < 0 or letters < 0:
        raise ModelError(f"{wrong}: its head has a size that is not above 0; it is damaged")
    begin, values = _HEADER.size + letters, 3 * (rows * columns + tower)
    if len(content) < begin + 2 * values * steps:
        raise ModelError(
            f"{path}: {steps} steps of {rows} x {columns} points are announced and the file ends "
            "before them; write or copy it once more"
        )
    field = np.frombuffer(content, "<i2", values * steps, begin).reshape(steps, values)
    along = field[:, : 3 * rows * columns : 3]
    inside = _disc(path, (rows, columns), (d_z, d_y), lowest, rotor_radius, hub_height)
    mean = along[:, inside].mean(axis=1, dtype=np.float64)
    return WindSeries(d_t * np.arange(steps), (mean - offset) / slope, str(path))


def _disc(
    path: Path,
    points: tuple[int, int],
    spacing: tuple[float, float],
    lowest: float,
    radius: float,
    hub_height: float,
) -> Indices:
    """Return the numbers of the grid's points inside the disc, rows of height outside."""
    height = lowest + spacing[0] * np.arange(points[0]) - hub_height
    width = spacing[1] * (np.arange(points[1]) - (points[1] - 1) / 2)
    reach = min(-height[0], height[-1], width[-1])
    if reach < (1 - UNCOVERED) * radius:
        raise ModelError(
            f"{path}: the grid reaches {reach:.1f} m from the hub at {hub_height:g} m, and the "
            f"rotor's radius is {radius:g} m; make a field for this turbine (HubHt, GridHeight and "
            "GridWidth of TurbSim)"
        )
    inside = np.hypot(height[:, None], width[None, :]) <= radius
    return np.flatnonzero(inside.ravel())
