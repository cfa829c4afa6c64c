"""A controller with states of its own: the double integrator, of which the position is measured.

No static gain on x settles x'' = u (its poles sum to 0), and a controller of order 1 does.
Certificates of it that are changed by hand must be refused.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from takagi.certificates import CertificateError
from takagi.certificates.checker import check
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.static_gains import with_integrators
from takagi.certificates.document.certificate_file import dumps
from takagi.models import ModelError
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_files.loader import load_plant
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file
from tests.certificates.kinds.claims import Data, resealed
from tests.reports.code.compiled import Compiled

pytestmark = pytest.mark.numeric

HEAD = 'format = 1\nkind = "plant"\nname = "Double integrator"\n'
PLANT = """
measured = ["x"]

[states]
x = { unit = "m", range = [-1, 1] }
v = { unit = "m/s", range = [-2, 2] }

[inputs]
u = { unit = "N", range = [-5, 5] }

[parameters]
m = { value = 1, unit = "kg" }

[equations]
x = "v"
v = "u/m"
"""
ORDER = "\n[design]\ncontroller = { order = 1 }\n"
# u = -6.75 x + 5.25 c, c' = 6 x - 6 c by hand: the poles are those of s^3 + 6 s^2 + 6.75 s + 9.
GAIN = [[6.75, 0.0, -5.25], [-6.0, 0.0, 6.0]]
INTEGRATORS = [{"state": "controller_1", "rate": "controller_1_rate"}]


def filed(folder: Path, text: str = HEAD + PLANT + ORDER) -> Path:
    path = folder / "plant.toml"
    path.write_text(text, encoding="utf-8")
    return path


def settings(**wishes: Any) -> PlantSettings:
    asked: dict[str, Any] = {"feedback": ("x",), "order": 1}
    return PlantSettings(**asked | wishes)


@lru_cache
def certified(**wishes: Any) -> PlantDesign:
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        plant = load_plant(filed(Path(folder)))
    return certify_plant(plant, [GAIN], settings(**wishes))


def document() -> Data:
    return json.loads(dumps(certified().document))  # type: ignore[no-any-return]


def saved(document: Data, folder: Path) -> Path:
    path = folder / "certificate.json"
    path.write_text(dumps(document), encoding="utf-8")
    return path


def of_file(document: Data, folder: Path, text: str) -> None:
    check(saved(document, folder), model=filed(folder, text))


def test_the_loop_by_hand_has_its_slowest_pole() -> None:
    """The proved rate is below that of the characteristic polynomial, and near to it."""
    rate = -np.roots([1, 6, 6.75, 9]).real.max()
    claim = next(c for c in certified().document["claims"] if c["kind"] == "decay")

    assert certified().proved
    assert 0.9 * rate < claim["decay_rate"] < rate


def test_one_certificate_for_the_file_that_asks_for_it(tmp_path: Path) -> None:
    for text in (HEAD + PLANT + ORDER, HEAD + PLANT):
        of_file(document(), tmp_path, text)


SHIFTED = PLANT.replace("[states]", "[states]\ncontroller_1 = {}").replace(
    "[equations]", '[equations]\ncontroller_1 = "x/m"'
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PLANT + ORDER.replace("1", "2"), "its field controller is .*2.*, and the law has 1"),
        (PLANT + '\n[design]\ncontroller = "static"\n', "its field controller is static"),
        (PLANT.replace('["x"]', '["v"]') + ORDER, "outputs are 'v' there, 'x' in the"),
        (PLANT.replace("u/m", "2*u/m") + ORDER, "equations.v"),
        (PLANT.replace("[-5, 5]", "[-6, 6]") + ORDER, "inputs.u.range"),
        (SHIFTED, "controller_1 is a quantity of the file, and the controller's own"),
    ],
)
def test_another_file_is_refused(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(OtherModel, match=words):
        of_file(document(), tmp_path, HEAD + text)


def test_a_law_of_all_states_is_none_for_a_file_with_a_controller(tmp_path: Path) -> None:
    """Not for one that asks for a controller, also where its gains on v are zero."""
    plant = load_plant(filed(tmp_path))
    static = certify_plant(plant, [[[6.75, 0.0]]], settings(order=0))
    with pytest.raises(OtherModel, match="and the law has no states of its own"):
        of_file(json.loads(dumps(static.document)), tmp_path, HEAD + PLANT + ORDER)


def gain_on_speed(d: Data) -> None:
    d["gains"]["K"][0][1][1] = 1e-9


def test_a_gain_on_what_is_not_measured_is_refused_with_the_file(tmp_path: Path) -> None:
    forged = document()
    gain_on_speed(forged)
    with pytest.raises(OtherModel, match="the law has all states, the field measured lists x"):
        of_file(resealed(forged, "controller"), tmp_path, HEAD + PLANT + ORDER)


def in_both(change: Callable[[Any], Any]) -> Callable[[Data], None]:
    def changed(d: Data) -> None:
        for owner in ("model", "gains"):
            d[owner]["integrators"] = change(copy.deepcopy(INTEGRATORS))

    return changed


def test_states_that_the_law_does_not_keep_are_no_ones_of_the_file(tmp_path: Path) -> None:
    """Without the member the law is one of a plant with more states and inputs than the file's."""
    for owner, words in (("gains", "has other states"), ("", "states are 'x', 'v' there|are 'v'")):
        forged = document()
        for part in ("gains", "model") if not owner else (owner,):
            forged[part].pop("integrators")
        with pytest.raises(CertificateError, match=words):
            of_file(resealed(forged, "controller"), tmp_path, HEAD + PLANT)
    forged = document()
    forged.pop("gains")
    with pytest.raises(CertificateError, match="has other states"):
        of_file(resealed(forged, "controller"), tmp_path, HEAD + PLANT)


