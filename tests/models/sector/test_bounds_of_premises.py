"""Bounds of premises: proofs that replay, wrong bounds refused, samples that say what they are."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

import pytest
import sympy as sp

from takagi.certificates import certify
from takagi.lmi.explaining.explanation import with_narrower_premise
from takagi.models import (
    Interval,
    ModelError,
    Plant,
    Premise,
    TSModel,
    Variable,
    load_model,
    sampled_bounds,
    sector_model,
)

Q, P, U = sp.symbols("q p u", real=True)
Z1 = sp.Symbol("z1", real=True)
S = sp.Symbol("s", real=True)
GIVEN = {S: sp.sin(Q) / Q}


def arm(friction: sp.Expr = P) -> Plant:
    """Return q'' = -sin q - friction(p) + u, |q| <= 1.5, |p| <= 1."""
    return Plant(
        states=(
            Variable(Q, "rad", Interval.of("-1.5", "1.5")),
            Variable(P, "rad/s", Interval.of(-1, 1)),
        ),
        inputs=(Variable(U),),
        equations=(P, -sp.sin(Q) - friction + U),
        name="arm",
    )


@lru_cache
def proved() -> TSModel:
    return sector_model(arm(), premises=GIVEN)


def moved(premise: Premise, lower: Fraction, upper: Fraction) -> Premise:
    return Premise(premise.name, lower, upper, proof=premise.proof)


@pytest.mark.parametrize("name", ["cart_pole", "tora", "quarter_car", "lorenz"])
def test_every_premise_of_a_model_replays(name: str) -> None:
    """The boxes of each premise's proof give a range inside its bounds, and nearly as wide."""
    for premise in sector_model(load_model(name)).premises:  # type: ignore[arg-type]
        found = premise.replay()
        assert premise.bounds.contains(found)
        assert found.width >= Fraction(99, 100) * premise.bounds.width


def test_a_wrong_bound_is_refused_on_replay() -> None:
    (premise,) = proved().premises
    part = premise.bounds.width / 1000
    low, high = premise.lower, premise.upper

    for lower, upper in ((low + part, high), (low, high - part)):
        with pytest.raises(ModelError, match=r"premise s: the bounds .* are not proved"):
            moved(premise, lower, upper).replay()
    assert moved(premise, low - part, high + part).replay() == premise.replay()
    with pytest.raises(ModelError, match="keeps no proof to replay"):
        Premise("z", 0, 1).replay()


# sin(3/2)/(3/2) = 0.66499665...
@pytest.mark.parametrize("ends", [("0.66499666", "1.1"), ("0.6649", "0.99999999"), ("0.7", "1")])
def test_wrong_bounds_that_are_given_are_refused(ends: tuple[str, str]) -> None:
    """Less than the range by 1e-8 at an end, although the model's tolerance is 1e-3."""
    with pytest.raises(ModelError, match="leave out values that it attains"):
        sector_model(arm(), premises=GIVEN, bounds={S: ends})


def test_right_bounds_that_are_given_are_confirmed() -> None:
    model = sector_model(arm(), premises=GIVEN, bounds={S: ("0.66499665", "1.00000001")})
    (premise,) = model.premises

    assert premise.bounds == Interval.of("0.66499665", "1.00000001")
    assert "confirmed by ball arithmetic" in premise.evidence
    assert premise.bounds.contains(premise.replay())


def test_exact_bounds_tell_what_their_proof_misses() -> None:
    """The supremum 1 itself cannot be confirmed with rounding; the words say how near it came."""
    model = sector_model(arm(), premises=GIVEN, bounds={S: ("0.6", 1)})
    (premise,) = model.premises

    assert premise.upper == 1
    if premise.proof is None:
        assert "proves them but for" in premise.evidence
        with pytest.raises(ModelError, match="keeps no proof"):
            premise.replay()
    else:
        assert premise.bounds.contains(premise.replay())


# ------------------------------------------------------------------ samples


def with_zeta() -> Plant:
    """Return the arm with friction p zeta(2 + p^2), which has no ball arithmetic."""
    return arm(P * sp.zeta(2 + P**2))


