"""Mixed sensitivity: a textbook's gamma, an interpolation bound, frequency responses, a proof."""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import L2Gain
from takagi.lmi import (
    GeneralisedPlant,
    OutputFeedback,
    decide,
    exact_no,
    hinf_output_feedback,
    hinf_output_feedback_condition,
    mixed_sensitivity,
    objective_below,
)
from takagi.lmi.gains.output_feedback import controller
from takagi.lmi.gains.output_feedback.controller import augmented
from takagi.lmi.gains.output_feedback.generalised_plant import state_space
from takagi.models import ModelError, TSModel

s = control.tf("s")


def disturbance_process() -> Any:
    """Skogestad and Postlethwaite (2005), section 2.8: 200 / ((10 s + 1)(0.05 s + 1)^2)."""
    return 200 / ((10 * s + 1) * (0.05 * s + 1) ** 2)


def performance(order: int = 1) -> Any:
    """Section 2.8.3: M = 1.5, bandwidth 10 rad/s, A = 1e-4; the square of its root for order 2."""
    M, bandwidth, A = 1.5, 10.0, 1e-4
    if order == 1:
        return (s / M + bandwidth) / (s + bandwidth * A)
    return (s / M**0.5 + bandwidth) ** 2 / (s + bandwidth * A**0.5) ** 2


@pytest.fixture(scope="module")
def first() -> OutputFeedback:
    """The textbook's first design, S / K S with W_u = 1."""
    return mixed_sensitivity(disturbance_process(), performance(), 1.0)


def test_the_first_design_of_the_textbook_has_its_gamma(first: OutputFeedback) -> None:
    """Skogestad and Postlethwaite (2005), example 2.17: gamma = 1.37."""
    assert first.found and first.gain is not None
    assert first.gain == pytest.approx(1.37, abs=5e-3)
    assert first.gain <= 1.002 * first.lower_bound


def test_the_second_design_is_no_worse_than_the_textbooks() -> None:
    """The same with the square of the weight's root: gamma = 2.21 there, by a search."""
    found = mixed_sensitivity(disturbance_process(), performance(2), 1.0)

    assert found.gain is not None
    assert 2.15 < found.gain < 2.215


def test_the_gain_is_that_of_the_frequency_responses_themselves(first: OutputFeedback) -> None:
    """|W1 S|^2 + |K S|^2 from the transfer functions alone, on a dense grid: the same peak."""
    K = first.require()
    plant, weight = disturbance_process(), performance()
    worst = 0.0
    for w in np.logspace(-5, 4, 3000):
        G, W1 = plant(1j * w), weight(1j * w)
        k = K.response(w)[0, 0]
        S = 1 / (1 + G * k)
        worst = max(worst, float(np.hypot(abs(W1 * S), abs(k * S))))

    assert first.gain == pytest.approx(worst, rel=2e-3)


def test_a_controller_of_the_wrong_sign_does_not_stabilise(first: OutputFeedback) -> None:
    """K turned to -K: the closed loop has a pole on the right."""
    K = first.require()
    broken = type(K)(K.A, K.B, -K.C, -K.D)

    assert np.linalg.eigvals(first.plant.closed(K).A).real.max() < 0
    assert np.linalg.eigvals(first.plant.closed(broken).A).real.max() > 0


def test_a_zero_on_the_right_bounds_what_any_controller_does() -> None:
    """S(1) = 1 at a zero of G: |W1 S| >= |W1(1)| = 5 / 1.05, and nearly that where u costs little.

    Zames (1981), IEEE Trans. Automatic Control 26; Skogestad and Postlethwaite, section 5.7.
    """
    weight = 5 / (s + 0.05)
    least = 5 / 1.05

    cheap = mixed_sensitivity((1 - s) / (s + 2) ** 2, weight, 1e-3)
    dear = mixed_sensitivity((1 - s) / (s + 2) ** 2, weight, 1.0)

    assert cheap.gain is not None and dear.gain is not None
    assert least <= cheap.gain <= 1.02 * least
    assert largest_entry(cheap) < 1e5
    assert dear.gain > cheap.gain


def largest_entry(found: OutputFeedback) -> float:
    K = found.require()
    return max(float(np.abs(part).max(initial=0.0)) for part in (K.A, K.B, K.C, K.D))


