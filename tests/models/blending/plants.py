"""A plant with two actuators that is small enough to be known by heart, as a file's text."""

from __future__ import annotations

from pathlib import Path

from takagi.models import Plant, load_model

# Cooling acts alike everywhere, heating more where it is warm; at the effort 0 both are at 1/16.
ROOM = """
format = 1
kind = "plant"
name = "Room"
units = "unchecked"

[states]
x = { range = [-1, 1] }

[inputs]
cooling = { range = [0, 1.5] }
heating = { range = [0, 3] }

[parameters]
a = { value = 0.5 }

[equations]
x = "a*x - 2*cooling + (2 + x)*heating"

[blending]
effort = { range = [-3, 3], overlap = 0.5, rate = 20 }
low = { input = "cooling", direction = -1, effectiveness = "2", error = 0.1 }
high = { input = "heating", direction = 1, effectiveness = "2 + x", error = 0.2 }
"""


def plant_of(folder: Path, text: str = ROOM, **changes: str) -> Plant:
    for pair in changes.values():
        old, new = pair.split(" -> ")
        assert text.count(old) == 1, f"{old} is there {text.count(old)} times"
        text = text.replace(old, new)
    path = folder / "room.toml"
    path.write_text(text, encoding="utf-8")
    plant = load_model(path)
    assert isinstance(plant, Plant)
    return plant
