"""docs/gain-file.md: its 60 lines run every law from the gain file alone, to 1e-9."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.controller.content import bound, gain_file_of
from takagi.certificates.controller.plant_members import plant_members
from takagi.certificates.design.turbine.published_law import designed_law
from takagi.certificates.document.certificate_file import (
    certificate_document,
    dumps,
    effort_sharing_law_data,
    published_law_data,
)
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import law_members, plant_data, unknown_premises
from takagi.models import Floats, Plant
from takagi.models.files.library import built_in_kinds, data_folder
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.pdc import PdcLaw
from takagi.models.laws.protocol import Command, Law, Measurement, sampled
from takagi.models.turbine.trim import trim
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.models.library_plants import library_model, plant_of
from tests.reports.python_law import PythonLaw

PAGE = (Path(__file__).parents[2] / "docs" / "gain-file.md").read_text(encoding="utf-8")
"""The page."""


@cache
def code() -> str:
    found = re.search(r"<!-- a test runs this block .*?-->\n```python\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def controller(path: Path, *programs: str) -> Any:
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
    for text in [(data_folder() / f"{name}.toml").read_text("utf-8")]
    # A law with integrals is run in test_tracking_gain_file.
    if kind == "plant" and "[inputs]" in text and "[reference]" not in text
]


@cache
def plant_law(name: str) -> tuple[Plant, PdcLaw]:
    """Gains of no meaning that differ from rule to rule, of a blend only with what a law knows."""
    plant, model = plant_of(name), library_model(name)
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
    plant, law = plant_law(name)
    data = plant_data(law.model)
    gains = pdc_law_data(law.model, law.gains) | law_members(data)
    document = certificate_document(model=data, gains=gains, claims=[], provenance={})
    own = plant_members(plant, law.model, gains, concluded([], []), ())
    return written(bound(document, own), folder)


def written(document: Any, folder: Path) -> Path:
    path = folder / "gains.json"
    path.write_text(dump_gains(gain_file_of(document)), encoding="utf-8")
    (folder / "certificate.json").write_text(dumps(document), encoding="utf-8")
    return path


def states_of(law: PdcLaw) -> list[np.ndarray[Any, np.dtype[np.float64]]]:
    rng, model = np.random.default_rng(3), law.model
    sides = [model.box.get(label, (1, 1)) for label in model.states]
    half = np.array([max(abs(float(end)) for end in side) for side in sides])
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
    plant, law = plant_law("boost_throttle")
    run = controller(plant_file("boost_throttle", tmp_path))
    effort = float(law.state_rest[-1])
    for _ in range(5):
        state = np.array([8.4e4, 1.71e4, 10.0, effort])
        seen = dict(zip((v.name for v in plant.states[:-1]), map(float, state), strict=False))
        run.sample(0.1, **seen)
        effort += 0.1 * float(law.sent(state)[0])
        assert run.kept[0][plant.states[-1].name] == pytest.approx(effort, rel=1e-12)


# ------------------------------------------------------------------ turbines


def turbine_file(design: TurbineDesign, law: Law, folder: Path) -> Path:
    coherent = isinstance(law, EffortSharingLaw)
    gains = effort_sharing_law_data(law) if coherent else published_law_data(law)  # type: ignore[arg-type]
    document = certificate_document(
        model=design.document["model"], gains=gains, claims=[], provenance={}
    )
    own = {**design.document["controller"], "start": {"wind": [3, 25], "integrals": [[0, 0]] * 2}}
    return written(bound(document, own), folder)


def laws_of(design: TurbineDesign) -> dict[str, Law]:
    """Return every law that ``design --law`` emits, and variants of its options."""
    assert design.effort_sharing_law is not None
    plain, turbine = design.effort_sharing_law, design.turbine
    models = (design.partial_load, design.full_load, design.regional)
    found: dict[str, Law] = {
        "coherent": plain,
        "fast filter": replace(plain, wind_filter=0.05),
        "no filter": replace(plain, wind_filter=0.0),
    }
    asked = replace(design.settings, law="paper")
    found["paper"] = designed_law(turbine, asked, models)
    linear = replace(asked, ramp_shape="linear", ramp_placement=0.25)
    return {**found, "linear ramp": designed_law(turbine, linear, models)}


LAWS = ("coherent", "fast filter", "no filter", "paper", "linear ramp")
# They differ from the first and the fourth by a number or a curve.
VARIANTS = ("fast filter", "no filter", "linear ramp")


class Seen(NamedTuple):
    """A sample of a walk; ``start`` is the first state where it is a choice."""

    start: list[float]
    measured: dict[str, float]
    command: Command
    later: Floats


def law_walks(law: Law, count: int, rng: Random) -> Iterator[list[Seen]]:
    """Yield walks of 25 samples of 20 ms: any wind, speeds around the trim and far from it."""
    for _ in range(count):
        mean, walk = rng.uniform(2.0, 27.0), []
        for k in range(25):
            wind, speed = mean + rng.gauss(0, 1), rng.uniform(0.6, 1.45)
            measured = Measurement(speed, rng.uniform(-0.05, 0.45), wind)
            start: list[float] = []
            if k == 0 and law.name == "coherent":
                state = law.initial_state(wind)
            elif k == 0:
                # From anywhere: the start is a choice, not a part of the law.
                start = [rng.uniform(-6, 1) for _ in law.state_names]
                state = np.array(start)
            command, state = sampled(law, state, measured, 0.02)
            given = {"speed": speed, "pitch": measured.pitch, "wind_estimate": wind}
            walk.append(Seen(start, given, command, state))
        yield walk


@pytest.fixture(scope="module")
def laws(turbine_design: TurbineDesign) -> Mapping[str, Law]:
    return laws_of(turbine_design)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in VARIANTS)) for name in LAWS]
)
def test_a_turbine_s_law_sample_by_sample(
    name: str, laws: Mapping[str, Law], turbine_design: TurbineDesign, tmp_path: Path
) -> None:
    """Winds from below cut-in to above cut-out, speeds around the trim and far from it."""
    law, top = laws[name], turbine_design.turbine.rated_torque
    run = controller(turbine_file(turbine_design, law, tmp_path), "law")
    kept, shut = [entry["name"] for entry in run.parts[0]["keep"]], 0
    for walk in law_walks(law, 12, Random(5)):
        run.kept = [dict(zip(kept, walk[0].start, strict=True)) if walk[0].start else {}]
        for seen in walk:
            sent = run.sample(0.02, **seen.measured)
            assert sent["torque"] == pytest.approx(seen.command.torque, abs=1e-9 * top)
            assert sent["pitch_reference"] == pytest.approx(seen.command.pitch, abs=1e-9)
            shut += seen.command.torque in (0.0, top)
            ours = [run.kept[0][one] for one in kept]
            assert ours == pytest.approx(seen.later[: len(ours)].tolist(), rel=1e-9, abs=1e-9)
    assert shut > 20


def test_near_the_trim_where_secants_become_slopes(
    laws: Mapping[str, Law], turbine_design: TurbineDesign, tmp_path: Path
) -> None:
    """Speed and pitch within 1e-12 to 1e-3 of the trim, at and between the nodes of the table."""
    law = laws["paper"]
    run = controller(turbine_file(turbine_design, law, tmp_path), "law")
    point, rng = turbine_design.turbine, Random(9)
    for wind in (4.5, 8.0, 11.4, 13.25, 20.1):
        at = trim(point, wind)
        for size in (0.0, 1e-12, 1e-7, 5e-5, 2e-4, 1e-3):
            speed = at.rotor_speed + size * rng.uniform(-1, 1)
            pitch = at.pitch + size * rng.uniform(-1, 1)
            run.kept = [{"x": -2.0}]
            command = law.command(np.array([-2.0]), Measurement(speed, pitch, wind))
            sent = run.sample(0.02, speed=speed, pitch=pitch, wind_estimate=wind)
            assert sent["torque"] == pytest.approx(command.torque, abs=1e-9 * point.rated_torque)
            assert sent["pitch_reference"] == pytest.approx(command.pitch, abs=1e-9)


def test_the_whole_controller_in_its_order(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    """Low-pass, observer, law, rate limits: as ``takagi simulate`` runs them, sample by sample."""
    T, rng = 0.01, Random(7)
    path = tmp_path / "gains.json"
    path.write_text(dump_gains(gain_file(turbine_design)), encoding="utf-8")
    run, law = controller(path), PythonLaw(turbine_design, T)
    speed, pitch, guess, moved = 1.2, 0.05, 13.0, 0
    for k in range(150):
        command = law.sample(speed, pitch, guess)
        sent = run.sample(T, measured_speed=speed, pitch=pitch, wind_guess=guess)

        assert sent["wind_estimate"] == pytest.approx(law.estimate, rel=1e-9)
        assert sent["torque_sent"] == pytest.approx(command.torque, rel=1e-9)
        assert sent["pitch_sent"] == pytest.approx(command.pitch, rel=1e-9, abs=1e-9)
        moved += sent["pitch_sent"] != sent["pitch_reference"]
        # Far enough that the estimate runs into both of its limits.
        speed, pitch = (
            speed + (0.02 if k < 75 else -0.03),
            max(0.0, pitch + rng.uniform(-1, 1) / 50),
        )
    assert moved > 3