@pytest.mark.slow
def test_a_controller_that_is_lost_to_rounding_is_found_another_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As on processors with other last bits: the central controller comes as near the bound."""

    def lost(*given: Any) -> Any:
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(controller, "controller_of", lost)
    found = mixed_sensitivity((1 - s) / (s + 2) ** 2, 5 / (s + 0.05), 1e-3)

    assert found.gain is not None and found.gain <= 1.001 * found.lower_bound
    assert largest_entry(found) < 1e5


@pytest.mark.parametrize(
    "plant",
    [
        # Nothing of u is weighed and no noise is in y, so the least norms are approached alone.
        GeneralisedPlant(
            A=np.array([[0.0, 1.0], [0.0, 0.0]]),
            B1=np.array([[0.0], [1.0]]),
            B2=np.array([[0.0], [1.0]]),
            C1=np.array([[1.0, 0.0]]),
            C2=np.array([[1.0, 0.0]]),
            D11=np.zeros((1, 1)),
            D12=np.zeros((1, 1)),
            D21=np.zeros((1, 1)),
        ),
        augmented(state_space("G", 1 / ((s - 1) * (s + 3))), {"W3": state_space("W3", 0.1)}),
        augmented(state_space("G", 1 / (s + 1) ** 2), {"W1": state_space("W1", 1 / (s + 0.1))}),
    ],
)
def test_a_singular_problem_has_moderate_entries_or_a_note(plant: GeneralisedPlant) -> None:
    """Also a norm that is asked for has the entries that it needs, and no more."""
    least = hinf_output_feedback(plant)
    assert least.gain is not None
    enough = hinf_output_feedback(plant, norm_below=2 * least.gain + 0.05)

    assert largest_entry(least) < 1e7 or "norm_below" in least.answer.note
    assert least.answer.note
    assert enough.gain is not None and enough.gain <= 2 * least.gain + 0.05
    assert largest_entry(enough) < 1e5


def test_a_norm_below_the_least_is_infeasible() -> None:
    """And one above it has a controller, of rows without rounding."""
    weights = (2 / (s + 0.1), 0.5)
    least = mixed_sensitivity(1 / (s + 1), *weights)
    none = mixed_sensitivity(1 / (s + 1), *weights, norm_below=0.98 * least.lower_bound)
    mild = mixed_sensitivity(1 / (s + 1), *weights, norm_below=1.1 * least.lower_bound)

    assert none.status == "infeasible" and none.controller is None
    assert mild.gain is not None and mild.gain <= 1.1 * least.lower_bound
    assert largest_entry(mild) < largest_entry(least) / 10
    with pytest.raises(ModelError, match="norm_below"):
        mixed_sensitivity(1 / (s + 1), *weights, norm_below=-1.0)


def test_the_loop_of_a_design_is_proved_by_a_claim() -> None:
    """``certify`` of the closed loop: the gain of the design, a per cent up, exactly."""
    found = mixed_sensitivity(1 / (s + 1), 2 / (s + 0.1), 0.5, 0.2, tolerance=1e-2)
    loop = found.loop
    assert loop is not None and found.gain is not None

    model = TSModel([loop.A], E=[loop.B], C=[loop.C])
    output = (loop.C, None, loop.D)
    proved = certify(model, claims=[L2Gain(gain=1.01 * found.gain, output=output)])
    below = certify(model, claims=[L2Gain(gain=0.98 * found.lower_bound, output=output)])

    assert proved.verdict is Verdict.PROVED
    assert below.verdict is Verdict.UNDECIDED


def test_no_controller_undercuts_the_least_gain() -> None:
    """The LMIs with gamma below: feasible just above the least, infeasible 2 per cent below."""
    found = mixed_sensitivity(1 / (s + 1), 2 / (s + 0.1), 0.5)

    assert decide(objective_below(found.answer, 1.01 * found.lower_bound)).status == "candidate"
    assert decide(objective_below(found.answer, 0.98 * found.lower_bound)).status == "infeasible"


def test_two_channels_with_one_weight_for_both() -> None:
    """Two equal plants side by side: the gain of one of them."""
    one = mixed_sensitivity(1 / (s + 1), 2 / (s + 0.1), 0.5)
    A, B = np.diag([-1.0, -1.0]), np.eye(2)

    both = mixed_sensitivity((A, B, np.eye(2), np.zeros((2, 2))), 2 / (s + 0.1), 0.5)

    assert one.gain is not None and both.gain == pytest.approx(one.gain, rel=3e-3)


def test_a_mode_that_nothing_moves_is_an_answer() -> None:
    """An unstable state that u does not reach: infeasible, with the reason."""
    plant = GeneralisedPlant(
        A=np.diag([1.0, -1.0]),
        B1=np.ones((2, 1)),
        B2=np.array([[0.0], [1.0]]),
        C1=np.array([[1.0, 1.0]]),
        C2=np.array([[1.0, 1.0]]),
        D11=np.zeros((1, 1)),
        D12=np.ones((1, 1)),
        D21=np.ones((1, 1)),
    )

    found = hinf_output_feedback(plant)

    assert found.status == "infeasible" and "u does not move" in found.answer.diagnosis
    condition = hinf_output_feedback_condition(plant)
    assert exact_no(condition) is not None
    with pytest.raises(ModelError, match="no controller was found"):
        found.require()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1 / (s + 1),), "no weight was given"),
        (((s + 2) / (s + 1), 1.0), "direct term"),
        ((1 / (s + 1), 1 / s), "a stable weight"),
        ((1 / (s + 1), np.eye(2)), "W1 has 2 inputs"),
        ((1 / (s + 1), "ten"), "is needed"),
        ((control.tf([1], [1, 0.5], 0.1), 1.0), "bilinear"),
        ((1 / (s + 1), s**2), "cannot be written in state space"),
        (((np.eye(2), np.ones((2, 1)), np.ones((1, 3)), [[0.0]]), 1.0), "do not fit together"),
    ],
)
def test_what_cannot_be_meant_is_refused(arguments: tuple[Any, ...], message: str) -> None:
    """Weights and plants that fit no loop."""
    with pytest.raises(ModelError, match=message):
        mixed_sensitivity(*arguments)
