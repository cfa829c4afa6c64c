"""Claims of kind ``tracking``: outputs follow references; thresholds, forgeries, simulations."""

from __future__ import annotations

import copy
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.cross_check import Refusal, judge_document
from takagi.certificates.design.plant import PlantDesign, certify_plant, design_plant
from takagi.certificates.document.certificate_file import dumps
from takagi.models import ModelError, Plant, load_model
from takagi.models.plant import PlantSettings
from tests.certificates.kinds.test_damage import resealed

Data = dict[str, Any]
# An arm in gravity: what holds it at an angle depends on the angle and on its mass.
ARM = """
format = 1
kind = "plant"
name = "arm"

[states]
q = { unit = "deg", range = [-60, 60] }
w = { unit = "deg/s", range = [-180, 180] }

[inputs]
tau = { unit = "N m", range = [-15, 15] }

[parameters]
m = "[0.9, 1.1] kg"
l = { value = 0.5, unit = "m" }
g = { value = 9.81, unit = "m/s^2" }
c = { value = 0.5, unit = "N m s" }

[equations]
q = "w"
w = "(tau - c*w - m*g*l*sin(q))/(m*l^2)"

[outputs]
twice = { expression = "2*q", unit = "rad" }

[reference]
target = { follow = "q", range = [-30, 30], rate = 5 }
"""
GAINS = [[30.0, 6.0, 60.0]]


def plant_of(folder: Path, text: str = ARM) -> tuple[Plant, Path]:
    path = folder / "arm.toml"
    path.write_text(text, encoding="utf-8")
    plant = load_model(path)
    assert isinstance(plant, Plant)
    return plant, path


@cache
def arm() -> PlantDesign:
    with TemporaryDirectory() as folder:
        plant, path = plant_of(Path(folder))
        return certify_plant(plant, lambda model: np.array(GAINS * 1).reshape(1, 1, 3).repeat(
            len(model.A), axis=0), PlantSettings(), files=[path])  # fmt: skip


def claims() -> list[Data]:
    return [c for c in arm().document["claims"] if c["kind"] == "tracking"]


def changed(change: Callable[[Data], None], which: int = 1) -> Data:
    """The certificate with one of its claims about the reference, changed and sealed again."""
    found = copy.deepcopy(dict(arm().document))
    kept = [c for c in found["claims"] if c["kind"] == "tracking"][which]
    found["claims"] = [c for c in found["claims"] if c["kind"] == "secant-embedding"] + [kept]
    change(found)
    return resealed(found)


def verdicts(document: Data) -> list[str]:
    try:
        return [claim.verdict.name for claim in check_document(document).claims]
    except CertificateError:
        return ["REFUSED"]


def second(document: Data) -> list[str]:
    try:
        return [opinion.verdict for opinion in judge_document(document)]
    except Refusal:
        return ["REFUSED"]


def test_both_checkers_prove_that_the_arm_follows() -> None:
    for which in (0, 1):
        document = changed(lambda _: None, which)
        assert verdicts(document) == ["PROVED", "PROVED"]
        assert second(document) == ["PROVED", "PROVED"]
    words = check_document(document).claims[1].text
    assert "constant m in [0.9, 1.1] kg the loop has one rest with no error" in words
    assert "while |target'| <= 0.08727" in words


def wrong(name: str, factor: float) -> Callable[[Data], None]:
    """A number of the claim, or all of them, times a factor."""

    def change(document: Data) -> None:
        claim = document["claims"][1]
        value = claim[name]
        if isinstance(value, list):
            claim[name] = (np.array(value, dtype=float) * factor).tolist()
        else:
            claim[name] = float(value) * factor

    return change


def no_gravity(document: Data) -> None:
    """The plant's equation without gravity: the vertices are not its slopes."""
    document["model"]["equations"][1] = "(tau - c*w)/(m*l^2)"


def other_law(document: Data) -> None:
    """A law that integrates something else than the model says."""
    document["gains"]["references"][0]["follow"] = "2*q"


def other_output(document: Data) -> None:
    """Both say that 2 q follows, though q is integrated."""
    for owner in ("model", "gains"):
        document[owner]["references"][0]["follow"] = "2*q"


def uncertain_reference(document: Data) -> None:
    """The mass is named as the reference."""
    for owner in ("model", "gains"):
        document[owner]["references"][0]["reference"] = "m"


def wider_reference(document: Data) -> None:
    for v in document["model"]["disturbances"]:
        if v["name"] == "target":
            v["range"] = [-1, 1]


def narrower_input(document: Data) -> None:
    document["model"]["inputs"][0]["range"] = [-3, 3]


def two_gains(document: Data) -> None:
    document["gains"]["K"] = [document["gains"]["K"][0], [[30, 6, 61]]]


def flipped(document: Data) -> None:
    """An indefinite P."""
    document["claims"][1]["P"][0][0] *= -1


