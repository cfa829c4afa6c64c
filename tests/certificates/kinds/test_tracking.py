"""Outputs that follow references: what is proved, thresholds on paper, and plant files."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.containment import of_the_plant
from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.models import ModelError, Plant, load_model
from takagi.models.plant.design_settings import PlantSettings
from tests.certificates.kinds.claims import resealed, verdicts
from tests.certificates.kinds.tracking_documents import (
    ARM,
    GAINS,
    Data,
    arm,
    at,
    changed,
    claims,
    curved,
    of_outputs,
    plant_of,
    pure,
    pushed_by_a_square,
)


def test_the_arm_is_proved_to_follow() -> None:
    """Both claims about its reference beside each other, on the embedding that they share."""
    document = changed(lambda found: found.update(claims=[*found["claims"][:-1], *claims()]))
    embedding, *following = check_document(document).claims
    assert embedding.verdict is Verdict.PROVED
    assert [claim.verdict for claim in following] == [Verdict.PROVED] * 2
    words = following[1].text
    assert "constant m in [0.9, 1.1] kg the loop has one equilibrium with no error" in words
    assert "in a stated set" in words
    assert "while |target'| <= 0.08727" in words


def test_simulations_keep_the_bounds() -> None:
    """Ramps at the proved rate, and jumps, with masses at the ends: integrated here again."""
    jumps, moving = claims()
    rest = moving["residual_norm"] / moving["decay_rate"]
    names = [v["name"] for v in arm()["model"]["disturbances"]]
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
        ({"slope_norms": [2.5], "rates": [0.08]}, True),
        ({"slope_norms": [2.5], "rates": [0.080001]}, False),
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
    """Both sides of every number; the values are in the comments."""
    document = at(**numbers)

    assert (verdicts(document)[-1] == "PROVED") is proved


@pytest.mark.parametrize(
    ("ranges", "proved"),
    [
        # x' = u - x rests at u = r.  K P^-1 K' = 4: u moves by 2 R = 0.4 beside -1 and 1/2.
        ({"u": (-1.4, 0.9)}, True),
        ({"u": (-1.3999, 0.9)}, False),
        ({"u": (-1.4, 0.8999)}, False),
        # x by sqrt(5) R = 0.44721 beside the same.
        ({"x": (-1.44722, 0.94722)}, True),
        ({"x": (-1.44721, 0.94722)}, False),
        ({"x": (-1.44722, 0.94721)}, False),
        # No room at all, or less: where it rests is beyond its range.
        ({"x": (-1, 0.5)}, False),
        ({"u": (-0.9, 0.4)}, False),
        ({"u": (-2, 0.4)}, False),
        ({"x": None, "u": None}, True),
    ],
)
def test_ranges_on_paper(ranges: Data, proved: bool) -> None:
    """The set lies in the ranges beside every rest, and the references reach from -1 to 1/2."""
    document = at(pure(drift="(-x)", slope="-1", r=(-1, 0.5), **ranges))

    assert (verdicts(document)[-1] == "PROVED") is proved


@pytest.mark.parametrize(
    ("observer", "proved"),
    [
        ({}, True),
        # Without L the estimate follows nothing: s' = u.
        ({"L": [[0]]}, False),
        # What follows, x, is not measured.
        ({"measured": ["other"]}, False),
        # Matrices of another shape, another kind of observer, an output that is not there.
        ({"A": [[0, 1]]}, False),
        ({"weights": "measured"}, False),
        ({"measured": ["z"]}, False),
    ],
)
def test_an_observer_beside_the_integral_on_paper(observer: Data, proved: bool) -> None:
    document = of_outputs(**observer)

    assert (verdicts(document)[-1] == "PROVED") is proved


def test_of_a_law_of_outputs_nothing_is_claimed_that_needs_its_states() -> None:
    document = of_outputs()
    decay = {"name": "decay", "kind": "decay", "decay_rate": 0, "P": [[2, 3], [3, 5]]}
    document["claims"] += [decay, {"name": "embedding", "kind": "secant-embedding"}]
    document = resealed(document)

    assert verdicts(document) == ["REFUSED"]


@pytest.mark.parametrize(
    ("numbers", "proved"),
    [
        ({}, True),
        # d_w = |(0, w)|_P = sqrt(5) at w = 1.
        ({"slope_norms": [2.0616, 2.236]}, False),
        ({"curvature": [[0, 0, 0], [0, 0, 0.49]]}, False),
        # A line leaves w^2 up to 1, which |z|_P <= 0.2 does not hold.
        ({"curvature": None}, False),
        # u gets 2 xi = w^2 beside 0.4 r-free: 2 R + 1 of 1.41.
        ({"radius": 0.205}, True),
        # V' + 2 V <= u e^2 with u = P_11 + ...: (P M + M'P + 2 alpha P, P; P, u) >= 0.
        ({"decay_rate": 0.5, "residuals": [0.01, 0], "residual_norm": 0.08,
          "residual_weights": [64, 64]}, True),
        ({"decay_rate": 0.5, "residuals": [0.01, 0], "residual_norm": 0.039,
          "residual_weights": [64, 64]}, False),
        ({"decay_rate": 0.5, "residuals": [0.01, 0], "residual_norm": 0.08,
          "residual_weights": [1, 1]}, False),
    ],
)  # fmt: skip
def test_a_curved_line_and_weighted_residuals_on_paper(numbers: Data, proved: bool) -> None:
    document = pushed_by_a_square(**numbers)

    assert (verdicts(document)[-1] == "PROVED") is proved


def test_a_set_without_room_needs_no_more_than_none() -> None:
    """A radius of 1e-9 beside rests that end 1e-6 from the range; and 0 from it."""
    still = {"radius": 1e-9, "rates": [0]}
    for end, proved in ((1.000001, True), (1, False), (0.999999, False)):
        document = at(pure(x=(-end, 2)), **still)
        assert (verdicts(document)[-1] == "PROVED") is proved


def test_a_shape_that_sees_nothing_proves_nothing() -> None:
    """P = diag(1, 0) meets every inequality of a loop whose integral does nothing.

    With K = (3, 0) x rests at 0 whatever r is: "one equilibrium with no error" is false.
    """
    document = at(
        pure(x=None, u=None), P=[[1, 0], [0, 0]], slope=[[0], [0]], residuals=[0, 1],
        residual_norm=0, slope_norms=[0], error_factors=[1],
    )  # fmt: skip
    document["gains"]["K"] = [[[3, 0]]]

    assert verdicts(resealed(document)) == ["PROVED", "UNDECIDED"]


def test_slopes_that_differ_need_one_gain() -> None:
    """The law does not know where between its vertices the mean slope lies.

    On the line x = r, u = 0 the cube is left: |r^3/100| <= 0.01, and sqrt(2) 0.01 = 0.01415.
    """
    numbers = {"decay_rate": 0.7, "residuals": [0.01, 0], "residual_norm": 0.01415}
    whole = at(curved(), **numbers, rates=[0], radius=0.4)
    assert verdicts(whole) == ["PROVED", "PROVED"]
    for k in (0, 1):
        other = copy.deepcopy(whole)
        other["gains"]["K"][k] = [[3.01, 2]]
        assert "PROVED" not in verdicts(resealed(other))[-1:]
    for name, value in (("residuals", [0.0099, 0]), ("residual_norm", 0.01414)):
        document = at(curved(), **numbers | {name: value}, rates=[0], radius=0.4)
        assert verdicts(document) == ["PROVED", "UNDECIDED"]


def test_the_sentence_rounds_to_the_safe_side() -> None:
    """P = diag of the modes at a rate just below 1; the integral of x - 0.9 r is off by 0.1."""
    text = check_document(at(decay_rate=0.99999996)).claims[-1].text
    assert "settles there as exp(-0.999999 t)" in text
    # Jumps: (0.2 - 0)/2.0616 = 0.09701.  At last: 2.2361 (0 + 2.0616 0.09) = 0.4149.
    text = check_document(at()).claims[-1].text
    assert "jumps of up to 0.09701 - in r" in text
    assert "while |r'| <= 0.09 the error settles to at most 0.4149 - for r" in text
    # e = sqrt(5) 0.1, d = 0.9 sqrt(17/4): 2.2361 (0.22361 + 1.8555 0.03) + 0.1 = 0.7245, and
    # (0.3 - 0.22361)/1.8555 = 0.04116.
    off: Data = {"slope": [[0.9], [-1.35]], "residuals": [0, 0.1], "residual_norm": 0.22361}
    document = at(**off, slope_norms=[1.8555], rates=[0.03], radius=0.3)
    assert verdicts(document) == ["PROVED", "PROVED"]
    text = check_document(document).claims[-1].text
    assert "settles to at most 0.7245 - for r" in text and "up to 0.04116 - in r" in text


def read(model: Any) -> Any:
    return read_text(dumps({"model": model}), "model")["model"]


def test_the_plant_file_says_what_follows_what(tmp_path: Path) -> None:
    model = arm()["model"]
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
    """Gains that are found, for every target and constant load torque."""
    plant = load_model("dc_servo")
    assert isinstance(plant, Plant)
    design = design_plant(plant)
    assert isinstance(design, PlantDesign)

    assert design.proved
    assert [c["kind"] for c in design.document["claims"]].count("tracking") == 2


@pytest.mark.slow
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


UNSTABLE = """
format = 1
kind = "plant"
name = "integrator"
units = "unchecked"
[states]
x = { range = [-2, 2] }
z = { range = [-0.01, 0.01] }
[inputs]
u = { range = [-10, 10] }
[equations]
x = "u"
z = "5*z + x"
[reference]
r = { follow = "x", range = [-1, 1] }
"""


def test_an_integral_takes_no_name_of_the_file(tmp_path: Path) -> None:
    """An integral called z would hide that the file's z leaves its range."""
    named = json.loads(json.dumps(at()).replace('"xi"', '"z"').replace("xi [-]", "z [-]"))
    assert "PROVED" in verdicts(resealed(named))
    path = tmp_path / "plant.toml"
    path.write_text(UNSTABLE, encoding="utf-8")

    with pytest.raises(OtherModel, match="z is a quantity of the file"):
        compare_plant(read_text(json.dumps(named), "c")["model"], path, narrower=True)


