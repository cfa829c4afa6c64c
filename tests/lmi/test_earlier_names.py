"""Names of earlier versions, which still work."""

from __future__ import annotations

import pytest

import takagi.lmi
from takagi.lmi import Answer, Ladder, pdc_condition
from takagi.lmi.gains.requirements import Requirements
from takagi.models import ModelError, TSModel


@pytest.mark.parametrize(
    ("earlier", "name"),
    [
        ("Fixed", "KnownBlock"),
        ("LyapunovFamily", "PolynomialLyapunov"),
        ("Part", "SumPart"),
        ("Region", "EigenvalueRegion"),
        ("Rung", "RelaxationResult"),
    ],
)
def test_an_earlier_name_is_the_same_class(earlier: str, name: str) -> None:
    """It is found, and warns the line that asks; a star and ``dir`` have present names alone."""
    with pytest.warns(DeprecationWarning, match=f"lmi.{earlier} is now called .*{name}") as told:
        assert getattr(takagi.lmi, earlier) is getattr(takagi.lmi, name)

    assert told[0].filename == __file__
    assert earlier not in dir(takagi.lmi) and name in dir(takagi.lmi)


def test_the_lyapunov_function_of_an_answer_was_its_family() -> None:
    answer = Answer(status="unknown", margin=0.0)

    with pytest.warns(DeprecationWarning, match="now called Answer.lyapunov_function") as told:
        assert answer.family is answer.lyapunov_function
    assert told[0].filename == __file__


def test_the_results_of_a_ladder_were_its_rungs() -> None:
    ladder = Ladder((), None)

    with pytest.warns(DeprecationWarning, match="now called Ladder.results") as told:
        assert ladder.rungs is ladder.results
    assert told[0].filename == __file__


def plant() -> TSModel:
    """Two rules of one unstable state."""
    return TSModel([[[1.0]], [[2.0]]], [[[1.0]], [[1.0]]])


def test_the_requirements_of_a_condition_were_its_demands() -> None:
    """At most one active rule leaves fewer pairs: the argument arrives by either name."""
    apart = Requirements(active_rules=1)
    condition = pdc_condition(plant(), requirements=apart)

    with pytest.warns(DeprecationWarning, match="demands=. is now called requirements=") as told:
        earlier = pdc_condition(plant(), demands=apart)  # type: ignore[call-arg]
    assert told[0].filename == __file__
    assert [lmi.name for lmi in earlier.lmis] == [lmi.name for lmi in condition.lmis]
    assert [lmi.name for lmi in earlier.lmis] != [lmi.name for lmi in pdc_condition(plant()).lmis]


def test_both_names_of_one_argument_are_refused() -> None:
    both = {"requirements": Requirements(), "demands": Requirements()}

    with pytest.raises(ModelError, match="demands and requirements, which are one argument"):
        pdc_condition(plant(), **both)  # type: ignore[arg-type]
