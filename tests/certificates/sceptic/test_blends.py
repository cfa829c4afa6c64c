"""Claims about a blend that only one line of the checker keeps from being proved."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import read_text
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.design.plant.design import certify_plant
from takagi.models.plant.design_settings import PlantSettings
from tests.certificates.blend.test_effort_blend import GAIN, blend, changed, design
from tests.certificates.kinds.claims import verdicts
from tests.models.blending.plants import ROOM, plant_of

Data = dict[str, Any]


def one_error_for_both(document: Data) -> None:
    """Both actuators wrong alike, which is less than each by itself."""
    blend(document, high__error="cooling_error")
    rows = document["model"]["equations"]
    rows[0] = rows[0].replace("heating_error", "cooling_error")


def another_effort(document: Data) -> None:
    """The effort leaks, which no law with an integrated effort does."""
    document["model"]["equations"][1] = "effort_rate - effort"


def coupled_mass(document: Data) -> None:
    document["model"]["mass"] = [["1", "0.1"], ["0", "1"]]


def mass_of_the_effort(document: Data) -> None:
    document["model"]["mass"] = [["1", "0"], ["0", "2"]]


def in_steps(document: Data) -> None:
    document["model"]["sample_time"] = 0.1


def idle_inside(top: float) -> Callable[[Data], None]:
    """Heating that idles at 0 of [-1, top]: what lies below 0 is no room for it."""
    return lambda document: blend(document, high__range=[-1, top])


def error_off_rest(document: Data) -> None:
    """An error whose rest is not "as told"."""
    signal = next(s for s in document["model"]["disturbances"] if s["name"] == "heating_error")
    signal |= {"rest": 0.1, "symbol": "delta_error"}


def name_of_a_parameter(document: Data) -> None:
    """An actuator under the name of a parameter, which the equation would then read as either."""
    blend(document, low__input="a", equations=["0.5*x - 2*a + heating*(x + 2)"])


FALSE: dict[str, Callable[[Data], None]] = {
    "one error for both": one_error_for_both,
    "an effort that leaks": another_effort,
    "a mass between effort and state": coupled_mass,
    "a mass of the effort": mass_of_the_effort,
    "a sampled effort": in_steps,
    "room on the wrong side of idling": idle_inside(2.9999),
    "a name that is taken": name_of_a_parameter,
    "an error that rests elsewhere": error_off_rest,
}


@pytest.mark.parametrize("name", FALSE)
def test_a_blend_of_something_else_is_not_proved(name: str) -> None:
    assert verdicts(changed(FALSE[name]))[-1] != "PROVED"


def test_room_beside_idling_is_enough() -> None:
    """The other side of the limit above."""
    assert verdicts(changed(idle_inside(3)))[-1] == "PROVED"


def test_a_file_whose_actuator_idles_elsewhere_is_told_apart(tmp_path: Path) -> None:
    """The equations as written are the same; what the law commands is not."""
    model = read_text(json.dumps(design().document["model"]), "model")
    path = tmp_path / "room.toml"
    old, new = "heating = { range = [0, 3] }", "heating = { range = [0, 3], rest = 0.1 }"
    path.write_text(ROOM.replace(old, new), encoding="utf-8")

    with pytest.raises(CertificateError, match="the rest of heating is 0.1 there"):
        compare_plant(model, path)


def test_a_file_with_an_error_that_the_certificate_leaves_out_is_told_apart(tmp_path: Path) -> None:
    """Heating as told in the certificate, a fifth off in the file."""
    exact = plant_of(tmp_path, error='"2 + x", error = 0.2 -> "2 + x"')
    told = certify_plant(exact, lambda model: np.array([GAIN] * len(model.A)), PlantSettings())
    model = read_text(json.dumps(told.document["model"]), "model")
    path = tmp_path / "room.toml"
    assert compare_plant(model, path) == ""

    path.write_text(ROOM, encoding="utf-8")

    with pytest.raises(CertificateError, match=r"blending\.high\.error is 0\.2 there"):
        compare_plant(model, path)
