"""The claims that are refused are false, and those that are proved hold, along nonlinear plants."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.certificates.checker import check_document
from takagi.certificates.cross_check.opinion import judge_document
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.requests import FuzzyDecay, H2Norm, L2Gain, ObservedFeedback, ObserverError
from takagi.models import Interval, ModelError, Output, Plant, TSModel, Variable, sector_model
from takagi.models.blending.substitution import blended_model
from takagi.models.laws.pdc import PdcLaw
from tests.certificates.kinds.test_damage import resealed
from tests.certificates.weights.cells import EVIDENCE, cubic, plant_document, sampled, verdicts
from tests.models.blending.plants import ROOM, plant_of

Floats = NDArray[np.float64]
x, u, w = sp.symbols("x u w", real=True)


def motion(rate: Callable[[Floats], Floats], start: list[float], until: float) -> Floats:
    """Return the states at steps of 1 ms, by the classical Runge-Kutta method."""
    step, state = 1e-3, np.array(start)
    found = [state]
    for _ in range(round(until / step)):
        a = rate(state)
        b = rate(state + step / 2 * a)
        c = rate(state + step / 2 * b)
        d = rate(state + step * c)
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
        found.append(state)
    return np.array(found)


def slope(at: float) -> float:
    """Return the slope of -x - x^3: what a premise of the secant embedding is at the state."""
    return -1 - 3 * at**2


def observed(state: Floats, force: float, gain: float) -> Floats:
    """Return (x', xhat') of the cubic with an observer that has the slope at the measured x."""
    at, estimate = state
    known = slope(at) * estimate + force + gain * (at - estimate)
    return np.array([-at - at**3 + force, known])


# ------------------------------------------------------------------ refused, and false


def test_an_observer_with_slopes_keeps_an_error() -> None:
    """Held at x = 0.9: V = (x - xhat)^2 tends to (2 x^3 / (1 + 3 x^2 + L))^2, not to 0.

    At rest e' = 2 x^3 - (1 + 3 x^2 + L) e, and e = 0.329: V = 0.108 where the claim says e^(-4t).
    """
    model = cubic("secants")
    rate = 1.998
    claim = {"kind": "observer", "P": [[1]], "decay_rate": rate, "L": [[[1]]]}
    held = 0.9 + 0.9**3

    path = motion(lambda state: observed(state, held, 1.0), [0.9, 0.0], 5.0)

    V = (path[:, 0] - path[:, 1]) ** 2
    assert V[-1] == pytest.approx(0.108, abs=5e-4)
    assert V[-1] > 1e6 * 0.81 * np.exp(-2 * rate * 5.0)
    first, second = verdicts(plant_document(model, claim))
    assert first[0] == second[0] == "REFUSED"
    assert "averages of slopes" in first[1]
    with pytest.raises(ModelError, match="they cannot be evaluated; claim it of a sector model"):
        certify(model, claims=[ObserverError([[1.0]])])


def test_a_loop_through_such_an_observer_may_rise() -> None:
    """z = (x, e), P = diag(1, 100), K = L = 1: at (0.9, 0.3) V rises, where V' < -V is claimed."""
    model = cubic("secants")
    claim = {"kind": "observed-feedback", "P": [[1, 0], [0, 100]], "decay_rate": 0.5}
    claim |= {"L": [[[1]]]}

    def V(state: Floats) -> Any:
        return state[0] ** 2 + 100 * (state[0] - state[1]) ** 2

    def rate(state: Floats) -> Floats:
        return observed(state, -state[1], 1.0)

    start = np.array([0.9, 0.6])
    assert V(start + 1e-4 * rate(start)) > V(start)
    # The inequalities hold at every corner of the slopes, which is what made it a false proof.
    for a in (-4.0, -1.0):
        G = np.array([[a - 1, 1.0], [0.0, a - 1]])
        P = np.diag([1.0, 100.0])
        assert np.linalg.eigvalsh(P @ G + G.T @ P + P).max() < 0
    first, second = verdicts(plant_document(model, claim, [[[1.0]]]))
    assert first[0] == second[0] == "REFUSED"
    with pytest.raises(ModelError, match="an observer needs the weights"):
        certify(model, [[1.0]], claims=[ObservedFeedback([[1.0]])])