def test_a_function_without_enclosure_is_refused_with_both_cures() -> None:
    with pytest.raises(ModelError, match=r"no ball arithmetic for zeta.*sampled_bounds"):
        sector_model(with_zeta(), premises={S: sp.zeta(2 + P**2)})


def sampled() -> TSModel:
    return sector_model(with_zeta(), premises={S: sp.zeta(2 + P**2)}, sampled_bounds=[S])


def test_sampled_bounds_say_so_everywhere() -> None:
    """Premise, model and derivation tell; zeta(3) = 1.2020569 <= z <= zeta(2) = pi^2/6."""
    model = sampled()
    premise = next(p for p in model.premises if p.name == "s")

    assert model.sampled == ("s",)
    assert premise.sampled and premise.proof is None
    assert "sampled" in premise.evidence and "no proof" in premise.evidence
    assert model.derivation is not None
    assert "bounds of s sampled, which is no proof" in model.derivation.exactness
    assert float(premise.lower) == pytest.approx(1.2020569, abs=0.01)
    assert float(premise.upper) == pytest.approx(1.6449341, abs=0.01)
    assert proved().sampled == ()


def test_nothing_is_certified_with_sampled_bounds() -> None:
    model = sampled()
    number = [premise.name for premise in model.premises].index("s")

    for doubtful in (model, with_narrower_premise(model, number, Fraction(1, 2))):
        with pytest.raises(ModelError, match="bounds of s are sampled, which is no proof"):
            certify(doubtful)


def test_bounds_found_by_sampling_are_taken_as_sampled() -> None:
    """What ``sampled_bounds`` found keeps its words when it is given."""
    found = sampled_bounds(sp.sin(Q) / Q, {Q: Interval.of("0.1", "1.5")}, points=50)
    model = sector_model(arm(), premises=GIVEN, bounds={S: found})

    assert model.sampled == ("s",)
    assert "sampled at 50" in model.premises[0].evidence


def test_bounds_of_a_function_without_enclosure_are_tried_on_samples() -> None:
    wanted = {S: sp.zeta(2 + P**2)}
    model = sector_model(with_zeta(), premises=wanted, bounds={S: (1, 2)})

    assert model.sampled == ("s",)
    assert "cannot be enclosed" in next(p for p in model.premises if p.name == "s").evidence
    with pytest.raises(ModelError, match="leave out sampled values"):
        sector_model(with_zeta(), premises=wanted, bounds={S: ("1.4", 2)})


def test_a_singularity_inside_a_root_can_be_given_but_not_proved() -> None:
    """sqrt(sin q / q) at 0: no enclosure tells it from a pole, so given bounds rest on samples."""
    root = sp.sqrt(sp.sin(Q) / Q)

    def model(**options: Any) -> TSModel:
        plant = Plant(
            equations=(P, -root * P + U),
            states=(Variable(Q, "-", Interval.of("-1.5", "1.5"), Fraction(1)), Variable(P)),
            inputs=(Variable(U),),
            premises={S: root},
        )
        return sector_model(plant, **options)

    with pytest.raises(ModelError, match="no finite bound near .* a premise of its own"):
        model()
    assert model(bounds={S: ("0.8", "1.1")}).sampled == ("s",)
    with pytest.raises(ModelError, match="leave out sampled values"):
        model(bounds={S: ("0.9", "1.1")})


def test_given_bounds_of_a_pole_are_refused() -> None:
    """tan(2 q) on [-1, 1] has poles at pi/4: the samples leave any bounds."""
    pole = Plant(
        states=(Variable(Q, "rad", Interval.of(-1, 1)),),
        inputs=(Variable(U),),
        equations=(Q * sp.tan(2 * Q) + U,),
        premises={S: sp.tan(2 * Q)},
    )
    with pytest.raises(ModelError, match="leave out sampled values"):
        sector_model(pole, bounds={S: (-5, 5)})


def test_misuse_names_the_premise() -> None:
    with pytest.raises(ModelError, match="sampled bounds of q were given; the premises are z1"):
        sector_model(arm(), sampled_bounds=[Q])
    with pytest.raises(ModelError, match="bounds of z1 are given and to be sampled"):
        sector_model(arm(), bounds={Z1: (0, 2)}, sampled_bounds=[Z1])