SPRING = """
format = 1
kind = "plant"
name = "spring"
measured = ["x"]

[states]
x = { unit = "m", range = [-1, 1], rest = "solve" }
v = { unit = "m/s", range = [-4, 4] }

[inputs]
F = { unit = "N", range = [-20, 20], rest = 0.7 }

[disturbances]
wind = { unit = "N", range = [-0.3, 0.3] }

[equations]
x = "v"
v = "F + wind - 2*x - 0.4*x^3 - 0.5*v"

[reference]
r = { follow = "x", range = [0, 0.5] }
"""


def spring(folder: Path, *changes: tuple[str, str]) -> Plant:
    text = 'units = "unchecked"\n' + SPRING
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return plant_of(folder, text)[0]


def test_what_follows_has_to_be_measured(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="measure x too"):
        design_plant(spring(tmp_path, ('measured = ["x"]', 'measured = ["v"]')))


@pytest.mark.slow
def test_an_angle_is_followed_though_the_rate_is_not_measured(tmp_path: Path) -> None:
    """A stranger's first servo: plant, integral and observer are proved as one."""
    text = SPRING.replace('measured = ["x"]', 'measured = ["x"]\nunits = "unchecked"')
    text = text.replace(', rest = "solve"', "").replace(", rest = 0.7", "")
    text = text.replace(" - 0.4*x^3", "").replace("range = [0, 0.5]", "range = [-0.5, 0.5]")
    design = design_plant(plant_of(tmp_path, text)[0])
    assert isinstance(design, PlantDesign)
    document: dict[str, Any] = dict(design.document)

    assert design.proved
    assert "tracking" in {claim["kind"] for claim in document["claims"]}
    document = copy.deepcopy(document)
    document["gains"]["observer"]["L"] = (-np.array(document["gains"]["observer"]["L"])).tolist()
    assert "PROVED" not in verdicts(resealed(document))


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
        wrong("radius", 0.01),
        wrong("rates", 100),
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


