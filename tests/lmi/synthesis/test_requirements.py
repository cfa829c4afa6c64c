"""What pdc is asked besides decay: regions, uncertain plants, memberships that do not all act."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import (
    Design,
    EigenvalueRegion,
    NormBounded,
    ZeroGainsWarning,
    pdc,
    pdc_condition,
    relaxation_ladder,
)
from takagi.lmi.gains.requirements.limits import Requirements
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import pendulum, three_rules

Floats = NDArray[np.float64]


def frozen_eigenvalues(model: TSModel, design: Design) -> NDArray[np.complex128]:
    """Return the eigenvalues of A(h) - B(h) K(h) at 201 blends of two rules."""
    K, _ = design.require()
    h = np.linspace(0, 1, 201)
    h = np.stack([h, 1 - h], axis=1)
    A, B, gain = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    return np.asarray(np.linalg.eigvals(A - B @ gain), dtype=np.complex128).ravel()


@pytest.mark.parametrize(
    "region",
    [
        EigenvalueRegion.half_plane(3.0),
        EigenvalueRegion.disc(2.0, centre=-5.0),
        EigenvalueRegion.vertical_strip(1.0, 5.0),
        EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.disc(9.0),
    ],
    ids=str,
)
@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "tuan"])
def test_eigenvalues_of_all_blends_lie_in_the_region(
    region: EigenvalueRegion, relaxation: str
) -> None:
    """Chilali and Gahinet (1996); without the region some lie outside."""
    model = pendulum()
    free = frozen_eigenvalues(model, pdc(model, decay_rate=0.1, relaxation=relaxation))
    inside = frozen_eigenvalues(
        model, pdc(model, decay_rate=0.1, relaxation=relaxation, region=region)
    )

    assert all(region.contains(z) for z in inside)
    assert not all(region.contains(z) for z in free)


def test_a_half_plane_is_a_decay_rate() -> None:
    """Re z < -alpha as a region and alpha as the rate are feasible for the same gains."""
    rates = pdc(pendulum(), decay_rate="max", gain_bound=300.0).decay_rate

    for share, exists in ((0.99, True), (1.01, False)):
        region = EigenvalueRegion.half_plane(share * rates)
        assert pdc(pendulum(), gain_bound=300.0, region=region).found is exists


def test_a_disc_of_discrete_time_is_a_decay_rate() -> None:
    """|z| < rho as a region and -ln(rho)/T as the rate have the same threshold."""
    model = pendulum(0.05)
    rate = pdc(model, decay_rate="max", gain_bound=300.0).decay_rate

    for share, exists in ((0.99, True), (1.01, False)):
        region = EigenvalueRegion.disc(float(np.exp(-share * rate * 0.05)))
        assert pdc(model, gain_bound=300.0, region=region).found is exists


@pytest.mark.parametrize("unit", [1.0, 2.0**12])
def test_an_uncertain_scalar_needs_the_gain_of_its_worst_plant(unit: float) -> None:
    """x' = (a + d Delta e) x + b u decays for all |Delta| <= 1 when b K > a + d e; in any unit."""
    a, b, d, e = 1.0, 2.0, 0.5, 3.0
    model = TSModel([[[a]]], [[[b / unit]]])
    uncertainty = NormBounded([[d / unit]], [[e * unit]])
    needed = (a + d * e) / b * unit

    for share, exists in ((1.001, True), (0.999, False)):
        design = pdc(model, gain_bound=share * needed, uncertainty=uncertainty)
        assert design.found is exists


@pytest.mark.parametrize("step", [None, 0.05])
def test_every_uncertain_blend_decays_in_the_design_s_own_v(step: float | None) -> None:
    """With 9 1/s^2 of stiffness unknown V still falls; that of the nominal design does not."""
    model = pendulum(step)
    scale = 1.0 if step is None else step
    uncertainty = NormBounded([[0.0], [scale]], [[9.0, 0.0]])

    def worst(design: Design) -> float:
        K, P = design.require()
        found = -np.inf
        for delta in (-1.0, 1.0):
            moved = scale * delta * np.array([[0.0, 0.0], [9.0, 0.0]])
            for h in np.linspace(0, 1, 21):
                A, B, gain = (h * part[0] + (1 - h) * part[1] for part in (model.A, model.B, K))
                G = A + moved - B @ gain
                form = P @ G + G.T @ P if step is None else (G.T @ P @ G - P) / step
                found = max(found, float(np.linalg.eigvalsh(form)[-1]))
        return found

    assert worst(pdc(model, decay_rate=0.0, uncertainty=uncertainty)) < 0
    assert worst(pdc(model, decay_rate=0.0)) > 0


