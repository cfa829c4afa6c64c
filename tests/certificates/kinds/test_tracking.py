"""Outputs that follow references: what is proved, thresholds on paper, and plant files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
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
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.plant.constant_observer import ConstantObserver
from takagi.certificates.checker.replay.containment import of_the_plant
from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.document.certificate_file import dumps
from takagi.models import ModelError
from takagi.models.plant.design_settings import PlantSettings
from tests.certificates.kinds.claims import Data, verdicts
from tests.certificates.kinds.tracking_documents import (
    ARM,
    GAINS,
    arm,
    at,
    changed,
    claims,
    plant_of,
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
def test_a_rate_too_fast_is_not_claimed_as_proved(tmp_path: Path) -> None:
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


def test_what_follows_has_to_be_measured(tmp_path: Path) -> None:
    text = ARM.replace('name = "arm"', 'name = "arm"\nmeasured = ["w"]')
    with pytest.raises(ModelError, match="measure q too"):
        design_plant(plant_of(tmp_path, text)[0])


def test_references_behind_a_blend_need_its_proof() -> None:
    kinds = ["secant-embedding", "effort-blend", "tracking"]
    claim: Any = SimpleNamespace(shows=Verdict.PROVED)
    for reason in ("", "not shown"):
        outcomes = [Outcome(claim), Outcome(claim, reason), Outcome(claim)]
        assert bool(of_the_plant(outcomes, kinds, "here")[2].failure) is bool(reason)


def test_an_observer_is_refused_where_an_output_depends_on_an_input() -> None:
    """D = 0 is what the joint loop of the claim has; another D would be left out of it."""
    unit = Matrix.identity(1)
    observer = ConstantObserver(unit, unit, unit, unit, [0], [0])
    loop = PolytopicLoop((-unit,), B=(unit,), C=(unit,), D=(Matrix.zeros(1, 1),), K=(unit,))
    assert observer.joint(loop).A[0].shape == (2, 2)
    with pytest.raises(Refused, match="depends on an input"):
        observer.joint(replace(loop, D=(Matrix.zeros(1, 1), unit)))