def asymmetric(document: Data) -> None:
    document["claims"][1]["P"][0][1] *= 1.01


@pytest.mark.parametrize(
    "damage",
    [
        wrong("decay_rate", 1.5),
        wrong("radius", 1.01),
        wrong("radius", 0.3),
        wrong("rates", 3),
        wrong("residuals", 0.8),
        wrong("residual_norm", 0.9),
        wrong("slope_norms", 0.99),
        wrong("error_factors", 0.99),
        wrong("slope", 1.5),
        wrong("slope", 0.0),
        wrong("decay_rate", -1),
        wrong("error_factors", -1),
        no_gravity,
        other_law,
        other_output,
        uncertain_reference,
        wider_reference,
        narrower_input,
        two_gains,
        flipped,
        asymmetric,
    ],
)
def test_a_forged_claim_is_not_proved(damage: Callable[[Data], None]) -> None:
    document = changed(damage)

    assert verdicts(document)[-1] != "PROVED"
    assert second(document)[-1] != "PROVED"


def test_simulations_keep_the_bounds() -> None:
    """Ramps at the proved rate, and jumps, with masses at the ends: integrated here again."""
    jumps, moving = claims()
    rest = moving["residual_norm"] / moving["decay_rate"]
    names = [v["name"] for v in arm().document["model"]["disturbances"]]
    place = names.index("target")
    push = moving["residual_norm"] + moving["slope_norms"][place] * moving["rates"][place]
    bound = moving["error_factors"][0] * push / moving["decay_rate"] + moving["residuals"][2]
    K = np.array(GAINS[0])

    def motion(mass: float, target: Callable[[float], float], end: float) -> Any:
        def slope(t: float, X: Any) -> list[float]:
            tau = float(-K @ X)
            J = mass * 0.25
            pull = mass * 9.81 * 0.5 * np.sin(X[0])
            return [X[1], (tau - 0.5 * X[1] - pull) / J, X[0] - target(t)]

        return solve_ivp(slope, (0, end), np.zeros(3), rtol=1e-9, atol=1e-10, max_step=0.02)

    rho = moving["rates"][place]
    jump = (jumps["radius"] - jumps["residual_norm"] / jumps["decay_rate"]) / jumps["slope_norms"][
        place
    ]
    jump = min(jump, 0.52)
    assert rho > 0.08 and rest >= 0 and jump > 0.05
    for mass in (0.9, 1.1):
        ramp = motion(mass, lambda t: rho * t, 6.0)
        late = ramp.t > 3
        assert np.abs(ramp.y[0] - rho * ramp.t)[late].max() <= bound
        step = motion(mass, lambda t: jump, 12.0)
        assert abs(step.y[0][-1] - jump) < 1e-4
        assert np.abs(step.y[0]).max() <= np.pi / 3
        assert np.abs(K @ step.y).max() <= 15


# x' = u, x follows r: A - B K has its poles where the numbers say, on paper.
PURE = """
format = 1
kind = "plant"
name = "integrator"
units = "unchecked"

[states]
x = { range = [-2, 2] }

[inputs]
u = { range = [-10, 10] }

[equations]
x = "u"

[reference]
r = { follow = "x", range = [-1, 1], rate = 0.1 }
"""


@cache
def pure() -> Data:
    """x' = -3 x - 2 xi, xi' = x - r: poles -1, -2; rests at (r, -3 r/2)."""
    with TemporaryDirectory() as folder:
        plant, _ = plant_of(Path(folder), PURE)
        design = certify_plant(plant, np.array([[[3.0, 2.0]]]), PlantSettings())
    return dict(design.document)


def at(**numbers: Any) -> Data:
    """The claim with V of the modes: P = T'T for T = [[1, 1], [1, 2]], rates 1 and 2."""
    found = copy.deepcopy(pure())
    claim = {
        "name": "x follows r",
        "kind": "tracking",
        "decay_rate": 1,
        "P": [[2, 3], [3, 5]],
        "radius": 0.2,
        "slope": [[1], [-1.5]],
        "residuals": [0, 0],
        "residual_norm": 0,
        "slope_norms": [2.0616],
        "rates": [0.09],
        "error_factors": [2.2361],
    } | numbers
    kept = [c for c in found["claims"] if c["kind"] == "secant-embedding"]
    found["claims"] = [*kept, claim]
    return resealed(found)


