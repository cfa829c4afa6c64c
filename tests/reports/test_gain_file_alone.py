"""docs/gain-file.md: its 60 lines run every law from the gain file alone, to 1e-9."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.controller.content import bound, gain_file_of
from takagi.certificates.controller.plant_members import plant_members
from takagi.certificates.document import certificate_document
from takagi.certificates.model_data import pdc_law_data
from takagi.certificates.plant_blend import unknown_premises
from takagi.certificates.plant_embedding import law_members, plant_data
from takagi.models.blending.modelling import blended_model
from takagi.models.law.pdc import PdcLaw
from takagi.models.library import built_in_kinds, data_folder
from takagi.models.plant.loader import load_plant
from takagi.models.plant.plant import Plant
from takagi.models.sector.model import sector_model
from takagi.reports.gain_file import dump_gains

PAGE = (Path(__file__).parents[2] / "docs" / "gain-file.md").read_text(encoding="utf-8")
"""The page."""


@cache
def code() -> str:
    """Return the page's block with the controller."""
    found = re.search(r"<!-- a test runs this block .*?-->\n```python\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def controller(path: Path, *programs: str) -> Any:
    """Return the page's controller for a file; for the named programs alone, or all."""
    room: dict[str, Any] = {}
    exec(code(), room)
    return room["Controller"](path, programs)


def test_it_has_sixty_lines_and_imports_nothing_else() -> None:
    lines = [line for line in code().splitlines() if line.strip()]

    assert len(lines) <= 60
    assert re.findall(r"^(?:from|import) (\w+)", code(), re.MULTILINE) == ["json", "math"]


# ------------------------------------------------------------------ plants

PLANTS = [
    name
    for name, kind in built_in_kinds().items()
    if kind == "plant" and "[inputs]" in (data_folder() / f"{name}.toml").read_text("utf-8")
]


@cache
def plant_law(name: str) -> tuple[Plant, PdcLaw]:
    """Return a built-in plant with gains of no meaning that differ from rule to rule.

    Of a blended plant they differ only with what a law knows.
    """
    plant = load_plant(name)
    model = blended_model(plant) if plant.blending is not None else sector_model(plant)
    r, n, m = model.B.shape
    rng = np.random.default_rng(11)
    K = rng.uniform(0.5, 2.0, (r, m, n))
    unknown = unknown_premises(model)
    for i, rule in enumerate(model.rules):
        same = [c if not u else 0 for c, u in zip(rule, unknown, strict=True)]
        K[i] = K[[*model.rules].index(tuple(same))]
    trim = law_members(plant_data(model))["trim"]
    return plant, PdcLaw(model, K, np.array(trim["state"]), np.array(trim["input"]))


def plant_file(name: str, folder: Path) -> Path:
    """Write the gain file of ``plant_law``, as a design would."""
    plant, law = plant_law(name)
    data = plant_data(law.model)
    gains = pdc_law_data(law.model, law.gains) | law_members(data)
    document = certificate_document(model=data, gains=gains, claims=[], provenance={})
    own = plant_members(plant, law.model, gains, Checked.of([], []), ())
    path = folder / "gains.json"
    path.write_text(dump_gains(gain_file_of(bound(document, own))), encoding="utf-8")
    return path


def states_of(law: PdcLaw) -> list[np.ndarray[Any, np.dtype[np.float64]]]:
    """Return states at rest, all around it, from a hair off rest to far outside the box."""
    rng, model = np.random.default_rng(3), law.model
    sides = [model.box.get(label, (1, 1)) for label in model.states]
    half = np.array([float(max(map(abs, side))) for side in sides])
    found = [law.state_rest.copy()]
    for size in (1e-12, 1e-9, 1e-6, 1e-4, 1.5e-4, 1e-3, 3e-3, 1e-2, 0.1, 0.5, 1.0, 1.4):
        found += [law.state_rest + size * rng.uniform(-1, 1, len(half)) * half for _ in range(2)]
    for k in range(len(half)):
        one = law.state_rest.copy()
        one[k] += 0.3 * half[k]
        found.append(one)
    # The effort of a blend, the last state, beyond what the actuators can do.
    found += [law.state_rest + np.append(0 * half[:-1], e * half[-1]) for e in (-9.0, 9.0)]
    return found


@pytest.mark.parametrize("name", PLANTS)
def test_the_law_of_every_built_in_plant(name: str, tmp_path: Path) -> None:
    """At rest, near points where a premise is 0/0, in the box, outside it, at saturation."""
    plant, law = plant_law(name)
    run = controller(plant_file(name, tmp_path))
    names = [v.name for v in plant.states]
    held = 0
    for state in states_of(law):
        seen = dict(zip(names, map(float, state), strict=True))
        if law.blend is not None:
            run.kept[0][plant.states[-1].name] = seen.pop(plant.states[-1].name)
        sent = run.sample(0.1, **seen)
        wanted = dict(zip((v.name for v in plant.inputs), law.sent(state), strict=True))
        if law.blend is not None:
            actuators = (a.name for a in law.blend.blending.actuators)
            wanted |= dict(zip(actuators, law.blend.sent(state), strict=True))
            held += int(np.any(law.blend.sent(state) != law.blend.commands(state)))
        for signal, value in wanted.items():
            assert sent[signal] == pytest.approx(float(value), rel=1e-9, abs=1e-9), (signal, state)
    assert held or law.blend is None


def test_the_effort_of_a_blend_is_added_up(tmp_path: Path) -> None:
    """U after = U + T times the commanded rate, from where it rests."""
    plant, law = plant_law("split_range")
    run = controller(plant_file("split_range", tmp_path))
    effort = float(law.state_rest[-1])
    for _ in range(5):
        state = np.array([351.0, 341.0, 10.0, effort])
        seen = dict(zip((v.name for v in plant.states[:-1]), map(float, state), strict=False))
        run.sample(0.1, **seen)
        effort += 0.1 * float(law.sent(state)[0])
        assert run.kept[0][plant.states[-1].name] == pytest.approx(effort, rel=1e-12)
