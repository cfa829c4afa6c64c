"""Plants as strangers write them, with a reference: each is proved, or told what to narrow."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.files.given_files import compare_model
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.design import certify_filed, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file
from tests.certificates.kinds.tracking_documents import plant_of

HEAD = 'format = 1\nkind = "plant"\n'

SERIES_MOTOR = """
name = "Series motor, torque K i^2"
measured = ["i", "w"]
[states]
i = { unit = "A", range = [0.5, 12], rest = "solve" }
w = { unit = "rad/s", range = [20, 150], rest = 80 }
[inputs]
V = { unit = "V", range = [0, 240], rest = "solve" }
[disturbances]
TL = { unit = "N m", range = [-0.3, 0.3] }
[parameters]
R = { value = 4, unit = "Ohm" }
L = { value = 50, unit = "mH" }
K = { value = 0.05, unit = "H" }
J = { value = 0.02, unit = "kg m^2" }
B = { value = 0.005, unit = "N m s" }
T0 = { value = 1, unit = "N m" }
[equations]
i = "(V - R*i - K*i*w)/L"
w = "(K*i^2 - B*w - T0 - TL)/J"
[reference]
wref = { follow = "w", range = [50, 110] }
"""

TWO_TANKS = """
name = "Two tanks, the lower level measured"
measured = ["h2"]
[states]
h1 = { unit = "m", range = [0.1, 0.8], rest = "solve" }
h2 = { unit = "m", range = [0.1, 0.6], rest = 0.3 }
[inputs]
q = { unit = "L/s", range = [0, 3], rest = "solve" }
[parameters]
A = { value = 0.02, unit = "m^2" }
a = { value = 0.0005, unit = "m^2" }
g = { value = 9.81, unit = "m/s^2" }
[equations]
h1 = "(q - a*sqrt(2*g*h1))/A"
h2 = "(a*sqrt(2*g*h1) - a*sqrt(2*g*h2))/A"
[reference]
wanted = { follow = "h2", range = [0.25, 0.35] }
"""


SQUARE = """
units = "unchecked"
[states]
x1 = { range = [0.17, 1.32], rest = 1 }
x2 = { range = [-5, 5] }
[inputs]
u = { range = [-20, 20], rest = 1 }
[equations]
x1 = "x2"
x2 = "-x1 - x2 + u"
[outputs]
y = { expression = "x1^2", unit = "-" }
[reference]
r = { follow = "y", range = [0.8, 1.2] }
"""

BUCK = """
name = "Buck converter with constant-power load"
[states]
i = { unit = "A", range = [0, 20], rest = "solve" }
v = { unit = "V", range = [8, 18], rest = 12 }
[inputs]
d = { unit = "-", range = [0, 1], rest = "solve" }
[disturbances]
P = { unit = "W", range = [20, 60], rest = 40 }
[parameters]
Vin = { value = 24, unit = "V" }
L = { value = 100, unit = "uH" }
C = { value = 1000, unit = "uF" }
R = { value = 10, unit = "Ohm" }
[equations]
i = "(Vin*d - v)/L"
v = "(i - v/R - P/v)/C"
[reference]
vref = { follow = "v", range = [10, 14] }
"""


@pytest.mark.slow
@pytest.mark.parametrize("plant", [TWO_TANKS, SQUARE, BUCK])
def test_the_output_follows(plant: str, tmp_path: Path, reduced: bool) -> None:
    if reduced and plant is BUCK:
        pytest.skip("takes half a minute: without TAKAGI_REDUCED")
    design = design_plant(plant_of(tmp_path, HEAD + plant)[0])

    assert isinstance(design, PlantDesign) and design.proved
    assert "tracking" in {claim["kind"] for claim in design.document["claims"]}


@pytest.mark.slow
def test_a_series_motor_is_proved_within_narrower_ranges(tmp_path: Path) -> None:
    """Within the ranges of the file the slope 2 K i varies 24-fold, and jumps are 0.56 rad/s."""
    plant, file = plant_of(tmp_path, HEAD + SERIES_MOTOR)
    design = design_plant(plant)
    assert isinstance(design, PlantDesign) and design.proved
    document = read_text(dumps(design.document), "certificate")
    claim = design.document["claims"][0]
    room = claim["radius"] - claim["residual_norm"] / claim["decay_rate"]
    assert room / claim["slope_norms"][1] > 5
    i = design.plant.states[0].range
    assert i is not None and 0.5 < i.lower < i.upper < 12

    assert "narrower ranges than the file's: i in" in compare_model(document, file)
    # Of a claim that does not say that states stay in their ranges, the ranges are the file's.
    with pytest.raises(OtherModel, match=r"states\.i\.range"):
        compare_model({**document, "claims": [*document["claims"], {"kind": "decay"}]}, file)
    wider = file.read_text(encoding="utf-8").replace("[0.5, 12]", "[3, 12]")
    file.write_text(wider, encoding="utf-8")
    with pytest.raises(OtherModel, match=r"states\.i\.range"):
        compare_model(document, file)

    gains = tmp_path / "gains.json"
    gains.write_text(dump_gains(plant_gain_file(design)), encoding="utf-8")
    again = certify_filed(plant, gains)
    assert again.proved


@pytest.mark.slow
def test_the_range_that_is_named_has_a_set(tmp_path: Path, reduced: bool) -> None:
    wide = BUCK.replace("[20, 60]", "[5, 80]").replace("[10, 14]", "[9, 17]")
    answer = design_plant(plant_of(tmp_path, HEAD + wide)[0])
    assert isinstance(answer, NoDesign)
    named = re.search(r"with P in (\[[^]]*\]) W;", answer.reason)
    assert named is not None
    if reduced:
        return
    design = design_plant(plant_of(tmp_path, HEAD + wide.replace("[5, 80]", named[1]))[0])
    assert isinstance(design, PlantDesign) and design.proved