def test_rules_that_never_act_together_need_no_pairs() -> None:
    """At b = 8 no relaxation has gains; where one rule acts at a time there are some."""
    alone = np.where(np.eye(3, dtype=bool), np.inf, 0.0)

    assert pdc(three_rules(8.0), relaxation="auto").status == "infeasible"
    for options in ({"overlap": alone}, {"active_rules": 1}):
        design = pdc(three_rules(8.0), relaxation="auto", **options)
        K, P = design.require()
        for A, B, gain in zip(three_rules(8.0).A, three_rules(8.0).B, K, strict=True):
            G = P @ (A - B @ gain)
            assert np.linalg.eigvalsh(G + G.T)[-1] < 0


def test_fewer_active_rules_buy_something() -> None:
    """Tanaka and Wang (2001), theorem 9: with two of three rules active the slack counts less."""
    assert pdc(three_rules(-2.0), relaxation="tanaka-wang").status == "infeasible"
    assert pdc(three_rules(-2.0), relaxation="tanaka-wang", active_rules=2).found


@pytest.mark.parametrize("relaxation", ["common-gain", "kim-lee", "polya-1"])
def test_sizes_with_demands_are_those_of_the_posed_condition(relaxation: str) -> None:
    """Regions and uncertainty add double sums and rows; the ladder knows before posing."""
    region = EigenvalueRegion.half_plane(0.5) & EigenvalueRegion.sector(1.2)
    block = NormBounded([[0.0], [1.0]], [[1.0, 0.0]])
    result = relaxation_ladder(
        pendulum(), relaxations=[relaxation], region=region, uncertainty=block
    ).results[0]
    requirements = Requirements(region=region, uncertainty=(block,))
    condition = pdc_condition(pendulum(), relaxation=relaxation, requirements=requirements)
    plain = ("Q positive definite", "scale of Q", "input effort")
    lmis = [lmi for lmi in condition.lmis if lmi.name not in plain]

    assert result.lmis == sum(lmi.count for lmi in lmis)
    assert result.width == max(lmi.size for lmi in lmis)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"region": 3.0}, "an EigenvalueRegion is needed"),
        ({"uncertainty": 3.0}, "a NormBounded is needed"),
        ({"uncertainty": NormBounded([[1.0]], [[1.0, 0.0]])}, "uncertainty 1 of 1: D is 1 x 1"),
        ({"active_rules": 0}, "a number from 1 to 2"),
        ({"overlap": np.ones((3, 3))}, r"\(3, 3\)"),
    ],
)
def test_misuse_is_refused(options: dict[str, object], said: str) -> None:
    """The message says what was given."""
    with pytest.raises(ModelError, match=said):
        pdc(pendulum(), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("active", [True, 1.0, 0, 3])
def test_active_rules_are_counted_in_whole_numbers(active: object) -> None:
    """Neither a flag nor a fraction says how many of two rules act."""
    with pytest.raises(ModelError, match="active_rules"):
        pdc(pendulum(), active_rules=active)  # type: ignore[arg-type]


def test_a_part_of_a_region_without_the_loop_is_as_good_for_uncertain_plants() -> None:
    """L < 0 alone, M = 0: every plant keeps it, and the gains are as without it."""
    block = NormBounded(np.array([[0.0], [0.1]]), np.array([[1.0, 0.0]]))

    assert pdc(pendulum(), region=EigenvalueRegion.lmi([[-1.0]], [[0.0]]), uncertainty=block).found
    assert not pdc(
        pendulum(), region=EigenvalueRegion.lmi([[1.0]], [[0.0]]), uncertainty=block
    ).found


def test_gains_that_do_nothing_are_warned_of() -> None:
    """A plant that is stable by itself has gains of zero where no rate is asked for; K is gains."""
    stable = TSModel([[[-1.0, 0.2], [0.0, -2.0]], [[-1.5, 0.0], [0.3, -1.0]]], [[[0.0], [1.0]]] * 2)
    with pytest.warns(ZeroGainsWarning, match="the plant alone meets"):
        design = pdc(stable)
    assert design.K is design.gains is not None
    # Filters make warnings errors: of gains that do something there is none.
    assert pdc(pendulum()).found