def test_a_state_of_the_plant_is_no_state_of_the_controller(tmp_path: Path) -> None:
    """x' = u is an integrator, and the plant's: the file has x, so that the law may not keep it."""
    text = (
        HEAD
        + PLANT.split("[states]")[0]
        + (
            '[states]\nx = { unit = "m", range = [-1, 1] }\n[inputs]\nu = { unit = "m/s" }\n'
            '[equations]\nx = "u"\n'
        )
    )
    plant = load_plant(filed(tmp_path, text))
    forged = json.loads(dumps(certify_plant(plant, [[[1.0]]], settings(order=0)).document))
    in_both(lambda _: [{"state": "x", "rate": "u"}])(forged)
    forged["model"].pop("model_file", None)
    with pytest.raises(OtherModel, match="x is a quantity of the file|x, u"):
        of_file(resealed(forged, "controller"), tmp_path, text)


def program(design: PlantDesign, folder: Path) -> ProgramRun:
    path = folder / "gains.json"
    path.write_text(dump_gains(plant_gain_file(design)), encoding="utf-8")
    return ProgramRun(read_controller(path))


def falling(_: float, z: Any, u: float) -> list[float]:
    return [z[1], u]


def test_the_program_is_the_proved_loop_in_samples(tmp_path: Path) -> None:
    """Its inputs are the measured ones; a simulation with held commands is the matrix power.

    x_c(t + T) = x_c + T v is what the plant with integrators does under a held v, so that the
    claim ``sampled-loop`` is about the program.
    """
    step = 0.1
    run = program(certified(sample_time=step), tmp_path)
    law = Compiled(run.program, tmp_path / "c")
    law.init(step)
    A, B = np.zeros((3, 3)), np.array([[0.0, 0], [1, 0], [0, 1]])
    A[0, 1] = 1.0
    whole = expm(step * np.block([[A, B], [np.zeros((2, 5))]]))[:3]
    loop = whole[:, :3] - whole[:, 3:] @ np.array(GAIN)
    kinds = [c["kind"] for c in certified(sample_time=step).document["claims"]]
    state, plant = np.array([0.1, 0.0, 0.0]), np.array([0.1, 0.0])

    assert certified(sample_time=step).proved and "sampled-loop" in kinds
    assert [signal.name for signal in run.program.inputs] == ["x"]
    for _ in range(80):
        sent = run.sample(step, {"x": plant[0]})
        assert law.step({"x": plant[0]}) == pytest.approx(sent) and list(sent) == ["u"]
        motion = solve_ivp(falling, (0, step), plant, args=(sent["u"],), rtol=1e-10, atol=1e-12)
        plant, state = motion.y[:, -1], loop @ state
        assert [*plant, run.kept["controller_1"]] == pytest.approx(list(state), abs=1e-8)
        assert law.kept() == pytest.approx(run.kept)
    assert abs(state[0]) < 1e-2


PENDULUM = """
measured = ["theta"]

[states]
theta = { unit = "rad", range = [-1, 1] }
omega = { unit = "rad/s", range = [-4, 4] }

[inputs]
a = { unit = "rad/s^2" }

[parameters]
k = { value = 4, unit = "1/s^2" }

[equations]
theta = "omega"
omega = "k*sin(theta) + a"
"""


