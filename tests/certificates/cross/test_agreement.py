"""Two checkers, written separately, on the same certificates: true ones and damaged ones."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.audit.two_checkers import (
    VerdictComparison,
    VerdictRow,
    cross_checked,
    cross_checked_document,
)
from takagi.cli.verbs.check import run as check_verb
from tests.certificates.cross.documents import PLANTS, all_kinds, mutants, plant_certificate
from tests.certificates.kinds.test_damage import resealed

Data = dict[str, Any]


@pytest.fixture(scope="module")
def whole() -> dict[str, Data]:
    """Return a certificate of every kind of claim about loops, and of some plants."""
    return dict(all_kinds()) | {name: plant_certificate(name) for name in PLANTS}


def test_every_true_claim_is_seen_twice(whole: dict[str, Data]) -> None:
    """Nineteen certificates: each claim is decided by both, alike, and none is left out."""
    for name, document in whole.items():
        found = cross_checked_document(document)
        assert found.agrees, (name, found.text)
        assert found.replayed == len(document["claims"]), (name, found.text)
        assert {row.first for row in found.rows} <= {"PROVED", "DISPROVED"}, name


def test_all_kinds_of_general_claims_are_among_them(whole: dict[str, Data]) -> None:
    from takagi.certificates.cross_check.opinion import LOOPS

    kinds = {claim["kind"] for document in whole.values() for claim in document["claims"]}
    assert kinds >= {*LOOPS, "sector-embedding"} - {"no-common-decay"}
    assert "no-common-decay" in kinds


def campaign(whole: dict[str, Data], count: int, seed: int) -> tuple[dict[str, int], list[str]]:
    """Return how often which pair of verdicts was met, and where the checkers differ."""
    pairs: dict[str, int] = {}
    differ = []
    for what, document in mutants(list(whole.values()), count, seed):
        found = cross_checked_document(document)
        for row in found.rows:
            pair = f"{row.first} {row.second}"
            pairs[pair] = pairs.get(pair, 0) + 1
        if not found.agrees:
            differ.append(f"{what}\n{found.text}")
    return pairs, differ


@pytest.mark.slow
def test_damaged_certificates_are_seen_alike(whole: dict[str, Data]) -> None:
    """Of 200 damaged ones some are still true, some open, some refused: by both."""
    pairs, differ = campaign(whole, 200, seed=1)

    assert differ == []
    met = [pairs.get(f"{verdict} {verdict}", 0) for verdict in ("PROVED", "UNDECIDED", "REFUSED")]
    assert min(met) > 10, pairs


@pytest.mark.slow
def test_many_damaged_certificates_are_seen_alike(whole: dict[str, Data], reduced: bool) -> None:
    """The same with another seed, five thousand times (reduced: 300)."""
    assert campaign(whole, 300 if reduced else 5_000, seed=2)[1] == []


@pytest.mark.parametrize("lower", ["text", "upper"])
def test_a_law_s_own_weights_sum_to_one(whole: dict[str, Data], lower: str) -> None:
    """A premise that is not a number, or a constant beside rules for two ends: refused by both."""
    refused = 0
    for document in whole.values():
        gains = document["gains"]
        if not gains or not gains.get("premises") or len(gains["K"]) < 2:
            continue
        changed = deepcopy(document)
        premise = changed["gains"]["premises"][0]
        premise["lower"] = premise["upper"] if lower == "upper" else "1"
        found = cross_checked_document(resealed(changed))
        assert found.agrees, found.text
        refused += {"REFUSED"} == {row.first for row in found.rows} & {r.second for r in found.rows}
    assert refused > 3


def test_turbine_is_decided_twice(short: Data) -> None:
    """The matrices of the effort-sharing loop, and that its ranges enclose the turbine."""
    found = cross_checked_document(short)

    assert found.agrees
    assert found.replayed == 1
    assert found.rows[0].inequalities > 300
    assert (found.rows[0].first, found.rows[0].second) == ("PROVED", "PROVED")


def test_turbine_s_inequalities_can_fail(short: Data) -> None:
    short["claims"][0]["cells"][2]["decay_rate"] = 1.0

    found = cross_checked_document(resealed(short))

    assert found.agrees
    assert (found.rows[0].first, found.rows[0].second) == ("UNDECIDED", "UNDECIDED")


def test_difference_is_shown_and_fails(
    whole: dict[str, Data], tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    """A second checker that sees nothing makes the verb end with 1."""
    from takagi.certificates.cross_check.kernel import exact

    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(whole["lorenz"]))
    assert check_verb([str(path), "--cross"]) == 0
    assert "6 of 6 claims replayed twice: they agree" in capsys.readouterr().out

    monkeypatch.setattr(exact, "is_definite", lambda *_, **__: False)

    assert not cross_checked(path).agrees
    assert check_verb([str(path), "--cross"]) == 1
    assert "THEY DIFFER" in capsys.readouterr().out


def test_changed_file_is_refused_by_both(whole: dict[str, Data], tmp_path: Path) -> None:
    document = deepcopy(whole["lorenz"])
    document["model"]["parameters"]["a"] = 11
    path = tmp_path / "certificate.json"
    path.write_text(json.dumps(document))

    found = cross_checked(path)

    assert [(row.first, row.second) for row in found.rows] == [("REFUSED", "REFUSED")]
    assert found.agrees


@pytest.mark.parametrize(
    ("first", "second", "agree"),
    [
        ("PROVED", "PROVED", True),
        ("PROVED", "NOT REPLAYED", True),
        ("UNDECIDED", "REFUSED", True),
        ("PROVED", "UNDECIDED", False),
        ("UNDECIDED", "PROVED", False),
        ("REFUSED", "PROVED", False),
        ("DISPROVED", "UNDECIDED", False),
        ("DISPROVED", "PROVED", False),
    ],
)
def test_what_counts_as_agreement(first: str, second: str, agree: bool) -> None:
    assert VerdictComparison([VerdictRow("any", first, second, 1, "")]).agrees is agree


@pytest.mark.parametrize("claims", [None, [], {}, 1, "coherent-loop"])
def test_a_file_without_a_list_of_claims_is_refused_by_both(short: Data, claims: Any) -> None:
    """Neither checker walks over what is no list."""
    short["claims"] = claims

    found = cross_checked_document(resealed(short))

    assert [(row.first, row.second) for row in found.rows] == [("REFUSED", "REFUSED")]
