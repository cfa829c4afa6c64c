"""docs/blending.md does what it says: its plant is read, its claims hold, its messages come."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import Verdict
from takagi.certificates.design.plant.design import certify_plant
from takagi.models import ModelError, Plant, load_model
from takagi.models.blending.blending import blending_of
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.entries import ActuatorEntry, EffortEntry
from tests.docs_pages import fenced, text_of

PAGE = text_of("blending.md")


def vessel(folder: Path, text: str) -> Plant:
    path = folder / "vessel.toml"
    path.write_text(text, encoding="utf-8")
    plant = load_model(path)
    assert isinstance(plant, Plant)
    return plant


def test_the_vessel_is_proved_under_one_gain(tmp_path: Path) -> None:
    """The gains that `takagi design` gives it, to four digits: everything, both valves 20 % off."""
    plant = vessel(tmp_path, fenced(PAGE, "toml")[0])
    gains = [[1.059, 0.2606, 4.218]]

    found = certify_plant(plant, lambda m: np.array([gains] * len(m.A)), PlantSettings())
    assert found.verdict is Verdict.PROVED
    assert {"effort-blend", "invariant-ellipsoid", "input-limits"} <= {
        claim["kind"] for claim in found.document["claims"]
    }


def test_the_opening_that_is_worked_out_on_the_page(tmp_path: Path) -> None:
    """-0.8 bar/s at 3 bar: the vent is open by 0.8; the supply idles."""
    from takagi.models.blending.blending import RunTimeBlending

    plant = vessel(tmp_path, fenced(PAGE, "toml")[0])
    blending = blending_of(plant)
    assert blending is not None
    commands = RunTimeBlending(blending).commands(np.array([3e5, 0.0, -0.8e5]))

    assert commands == pytest.approx([0.8, 0.0])


def test_the_message_is_the_one_that_is_shown(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as refused:
        vessel(tmp_path, fenced(PAGE, "toml")[0].replace("range = [3, 5]", "range = [3, 9]"))
    shown = re.search(r"```text\n(vessel.toml.*?)\n```", PAGE, re.DOTALL)

    assert shown is not None
    # The page's file begins without the empty line of a comment.
    assert str(refused.value).endswith(shown.group(1).partition(": ")[2])


def test_every_field_is_on_the_page() -> None:
    names = {*EffortEntry.model_fields, *ActuatorEntry.model_fields}

    assert not [
        name for name in names if f"`{name}`" not in PAGE and f"`effort.{name}`" not in PAGE
    ]