def test_rules_of_their_own_need_premises_of_what_is_measured(tmp_path: Path) -> None:
    """Two rules of sin(theta)/theta: the program has their weights, and reads theta alone."""
    plant = load_plant(filed(tmp_path, HEAD + PENDULUM))
    K: list[Any] = [[[30.0, 0, -20], [-10, 0, 10]], [[31.0, 0, -20.5], [-10.2, 0, 10]]]
    design = certify_plant(plant, np.array(K), settings(feedback=("theta",)))
    run, law = program(design, tmp_path), design.law

    assert design.proved and law is not None and len(design.model.rules) == 2
    assert [signal.name for signal in run.program.inputs] == ["theta"]
    state = np.array([0.8, 0.0, 0.0])
    for _ in range(5):
        command = law.command(state)
        assert run.sample(0.01, {"theta": 0.8}) == pytest.approx({"a": command[0]})
        state[2] += 0.01 * command[1]
        assert run.kept["controller_1"] == pytest.approx(state[2])
    certificate = json.loads(dumps(design.document))
    of_file(certificate, tmp_path, HEAD + PENDULUM + ORDER)
    # The premise of the model may be of omega too; a law of theta alone does not know it.
    for part in (certificate["gains"]["premises"], certificate["model"]["embedding"]["premises"]):
        part[0]["expression"] = "sin(theta)/theta + 0*omega + omega - omega"
    with pytest.raises(OtherModel, match="the law has all states"):
        of_file(resealed(certificate, "controller"), tmp_path, HEAD + PENDULUM + ORDER)


def test_u_has_limits_and_the_rate_none(tmp_path: Path) -> None:
    run = program(certified(), tmp_path)

    assert run.sample(0.1, {"x": 50.0})["u"] == -5
    assert run.kept["controller_1"] == pytest.approx(0.1 * 6 * 50)


def test_discrete_time_keeps_the_rate_itself(tmp_path: Path) -> None:
    """x(t + T) = x + u of a position with a delay: x_c(t + T) = v."""
    text = HEAD.replace("name", "sample_time = 1\nname") + (
        'measured = ["y"]\n[states]\nx = { unit = "m", range = [-1, 1] }\n'
        'y = { unit = "m", range = [-1, 1] }\n[inputs]\nu = { unit = "m" }\n'
        '[equations]\nx = "x + u"\ny = "x"\n'
    )
    plant = load_plant(filed(tmp_path, text))
    asked = PlantSettings(feedback=("y",), order=1)
    design = certify_plant(plant, [[[0, 0.4, 0.3], [0, 0.2, 0.5]]], asked)
    run = program(design, tmp_path)

    assert design.proved
    assert run.sample(1.0, {"y": 1.0})["u"] == pytest.approx(-0.4)
    assert run.kept["controller_1"] == pytest.approx(-0.2)
    assert run.sample(1.0, {"y": 0.0})["u"] == pytest.approx(-0.3 * -0.2)
    of_file(json.loads(dumps(design.document)), tmp_path, text)


def test_no_controller_is_an_answer_with_what_to_try(tmp_path: Path) -> None:
    """x' = x is unstable and does not show in y: no controller of y settles it."""
    text = HEAD + (
        'measured = ["y"]\n[states]\nx = { unit = "m" }\ny = { unit = "m" }\n'
        '[inputs]\nu = { unit = "m/s" }\n[parameters]\na = { value = 1, unit = "1/s" }\n'
        '[equations]\nx = "a*x + u"\ny = "-a*y + u"\n'
    )
    answer = design_plant(load_plant(filed(tmp_path, text)), settings(feedback=("y",)))

    assert isinstance(answer, NoDesign)
    assert "found no controller of y with 1 state (no start led to stable rules)" in answer.reason
    assert "try a higher order than 1, or another state in measured" in answer.reason


def test_names_and_orders_that_do_not_fit(tmp_path: Path) -> None:
    plant = load_plant(filed(tmp_path))
    with pytest.raises(ModelError, match="has 2 states, and more are of no use"):
        with_integrators(plant, 3)
    taken = load_plant(filed(tmp_path, HEAD + PLANT.replace("m = {", "controller_1 = 1\nm = {")))
    with pytest.raises(ModelError, match="controller_1 is a name of the controller"):
        with_integrators(taken, 1)
    with pytest.raises(ModelError, match="largest decay rate is not sought"):
        design_plant(plant, settings(decay_rate="max"))
    with pytest.raises(ModelError, match="gain_bound beside a controller"):
        design_plant(plant, settings(gain_bound=5.0))
    with pytest.raises(ModelError, match="v2 is measured and is no state"):
        design_plant(plant, settings(feedback=("v2",)))


@pytest.mark.slow
def test_order_one_settles_what_no_static_law_does(tmp_path: Path) -> None:
    """Poles of x'' = -k x sum to 0; s^3 + a s^2 + b s + c = 0 has all that order 1 can want."""
    text = HEAD + re.sub(r", range = \[.*?\]", "", PLANT) + ORDER
    plant = load_plant(filed(tmp_path, text))

    static = design_plant(plant, settings(order=0))
    dynamic = design_plant(plant, settings())

    assert isinstance(static, NoDesign)
    assert isinstance(dynamic, PlantDesign) and dynamic.proved
    assert not np.any(np.asarray(dynamic.gains)[:, :, 1])
    of_file(json.loads(dumps(dynamic.document)), tmp_path, text)