def test_an_observer_of_a_plant_with_one_A_needs_no_weights() -> None:
    """x' = -x + u + (1 + w^2) w: only what the disturbance does is a blend, and it is left out."""
    plant = Plant(
        equations=(-x + u + w + w**3,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-"),),
        disturbances=(Variable(w, "-", Interval.of(-1, 1)),),
        outputs=(Output("y", x, "-"),),
    )
    # The premise depends on w, which is not measured; that the slopes are averages is no matter.
    claim = {"kind": "observer", "P": [[1]], "decay_rate": 1, "L": [[[1]]]}
    first, second = verdicts(plant_document(secant_model(plant), claim))

    assert first == second == ["PROVED", "UNDECIDED"]


def scheduled() -> tuple[TSModel, dict[str, Any]]:
    """Return x' = -10 x - x^3 by its slopes, and P(h) = 2 at slope -10 and 1 at slope -13."""
    plant = Plant(
        equations=(-10 * x - x**3,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        name="stiff",
    )
    claim = {"kind": "fuzzy-decay", "decay_rate": 1.99, "degrees": [1], "polya": 0}
    claim |= {"rates": [[22, 22]]}
    claim["P"] = [{"powers": [[1, 0]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[2]]}]
    return secant_model(plant), claim


def test_a_function_of_slopes_does_not_fall() -> None:
    """V = (2 - x^2) x^2 with h = x^2 at the state: V' = 0 at x = 1, with |h'| = 22 at most."""
    model, claim = scheduled()
    path = motion(lambda state: -10 * state - state**3, [1.0], 0.5)[:, 0]
    h = path**2
    V = (2 - h) * h

    assert np.abs(np.diff(h) / 1e-3).max() <= 22
    assert V[4] > V[0] * np.exp(-2 * 1.99 * 0.004) * 1.005
    # The inequality of the claim holds for the slope -10 - 3 h, which is what made it a proof.
    share = np.linspace(0, 1, 50)
    P = 2 - share
    assert np.all(2 * P * (10 + 3 * share) - 22 - 2 * 1.99 * P > 0)
    assert model.A.ravel().tolist() == [-13, -10]
    first, second = verdicts(plant_document(model, claim))
    assert first[0] == second[0] == "REFUSED"
    with pytest.raises(ModelError, match=r"P\(h\) needs the weights"):
        certify(model, claims=[FuzzyDecay(rate_bounds=22.0)])


def test_a_function_that_no_weight_moves_is_decay() -> None:
    model, claim = scheduled()
    still = claim | {"degrees": [0], "P": [{"powers": [[0, 0]], "matrix": [[1]]}]}

    first, second = verdicts(plant_document(model, still))

    assert first == second == ["PROVED", "PROVED"]


def test_an_output_by_rules_is_another_one_with_slopes() -> None:
    """x' = -x - x^3 + w, y = h_2 x: the energy of y is more than 0.3^2 times that of w.

    With h_2 = x^2, the place of the slope between its bounds: w = 2 brings x to 1, and y to w / 2.
    """
    model = cubic("secants")
    claim = {"kind": "l2-gain", "disturbance": "disturbances", "P": [[0.59]], "gain": 0.3}
    assert model.A.ravel().tolist() == [-4, -1]
    claim |= {"output": {"C": [[[1]], [[0]]]}}
    path = motion(lambda state: -state - state**3 + 2.0, [0.0], 8.0)[:, 0]

    energy = np.sum((path**2 * path) ** 2) / (4.0 * len(path))

    assert path.max() <= 1
    assert energy > 0.3**2 * 2
    for a, c in ((-1.0, 0.0), (-4.0, 1.0)):
        whole = np.array([[-2 * a * 0.59 - c / 0.3, -0.59], [-0.59, 0.3]])
        assert np.linalg.eigvalsh(whole).min() > 0
    first, second = verdicts(plant_document(model, claim))
    assert first[0] == second[0] == "REFUSED"
    with pytest.raises(ModelError, match="an output with a matrix for each rule"):
        certify(model, claims=[L2Gain(output=([[[1.0]], [[0.0]]],))])


def circular() -> tuple[TSModel, Floats]:
    """Return x' = x + (5 - u^2) u and gains for u = 0 and for |u| = 2."""
    z = sp.Symbol("z", real=True)
    model = sector_model(
        [x + (5 - u**2) * u],
        [x],
        [u],
        box={x: (-10, 10), u: (-2, 2)},
        matrices={"A": [[sp.Integer(1)]], "B": [[5 - z]]},
        premises={z: u**2},
        name="weak",
    )
    weak_at_rest = float(model.B[0, 0, 0]) > 3
    gains = np.array([[[0.3]], [[1.2]]] if weak_at_rest else [[[1.2]], [[0.3]]])
    return model, gains


def test_a_law_cannot_schedule_by_its_own_command() -> None:
    """Blends with the same u^2 in plant and law decay; the law as it is run does not."""
    model, gains = circular()
    law = PdcLaw(model, gains, np.zeros(1), np.zeros(1))

    command = float(law.command([6.5])[0])

    for h in np.linspace(0, 1, 50):
        K, B = np.tensordot([1 - h, h], gains, axes=1), np.tensordot([1 - h, h], model.B, axes=1)
        assert 1 - B @ K <= -0.19
    assert abs(command) <= 2
    assert 6.5 + (5 - command**2) * command > 4
    claim = {"kind": "decay", "P": [[1]], "decay_rate": 0.1}
    first, second = verdicts(plant_document(model, claim, gains))
    assert first == second == ["PROVED", "UNDECIDED"]
    one = plant_document(model, claim, [[1.2]])
    assert verdicts(one) == (["PROVED", "PROVED"], ["PROVED", "PROVED"])


def test_a_law_that_knows_the_noise_exceeds_the_variance() -> None:
    """x+ = x/2 + u + w with u = 0 or -x: by the sign of x w the mean of x^2 is 3.03, not 4/3.

    x+ = sign(w) (|x|/2 + |w|); with E|w| = sqrt(2/pi) = m the mean of |x| is 2 m, and that of x^2
    is (1 + 2 m^2) 4/3 = 3.03.  The certificate says what it takes for granted.
    """
    names = {"state_names": ["x [-]"], "input_names": ["u [-]"], "disturbance_names": ["w [-]"]}
    model = {"kind": "takagi-sugeno", "sample_time": 1, **names, "A": [[[0.5]]], "B": [[[1]]]}
    model |= {"C": [[[1]]], "E": [[[1]]]}
    law = {"name": "pdc", "sample_time": 1, **names, "K": [[[0]], [[1]]]}
    claim = {"name": "h2", "kind": "h2-norm", "disturbance": "disturbances", "norm": 1.16}
    document = certificate_document(
        model=model, gains=law, claims=[claim | {"P": [[1.34]]}], provenance={}
    )
    rng = np.random.default_rng(1)
    at, total = 0.0, 0.0
    for noise in rng.standard_normal(20_000):
        at = np.sign(noise) * (abs(at) / 2 + abs(noise))
        total += at**2

    assert total / 20_000 == pytest.approx(4 / 3 * (1 + 4 / np.pi), rel=0.05)
    found = check_document(document).claims[0]
    assert found.verdict is Verdict.PROVED
    assert "for weights that do not depend on the noise at the same instant" in found.text


def test_premises_that_are_the_noise_are_left_open_by_both() -> None:
    """x' = -(2 + w^2) x + w: the weights of the plant are the noise of the same instant."""
    plant = Plant(
        equations=(-(2 + w**2) * x + w,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        disturbances=(Variable(w, "-", Interval.of(-1, 1)),),
        outputs=(Output("y", x, "-"),),
    )
    claim = {"kind": "h2-norm", "disturbance": "disturbances", "P": [[1]], "norm": 3}
    for model in (sector_model(plant), secant_model(plant)):
        first, second = verdicts(plant_document(model, claim))
        assert first[-1] == second[-1] == "UNDECIDED"


# ------------------------------------------------------------------ blends


def test_a_blend_beside_a_table_is_proved_and_beside_secants_refused(tmp_path: Path) -> None:
    """The room of the blend's tests with its loss from a table; then with another form stated."""
    (tmp_path / "loss.csv").write_text("-1, 0.5\n-0.5, 0.45\n0, 0.4\n0.5, 0.45\n1, 0.5\n")
    table = '[tables]\nloss = { file = "loss.csv", arguments = [{ name = "x", unit = "-" }] }\n'
    plant = plant_of(
        tmp_path, ROOM.replace("a*x", "loss(x)*x").replace("[equations]", table + "[equations]")
    )
    model = blended_model(plant)
    whole = certify(model, [[4.0, 6.0]])
    kinds = [claim["kind"] for claim in whole.document["claims"]]
    place = kinds.index("effort-blend")

    assert whole.checked.claims[place].verdict is Verdict.PROVED
    assert judge_document(whole.document)[place].verdict in ("PROVED", "NOT REPLAYED")
    stated = deepcopy(dict(whole.document))
    stated["model"]["embedding"]["form"] = "secant"
    stated["claims"] = [
        {"name": "s", "kind": "secant-embedding"},
        stated["claims"][place],
    ]
    first, second = verdicts(resealed(stated))
    assert first[0] == second[0] == "REFUSED"


# ------------------------------------------------------------------ sampled bounds


@pytest.mark.parametrize("kind", sorted(kind for kind in EVIDENCE if "," not in kind))
def test_bounds_from_samples_prove_nothing(kind: str) -> None:
    """A peak of height 1 where samples see 0.1 at most: at x = 0.37 the plant is unstable."""
    model = sampled()
    claim = {"kind": kind, **EVIDENCE[kind]}
    document = plant_document(model, claim, [[1.0]])
    narrow = document["model"]["embedding"]["premises"][0] | {"lower": 0, "upper": 0.1}
    document["model"]["embedding"]["premises"][0] = narrow
    document["gains"]["premises"][0] = narrow
    first, second = verdicts(resealed(document))

    assert first[0] in ("UNDECIDED", "REFUSED")
    assert second[0] in ("UNDECIDED", "REFUSED")
    assert -1 + 3 * np.exp(0.0) > 0.5


# ------------------------------------------------------------------ proved, and true


@pytest.mark.parametrize("form", ["sector", "tables", "secants"])
def test_what_is_proved_holds_along_the_plant(form: str) -> None:
    """x' = -x - x^3 - 1.5 x + w from three starts, and from rest pushed by w = 0.5 cos(3 t)."""
    step = 1e-3
    for start in (-1.0, 0.4, 1.0):
        path = motion(lambda at: -2.5 * at - at**3, [start], 2.0)[:, 0]
        times = step * np.arange(len(path))
        # decay and transient with alpha = 1, the set of level 1, |u| <= 1.5.
        assert np.all(path**2 <= start**2 * np.exp(-2 * times) * (1 + 1e-9))
        assert np.abs(1.5 * path).max() <= 1.5
    push = 0.5 * np.cos(3 * step * np.arange(4001))
    at, driven = 0.0, [0.0]
    for force in push[:-1]:
        at += step * (-2.5 * at - at**3 + force)
        driven.append(at)
    y = np.array(driven)
    assert np.sum(y**2) <= np.sum(push**2)
    assert np.abs(y).max() <= 2 * 0.5
    gains = [[[1.0]], [[1.5]]]
    for kind in ("decay", "transient", "input-limits", "l2-gain", "peak"):
        document = plant_document(cubic(form), {"kind": kind, **EVIDENCE[kind]}, gains)
        assert check_document(document).verdict is Verdict.PROVED
        assert judge_document(document)[1].verdict == "PROVED"


def test_an_observer_with_measured_premises_loses_its_error() -> None:
    """x' = -(1 + x^2) x + u with h at the measured x: e' = -(1 + x^2 + L) e, wherever x is."""
    held = 0.9 + 0.9**3

    def rate(state: Floats) -> Floats:
        at, estimate = state
        a = -1 - at**2
        return np.array([a * at + held, a * estimate + held + at - estimate])

    path = motion(rate, [0.9, 0.0], 2.0)

    V = (path[:, 0] - path[:, 1]) ** 2
    assert np.all(V <= V[0] * np.exp(-2 * 2 * 1e-3 * np.arange(len(V))) * (1 + 1e-9))
    first, second = verdicts(plant_document(cubic(), {"kind": "observer", **EVIDENCE["observer"]}))
    assert first == second == ["PROVED", "PROVED"]


def test_white_noise_through_a_secant_embedding() -> None:
    """x' = -x - x^3 + noise: E V' = -2 x^2 - 2 x^4 + 1, so the mean of x^2 is at most 1/2."""
    certificate = certify(cubic("secants"), claims=[H2Norm(0.7072)])

    assert certificate.verdict is Verdict.PROVED
    rng = np.random.default_rng(2)
    at, total, step = np.zeros(400), 0.0, 2e-3
    for _ in range(5_000):
        at = at + step * (-at - at**3) + np.sqrt(step) * rng.standard_normal(400)
        total += float(np.mean(at**2))
    assert total / 5_000 <= 0.5