def sampled(document: Data) -> None:
    """The same matrices, of x(t + 1)."""
    document["model"]["sample_time"] = document["gains"]["sample_time"] = 1


def implicit(document: Data) -> None:
    document["model"]["mass"] = [["1", "0"], ["0", "1"]]


def of_sectors(document: Data) -> None:
    del document["model"]["embedding"]["form"]
    document["claims"][0]["kind"] = "sector-embedding"


def of_a_ball(document: Data) -> None:
    """A number that no decimal is: a parameter that no equation has."""
    ball = {"value": 1.4142135, "within": "1e-7", "equals": "sqrt(2)"}
    document["model"]["parameters"]["c"] = ball


def nearly_at_rest(document: Data) -> None:
    """Within the slack of other claims; here rests are those that the law has."""
    document["gains"]["trim"]["state"] = [1e-13, 0]


def without_law(document: Data) -> None:
    document["gains"] = None


def of_matrices(document: Data) -> None:
    document["model"]["kind"] = "takagi-sugeno"


@pytest.mark.parametrize(
    "change",
    [sampled, implicit, of_sectors, of_a_ball, nearly_at_rest, without_law, of_matrices],
)
def test_claims_about_other_loops_are_refused(change: Callable[[Data], None]) -> None:
    document = at()
    change(document)

    assert verdicts(resealed(document)) == ["REFUSED"]


def test_references_behind_a_blend_need_its_proof() -> None:
    kinds = ["secant-embedding", "effort-blend", "tracking"]
    claim: Any = SimpleNamespace(shows=Verdict.PROVED)
    for reason in ("", "not shown"):
        outcomes = [Outcome(claim), Outcome(claim, reason), Outcome(claim)]
        assert bool(of_the_plant(outcomes, kinds, "here")[2].failure) is bool(reason)
