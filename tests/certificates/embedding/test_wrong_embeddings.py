"""Embeddings that are wrong by one digit, sign, term or name are not proved."""

from __future__ import annotations

import pytest

from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from tests.certificates.embedding.plants import (
    one_state,
)
from tests.certificates.kinds.claims import Data, as_read


def loop_verdict(data: Data) -> str:
    """Return the verdict on one claim about the model's loop."""
    read = as_read(data)
    found = replay(read["claim"], None, read_model_loop(read["model"], None), [], "claim")
    return found.verdict.name


def turning(**number: object) -> Data:
    data = one_state("-x/pi", "1", 1, 1)
    listed = {"name": "c", "expression": "1/pi", "lower": "0.3183", "upper": "0.3184"}
    data["embedding"] |= {"premises": [], "numbers": [listed | number], "A": [["-c"]]}
    return data


def test_a_claim_about_the_loop_holds_at_all_ends_of_a_number() -> None:
    """x' = -c x decays at the rate 0.318 for every c in its bounds, and at no greater one."""
    claim = {"name": "decay", "kind": "decay", "P": [[1]], "decay_rate": 0.318}

    assert loop_verdict({"model": turning(), "claim": claim}) == "PROVED"
    assert loop_verdict({"model": turning(upper=0.5), "claim": claim}) == "PROVED"
    assert loop_verdict({"model": turning(lower=0.31), "claim": claim}) == "UNDECIDED"
    assert (
        loop_verdict({"model": turning(), "claim": claim | {"decay_rate": 0.31835}}) == "UNDECIDED"
    )


@pytest.mark.parametrize(
    ("letter", "output", "drift", "bounds"),
    [("C", "(p*p - 2)*x", "", (-1e-6, 1e-6)), ("E", "x", " + (p*p - 3/2)*w", (0, 0.6))],
)
def test_a_number_that_may_vanish_is_refused(
    letter: str, output: str, drift: str, bounds: tuple[float, float]
) -> None:
    """y = 0 x shows no premise, though its factor is not 0 at the ends of its bounds."""
    data = one_state(f"-x - x^3{drift}", "x^2", 0, 1)
    root = {"value": "1.4142135623", "within": "1e-8", "equals": "sqrt(2)"}
    number: Data = {"name": "c", "expression": "p*p - 2" if letter == "C" else "p*p - 3/2"}
    number |= {"lower": bounds[0], "upper": bounds[1]}
    data |= {"parameters": {"p": root}}
    data["outputs"] = [{"name": "y", "unit": "-", "expression": output}]
    data["embedding"] |= {"numbers": [number], "A": [["-1 - z"]], "C": [["1"]]}
    if letter == "E":
        data["disturbances"] = [{"name": "w", "unit": "-", "range": [-1, 1], "rest": 0}]
        data["embedding"] |= {"E": [["c"]]}
    else:
        data["embedding"] |= {"C": [["c"]]}

    with pytest.raises(CertificateError, match="embedding.numbers"):
        read_model_loop(as_read(data), None)