@pytest.mark.parametrize(
    ("numbers", "proved"),
    [
        ({}, True),
        # T A T^-1 is diagonal, so that V falls at 1 exactly.
        ({"decay_rate": 1.000001}, False),
        # D'PD = 2 - 9 + 45/4 = 17/4.
        ({"slope_norms": [2.0615]}, False),
        # alpha R = 0.2 is at least 2.0616 rho for rho up to 0.0970.
        ({"rates": [0.097]}, True),
        ({"rates": [0.0971]}, False),
        # P^-1 = [[5, -3], [-3, 2]]: x reaches sqrt(5) R beside 1, at most 2.
        ({"radius": 0.44721}, True),
        ({"radius": 0.44722}, False),
        # C = (1, 0): c = sqrt(5) = 2.23607.
        ({"error_factors": [2.2360]}, False),
        # Another line leaves a residual: x' = -3 + 3.2 there.
        ({"slope": [[1], [-1.6]]}, False),
        ({"slope": [[1], [-1.6]], "slope_norms": [2.3], "residuals": [0.2, 0],
          "residual_norm": 0.29, "rates": [0], "radius": 0.4}, True),
        ({"slope": [[1], [-1.6]], "slope_norms": [2.3], "residuals": [0.2, 0],
          "residual_norm": 0.28, "rates": [0], "radius": 0.4}, False),
    ],
)  # fmt: skip
def test_thresholds_on_paper(numbers: Data, proved: bool) -> None:
    """Both sides of every number, by both checkers; the values are in the comments."""
    document = at(**numbers)

    assert (verdicts(document)[-1] == "PROVED") is proved
    assert (second(document)[-1] == "PROVED") is proved


def read(model: Any) -> Any:
    return read_text(dumps({"model": model}), "model")["model"]


def test_the_plant_file_says_what_follows_what(tmp_path: Path) -> None:
    model = arm().document["model"]
    written = 'target = { follow = "q", range = [-30, 30], rate = 5 }'
    same = 'target = { follow = "q", range = [-0.523598775598, 0.523598775598], unit = "rad" }'
    for line in (written, same, written.replace("rate = 5", "rate = 6")):
        _, path = plant_of(tmp_path, ARM.replace(written, line))
        compare_plant(read(model), path)
    for line in (
        written.replace("-30, 30", "-31, 30"),
        written.replace('"q"', '"w"').replace("}", ', unit = "deg/s" }'),
        written.replace("target", "goal"),
    ):
        path = tmp_path / "other.toml"
        path.write_text(ARM.replace(written, line), encoding="utf-8")
        with pytest.raises(OtherModel):
            compare_plant(read(model), path)
    path.write_text(ARM.split("[reference]")[0], encoding="utf-8")
    with pytest.raises(OtherModel, match="references are none there, target in the certificate"):
        compare_plant(read(model), path)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ('follow = "q"', 'follow = "p"', "target.follow", "no state or output p"),
        ("[-30, 30]", "[30, -30]", "target.range", "smaller end first"),
        ("[-30, 30]", "[10, 30]", "target.range", "at rest q is 0 deg"),
        ("[-30, 30]", "[-30, 70]", "target.range", "target = 60 deg is the last that is held"),
        ("[-15, 15]", "[-2, 2]", "target.range", "outside its range [-2, 2] N m"),
        ("rate = 5", "rate = 0", "target.rate", "a rate > 0 is needed"),
        ("rate = 5", 'unit = "m"', "target.unit", "q is in deg"),
        ("rate = 5", "integral = false", "target.integral", "leave the field out"),
        ("target = {", "q = {", "q", "in [states] already"),
        ("target = {", 'other = { follow = "w", range = [-1, 1] }\ntarget = {', "reference",
         "2 references and 1 inputs"),
    ],
)  # fmt: skip
def test_a_wrong_reference_is_refused_at_its_place(
    tmp_path: Path, old: str, new: str, place: str, words: str
) -> None:
    assert old in ARM
    with pytest.raises(ModelError) as caught:
        plant_of(tmp_path, ARM.replace(old, new))
    assert place in str(caught.value)
    assert words in str(caught.value)


@pytest.mark.slow
def test_the_servo_of_the_library_is_proved() -> None:
    """Gains that are found, for every target and constant load torque, by both checkers."""
    plant = load_model("dc_servo")
    assert isinstance(plant, Plant)
    design = design_plant(plant)
    assert isinstance(design, PlantDesign)

    assert design.proved
    assert {opinion.verdict for opinion in judge_document(design.document)} == {"PROVED"}
    assert [c["kind"] for c in design.document["claims"]].count("tracking") == 2


def test_a_rate_too_fast_is_not_claimed_as_proved(tmp_path: Path) -> None:
    """At 500 deg/s nothing is proved: the claim stays open, beside a slower one that is proved."""
    plant, _ = plant_of(tmp_path, ARM.replace("rate = 5", "rate = 500"))
    gains = np.array(GAINS).reshape(1, 1, 3).repeat(4, axis=0)
    design = certify_plant(plant, gains, PlantSettings())
    found = [
        (claim["rates"][-1], checked.verdict.name)
        for claim, checked in zip(design.document["claims"], design.checked.claims, strict=True)
        if claim["kind"] == "tracking"
    ]

    assert not design.proved
    assert [verdict for _, verdict in found] == ["PROVED", "UNDECIDED", "PROVED"]
    assert 0 < found[2][0] < found[1][0] == pytest.approx(float(Fraction(500)) * np.pi / 180, 1e-3)
