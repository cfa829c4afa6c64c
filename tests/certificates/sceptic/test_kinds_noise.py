"""The bound under white noise needs weights that do not know the noise of the same instant.

x+ = s x / 2 + w with s = 1 or -1 has the mean of x^2 at most 1 / (1 - 1/4) = 4/3 for white noise of
unit covariance.  Take w = 1 or -1, each with probability 1/2, and let the weights choose s = 1
where x w >= 0 and -1 elsewhere: then |x+| = |x| / 2 + 1, which tends to 2, and x^2 to 4.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from takagi.certificates import Verdict
from takagi.certificates.checker import read_text
from takagi.certificates.checker.loop.model_loop import read_model_loop
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.replay.claim_kinds import replay
from tests.certificates.kinds.claims import model_data, said_of

Data = dict[str, Any]
HALVES = model_data([[[0.5]], [[-0.5]]], sample_time=1, B=[[[1]]], E=[[[1]]], C=[[[1]]])
HALVES |= {"input_names": ["u [-]"], "disturbance_names": ["w [-]"]}
CLAIM: Data = {"name": "a", "kind": "h2-norm", "P": [[1.334]], "norm": 1.156}
CLAIM |= {"disturbance": "disturbances"}


def test_words_name_the_assumption_where_the_model_does_not_say() -> None:
    found = said_of(HALVES, None, CLAIM)

    assert found.verdict is Verdict.PROVED
    assert "for weights that do not depend on the noise at the same instant" in found.text


def said_with(*scheduling: str, way: str = "disturbances") -> Verdict:
    """Return the verdict where the premises are known to depend on these."""
    text = str({**HALVES, "claim": CLAIM | {"disturbance": way}})
    data = read_text(text.replace("'", '"').replace("None", "null"), "model")
    family: PolytopicLoop = replace(read_model_loop(data, None), scheduled_by=scheduling)
    return replay(data["claim"], None, family, [], "claim").verdict


def test_premises_that_are_the_noise_prove_nothing() -> None:
    assert said_with("x1 [-]") is Verdict.PROVED
    assert said_with("x1 [-]", "w [-]") is Verdict.UNDECIDED
    assert said_with("u [-]") is Verdict.PROVED
    assert said_with("u [-]", way="inputs") is Verdict.UNDECIDED
