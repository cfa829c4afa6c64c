"""Winds of files: a table, a full field written here by its published layout, and damaged ones."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.models import ModelError
from takagi.models.simulation.wind import read_full_field, read_wind_table

HUB, RADIUS = 90.0, 60.0
TEXT = b"a field of the tests"


def write_field(
    path: Path, along: NDArray[np.float64], spacing: float, *, tower: int = 3, kind: int = 7
) -> None:
    """Write the wind along the flow, (steps, height, width), in TurbSim's full-field layout.

    Source: Jonkman (2014), TurbSim user's guide v2.00.00, full-field binary files.
    """
    steps, rows, columns = along.shape
    slope, offset = 1000.0, -20000.0
    lowest = HUB - spacing * (rows - 1) / 2
    content = struct.pack("<hiiii", kind, rows, columns, tower, steps)
    content += struct.pack("<ffffff", spacing, spacing, 0.05, 11.0, HUB, lowest)
    content += struct.pack("<ffffff", slope, offset, 1500.0, 7.0, 1500.0, -7.0)
    content += struct.pack("<i", len(TEXT)) + TEXT
    for field in along:
        for value in field.ravel():
            content += struct.pack("<hhh", round(value * slope + offset), 17, -17)
        content += struct.pack("<hhh", 1, 2, 3) * tower
    path.write_bytes(content)


def sheared(steps: int, points: int, spacing: float) -> NDArray[np.float64]:
    """A wind with steps in time, shear over height and width, and a cubic that a square has."""
    z = spacing * (np.arange(points) - (points - 1) / 2) / RADIUS
    t = np.arange(steps)[:, None, None]
    up, across = z[None, :, None], z[None, None, :]
    return np.asarray(10.0 + 0.5 * t + 3.0 * up - 2.0 * across + up**2, dtype=np.float64)


@pytest.mark.parametrize("kind", [7, 8])
def test_a_full_field_is_averaged_over_the_disc(tmp_path: Path, kind: int) -> None:
    """Linear shear averages out; z^2 has the mean R^2 / 4 over a disc, R^2 / 3 over a square."""
    path = tmp_path / "field.bts"
    write_field(path, sheared(4, 121, 1.0), 1.0, kind=kind)
    wind = read_full_field(path, rotor_radius=RADIUS, hub_height=HUB)

    assert wind.time == pytest.approx(0.05 * np.arange(4), abs=1e-7)
    assert wind.speed == pytest.approx(10.25 + 0.5 * np.arange(4), abs=0.005)


def test_the_disc_stands_at_the_turbines_hub(tmp_path: Path) -> None:
    """A smaller rotor that stands 10 m higher feels the shear between."""
    path = tmp_path / "field.bts"
    write_field(path, sheared(2, 121, 1.0), 1.0)
    wind = read_full_field(path, rotor_radius=30.0, hub_height=HUB + 10.0)
    share = 10.0 / RADIUS

    assert wind.speed[0] == pytest.approx(10.0 + 3.0 * share + share**2 + 1 / 16, abs=0.005)


def test_a_table_may_have_a_heading_and_comments(tmp_path: Path) -> None:
    path = tmp_path / "wind.csv"
    path.write_text("time [s], wind [m/s]\n# measured\n0, 8\n10, 9.5, cloudy\n\n20,8\n")
    wind = read_wind_table(path)

    assert wind.time.tolist() == [0.0, 10.0, 20.0]
    assert wind.speed.tolist() == [8.0, 9.5, 8.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,wind\n0,8\n1,fast\n", "line 3: '1,fast'"),
        ("0;8\n1;8\n", "line 2"),
        ("time,wind\n0,8\n", "1 lines"),
        ("0,8\n0,9\n", "increase strictly"),
        ("0,8\n1,-2\n", "speed is -2 m/s at 1 s"),
    ],
)
def test_a_damaged_table_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "wind.csv"
    path.write_text(text)
    with pytest.raises(ModelError, match=words):
        read_wind_table(path)


def test_a_damaged_field_is_refused(tmp_path: Path) -> None:
    """Another kind of file, an end that came early, and a grid that is smaller than the rotor."""
    path = tmp_path / "field.bts"
    write_field(path, sheared(2, 13, 10.0), 10.0)
    content = path.read_bytes()
    for damaged, words in (
        (b"time,wind\n" + content, "begins with"),
        (content[:-1], "ends before"),
        (content[:50], "50 bytes"),
        (content[:2] + struct.pack("<i", 0) + content[6:], "not above 0"),
    ):
        path.write_bytes(damaged)
        with pytest.raises(ModelError, match=words):
            read_full_field(path, rotor_radius=RADIUS, hub_height=HUB)
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"reaches 60.0 m .* radius is 80 m"):
        read_full_field(path, rotor_radius=80.0, hub_height=HUB)
    assert read_full_field(path, rotor_radius=RADIUS, hub_height=HUB).speed[0] > 0
