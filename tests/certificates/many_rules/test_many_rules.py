"""Plants with many rules: what is announced, what is chosen within a time, and that it is proved.

Two tanks: structure of Henson and Seborg (1990), AIChE Journal 36(11); tank with coolant valve:
Seborg, Edgar, Mellichamp (2004), Process Dynamics and Control, example 2.5.  Both recalled; the
files say what was chosen.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.gain_task import GainTask
from takagi.certificates.design.plant.many_rules import (
    effects,
    gain_choice,
    gains_of_few_premises,
    model_of_premises,
    work_of,
)
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant, TSModel, load_model, sector_model
from takagi.models.plant.design_settings import PlantSettings

HERE = Path(__file__).parent


def plant_of(path: Path) -> Plant:
    found = load_model(path)
    assert isinstance(found, Plant)
    return found


@pytest.fixture(scope="module")
def valve() -> tuple[Plant, TSModel]:
    plant = plant_of(HERE / "tank_with_valve.toml")
    return plant, sector_model(plant)


@pytest.mark.slow
def test_two_tanks_are_proved_with_one_gain() -> None:
    """256 rules: the choice is announced before, said in a note, and the plant itself is proved."""
    told: list[str] = []
    found = design_plant(plant_of(HERE / "two_tanks.toml"), announce=told.append)
    assert isinstance(found, PlantDesign) and found.proved
    assert found.gains is not None and len(found.gains) == 256
    assert np.ptp(found.gains, axis=0).max() == 0
    assert len(told) == 1
    assert told[0].startswith("256 rules by 8 premises, of most effect z2 = exp(25)*exp(")
    for words in ("1/K", "GB", "Chosen: one gain for all rules", "--time", "one premise less"):
        assert words in told[0]
    assert found.notes[0].startswith("one gain for all 256 rules: a gain for every rule would take")


def test_the_time_decides_between_one_gain_and_one_for_every_rule(
    valve: tuple[Plant, TSModel],
) -> None:
    """32 rules fit into two minutes by the estimate, not into ten seconds."""
    _, model = valve
    asked = PlantSettings()
    plenty, little = gain_choice(model, asked, 120.0), gain_choice(model, asked, 10.0)
    assert not plenty.shortened and "Chosen" not in plenty.announcement
    assert plenty.announcement.startswith("32 rules by 5 premises")
    assert little.shortened and little.note
    kept = gain_choice(model, replace(asked, relaxation="tanaka-wang"), 10.0)
    assert not kept.shortened and kept.announcement


def test_a_quick_design_is_left_alone_and_silent(valve: tuple[Plant, TSModel]) -> None:
    """Short work is neither announced nor changed, whatever the budget."""
    smaller, _ = model_of_premises(valve[1], [0, 1])
    choice = gain_choice(smaller, PlantSettings(), 0.001)
    assert (choice.shortened, choice.announcement, choice.note) == (False, "", "")


def test_gains_over_few_premises_are_put_on_all_rules(valve: tuple[Plant, TSModel]) -> None:
    """Rules that share the kept corners share a gain; the smaller model is the mean of theirs."""
    plant, model = valve
    smaller, place = model_of_premises(model, [1, 4])
    assert len(smaller.A) == 4 and sorted(set(place)) == [0, 1, 2, 3]
    for rule, corners in enumerate(model.rules):
        assert smaller.rules[place[rule]] == (corners[1], corners[4])
    np.testing.assert_allclose(smaller.A[0], model.A[place == 0].mean(axis=0), rtol=1e-12)
    task = GainTask.of(plant, model, PlantSettings(decay_rate=0.02))
    found = gains_of_few_premises(task, 20.0)
    assert found is not None and found.notes[0].startswith("gains that depend on z")
    gains = np.asarray(found.design.require()[0])
    assert 1 < len(np.unique(gains.round(12), axis=0)) < len(model.A)


@pytest.mark.slow
def test_gains_over_few_premises_are_proved_with_all_rules(
    valve: tuple[Plant, TSModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where one gain is not found, and the time is not enough for a gain for every rule."""
    from takagi.certificates.design.plant import design, many_rules

    one_gain = many_rules.shortened_gains

    def nothing(*given: Any) -> Any:
        found = one_gain(*given)
        answer = replace(found.design.answer, status="infeasible")
        return replace(found, design=replace(found.design, answer=answer))

    monkeypatch.setattr(design, "shortened_gains", nothing)
    found = design_plant(valve[0], budget=20.0)

    assert isinstance(found, PlantDesign) and found.proved
    assert found.notes[0].startswith("gains that depend on z2, z3, z5 alone")
    assert found.gains is not None and len(np.unique(found.gains, axis=0)) == 8
    assert not isinstance(design_plant(valve[0], budget=1.0), PlantDesign)


def test_the_estimate_counts_what_is_posed(valve: tuple[Plant, TSModel]) -> None:
    """Pairs that share a product of weights are one inequality; one gain needs the rules alone."""
    asked = PlantSettings()
    each = work_of(32, (4, 2), asked, one_gain=False)
    assert (each.inequalities, each.unknowns) == (243, 10 + 32 * 8)
    assert work_of(32, (4, 2), asked, one_gain=False, merged=False).inequalities == 528
    single = work_of(32, (4, 2), asked, one_gain=True)
    assert (single.inequalities, single.unknowns) == (32, 18)
    assert single.seconds < work_of(32, (4, 2), asked, one_gain=False).seconds / 5
    assert work_of(32, (4, 2), replace(asked, decay_rate=0.1), one_gain=False).seconds < (
        each.seconds / 2
    )
    assert effects(valve[1]).shape == (5,) and (effects(valve[1]) > 0).all()
